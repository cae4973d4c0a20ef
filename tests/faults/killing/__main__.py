"""The recorded run: ``python -m tests.faults.killing --moments 200 --seed 8 --out FILE.json``."""

import argparse
import json
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tests.faults.killing.moments import Figures
from tests.faults.killing.side_by_side import counted, kill_runs, together
from tests.faults.killing.storage_steps import kill_at_steps_apart


def main() -> int:
    """Kill whole runs at moments, then a writer at every step of storage; gives 0 where nothing was found."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--moments", type=int, default=200)
    asked.add_argument("--seed", type=int, default=8)
    asked.add_argument("--every", type=int, default=1, help="every so many steps of storage; 0: none")
    asked.add_argument("--side-by-side", type=int, default=1, help="so many workspaces at once")
    asked.add_argument("--out", type=Path, required=True)
    words = asked.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="tiltwatch-killing-"))
    try:
        runs = kill_runs(folder, words.moments, words.seed, words.side_by_side)
        _write(words.out, runs, None)
        steps = kill_at_steps_apart(folder / "steps", words.every, words.seed) if words.every else None
        _write(words.out, runs, steps)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return 1 if any(one.faults for one in runs) or (steps and steps["faults"]) else 0


def _write(out: Path, runs: Sequence[Figures], steps: object) -> None:
    """All figures as JSON: those of the workspaces together."""
    told = counted(together(runs))
    out.write_text(json.dumps({"runs": told, "steps": steps}, indent=1), encoding="utf-8")
    sys.stdout.write(out.read_text(encoding="utf-8"))


if __name__ == "__main__":
    raise SystemExit(main())
