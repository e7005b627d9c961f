"""`python -m stages._door WORD PATH...`, which stages/run does with the project's Python."""

import sys

from stages._door import enter

if __name__ == "__main__":
    enter(*sys.argv[1:])
