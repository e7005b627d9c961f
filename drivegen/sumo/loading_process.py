"""The process in which SUMO loads networks one after the other, started by `loading.load_all`.

libsumo crashes the process on some networks, so it lives alone: it is run by path and imports nothing of ours. The file
`loaded` gets one line per network that was loaded and stepped once; whoever started it sees where it stopped.
"""

import resource
import sys
import warnings
from pathlib import Path

MEMORY = 6 * 1024**3
_QUIET = ["--no-step-log", "true", "--no-warnings", "true", "--xml-validation", "never", "--xml-validation.net", "never"]


def main(folder: Path, first: int, count: int, seconds: int) -> None:
    """Load the networks `first` to `count` - 1 of `folder`, named <number>.net.xml."""
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.filterwarnings("ignore", message="pyarrow .* might be incompatible with libsumo")
    import libsumo

    with (folder / "loaded").open("w") as loaded:
        for i in range(first, count):
            libsumo.start(["sumo", "-n", str(folder / f"{i}.net.xml"), *_QUIET])
            libsumo.simulationStep()
            libsumo.close()
            loaded.write(f"{i}\n")
            loaded.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]), *map(int, sys.argv[2:]))
