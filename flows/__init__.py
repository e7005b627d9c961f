"""When the pipeline runs, how often, and side by side with what; never what it computes.

Flows reach the work through DVC alone (`flows/pipeline.py`), so `dvc repro` without them gives the same bytes.
"""


class FlowFailed(RuntimeError):
    """Why a flow cannot go on, in one sentence."""
