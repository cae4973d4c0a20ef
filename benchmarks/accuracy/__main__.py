"""How near the truth the estimators come, and whether they know it: simulated shafts, peers, real scans.

`.venv/bin/python -m benchmarks.accuracy COMMAND --help` for each command; each prints Markdown tables:

efficiency   scatter of the lean against the Cramer-Rao bound: arcs, noise, points on a ladder or a platform
coverage     simulated campaigns whose stated 95 % region holds the truth: noise, poses, levels, rough and oval walls
sigmas       stated sigma of the points, bootstrap and truth on the same campaigns
peers        ours, the paper's method and other packages on the same clouds: error and time
real         real stems and a lamp post: every estimator beside every other, and what it refuses
kinds        every kind of structure simulated from its scans to its lean: error, stated sigma, coverage
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from benchmarks.accuracy import coverage, efficiency, kinds, peers, real, sigmas

COMMANDS: Final[Mapping[str, Callable[[Sequence[str]], None]]] = {
    "efficiency": efficiency.main,
    "coverage": coverage.main,
    "sigmas": sigmas.main,
    "peers": peers.main,
    "real": real.main,
    "kinds": kinds.main,
}


def main() -> None:
    """Hand the arguments to the command."""
    if len(sys.argv) < 2 or sys.argv[1] not in COMMANDS:
        raise SystemExit(__doc__)
    COMMANDS[sys.argv[1]](sys.argv[2:])


if __name__ == "__main__":
    main()
