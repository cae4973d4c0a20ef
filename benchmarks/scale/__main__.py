"""How a campaign scales over workers, and what an epoch takes of disk, processors and S3 requests.

`.venv/bin/python -m benchmarks.scale COMMAND --help` for each command; each prints Markdown:

dask     the same campaign on one Dask worker and on two: wall time, their ratio, and where the processor time went
figures  what an epoch takes: bytes of scans, artifacts, records and tables, processor seconds, requests to an S3 store
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from benchmarks.scale import figures, speed

COMMANDS: Final[Mapping[str, Callable[[Sequence[str]], None]]] = {"dask": speed.main, "figures": figures.main}


def main() -> None:
    """Hand the arguments to the command."""
    if len(sys.argv) < 2 or sys.argv[1] not in COMMANDS:
        raise SystemExit(__doc__)
    COMMANDS[sys.argv[1]](sys.argv[2:])


if __name__ == "__main__":
    main()
