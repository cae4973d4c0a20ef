"""Crowd a workspace with eight processes for a while, and tell everything that is wrong.

`.venv/bin/python -m tests.faults.crowding [--seconds 300] [--seed 8] [--epochs 4] [--out FILE.json] [--folder DIR]`: two
`run`s, one of which changes the settings, a `watch` that is sent epochs and late stations, `verify`, reports and states,
deeds on alarms and exports, a dashboard with a visitor, and a reader with plain DuckDB. Exit code 1 with findings.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

from tests.faults.crowding.crowding import crowded


def main() -> int:
    """Crowd, judge and write."""
    parser = argparse.ArgumentParser("python -m tests.faults.crowding", description=__doc__)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--seed", type=int, default=8)
    parser.add_argument("--epochs", type=int, default=4, help="epochs that come through the inbox")
    parser.add_argument("--points", type=int, default=40_000, help="points of a station")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--folder", type=Path, help="an empty folder; a temporary one where missing")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        told = crowded(asked.folder or Path(name), asked.seconds, asked.seed, asked.epochs, asked.points)
    text = json.dumps({"seconds": asked.seconds, "seed": asked.seed, **told}, indent=1)
    if asked.out is not None:
        asked.out.write_text(text, encoding="utf-8")
    sys.stdout.write(f"{text}\n")
    return 1 if told["findings"] else 0


if __name__ == "__main__":
    sys.exit(main())
