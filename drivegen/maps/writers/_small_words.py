"""Words that say nothing of a road: grammar and manners (never listed as ignored), and the narration of reports."""

import re

SMALL_WORDS = frozenset(
    re.findall(
        r"\w+",
        """
        a an the of in on at to and or with for from by as is are be it its that this there has have where which who
        into onto each every all both only just please create generate make draw build give me us i we want would like
        need map scene scenario road network layout show simple typical basic standard normal ordinary about around
        approximately roughly some then one no not without two way through across over between after before near along
        up down when while their them they he she you your my our also very quite another same other first second last
        next end ends side sides here than more most less any s t d setting design set use using but must can should followed row
        together come comes joined joining controlled control angle meeting linked connected connecting connects placed
        located goes go runs running going traffic style real really kind sort thing place situated version picture
        """,
    )
)
NARRATIVE = frozenset(
    re.findall(
        r"\w+",
        """
        unit units travelling traveling driving drove driven north south east west northbound southbound collided collision
        crash crashed accident incident struck hit occurred happened location scene driver drivers pedestrian vehicle was were
        question sheet figure fig theory approaching proceed everyone study existing conditions proposed improvement site report
        simulation
        test embodiment wherein said comprising comprises provided having plurality substantially arranged kindly near house
        """,
    )
)
"""Listed as ignored, but no sign that the road was misread."""
