"""A child that falls at its second case, sleeps through none, and never ends its fourth: for the test of the parent."""

import json
import os
import signal
import sys

FALLS_AT, HANGS_AT = 1, 3


def main() -> None:
    """Pretend to run cases; arguments as of the child that does."""
    start, stop, step, _ = (int(text) for text in sys.argv[1:5])
    for number in range(start, stop, step):
        _tell({"begins": number})
        if number == FALLS_AT:
            os.kill(os.getpid(), signal.SIGSEGV)
        while number == HANGS_AT:
            pass
        _tell({"case": number, "family": "las", "outcome": "same", "why": "", "cpu": 0.0, "peak": 0})


def _tell(answer: dict[str, object]) -> None:
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
