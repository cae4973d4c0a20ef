"""What registration does to the lean vector: ours beside its peers, on campaigns whose truth is known.

`.venv/bin/python -m benchmarks.registration COMMAND --help` for each command:

campaigns   every method on the same simulated campaigns; stated sigma of the poses against their scatter
scenarios   awkward campaigns: what is said of them, and what becomes of the lean
speed       wall time and peak memory of registration alone, ours and small_gicp's, in one run
shared      the campaign of another generator: true poses against ours
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from benchmarks.registration import campaigns, scenarios, shared_campaign, speed

COMMANDS: Final[Mapping[str, Callable[[Sequence[str]], None]]] = {
    "campaigns": campaigns.main,
    "scenarios": scenarios.main,
    "speed": speed.main,
    "shared": shared_campaign.main,
}


def main() -> None:
    """Hand the arguments to the command."""
    if len(sys.argv) < 2 or sys.argv[1] not in COMMANDS:
        raise SystemExit(__doc__)
    COMMANDS[sys.argv[1]](sys.argv[2:])


if __name__ == "__main__":
    main()
