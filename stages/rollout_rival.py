"""Stage rollout_rival@<name>: K futures of every test scenario by a trained generator to compare with, each judged.

argv: scenarios (folder of shards), models (folder), generated (folder; its name is the rival's). As stage rollout, but
rivals know neither goals nor planners, so nothing of DriveGen's own but the checker can change what stands here.
"""

from stages._without_goals import Params as Params
from stages._without_goals import main as main
