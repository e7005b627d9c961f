"""The legal checker (paper, scenario rollout): does a trajectory obey traffic rules, avoid others, and can it be driven?

`limits` holds the numbers, `calibration` sets them from logs, `scene` is the entrance; the other files are one family
of rules each, as numba kernels.
"""
