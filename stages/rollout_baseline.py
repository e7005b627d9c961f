"""Stage rollout_baseline@<name>: K futures of every test scenario by a generator that learns nothing, each judged.

argv: scenarios (folder of shards), models (folder), generated (folder; its name is the generator's). Only the legal checker's
limits are taken of the models: nothing that is trained can change what stands here.
"""

from stages._without_goals import Params as Params
from stages._without_goals import main as main
