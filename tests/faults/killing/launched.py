"""The command line with its steps counted: ``python -m tests.faults.killing.launched WORKSPACE STEP FILE WORDS...``.

It is killed before the step of that number (0: none); the steps that were done are written to FILE at its end.
"""

import sys
from pathlib import Path

from tests.faults.killing.file_steps import Steps


def launch(workspace: Path, kill_at: int, told: Path, words: list[str]) -> int:
    """Call the command line; gives its exit code."""
    steps = Steps(workspace, kill_at)
    steps.watch()
    from flows.cli import main  # noqa: PLC0415 (a start is counted whole)

    code = main(words)
    told.write_text("\n".join(steps.done), encoding="utf-8")
    return code


if __name__ == "__main__":
    sys.exit(launch(Path(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]), sys.argv[4:]))
