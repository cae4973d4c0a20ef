"""Live a campaign of many epochs through the real store, and measure whether size, speed and memory creep.

`.venv/bin/python -m tests.faults.long_life [--epochs 1000] [--every 100] [--out FILE.json] [--folder DIR]` processes one
simulated epoch, publishes as many more as asked for with its rows moved by noise, each by a run of its own, every
tenth twice, and measures after every 100. At the end a real `tiltwatch run --only-new` finds one epoch more, and
another one finds nothing; `tiltwatch verify` looks at all of it. Exit code 1 where anything creeps.
"""

import argparse
import json
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

from tests.faults.long_life.life import begun_life
from tests.faults.long_life.measures import Point, creeping, point_of
from tests.faults.long_life.real_runs import real_runs
from tests.faults.long_life.template import processed_template


def main() -> int:
    """Live, measure and write."""
    parser = argparse.ArgumentParser("python -m tests.faults.long_life", description=__doc__)
    parser.add_argument("--epochs", type=int, default=1000)
    parser.add_argument("--every", type=int, default=100)
    parser.add_argument("--assess-every", type=int, default=1, help="epochs from one assessment to the next")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--folder", type=Path, help="an empty folder; a temporary one where missing")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = asked.folder or Path(name)
        points, runs = lived(folder, asked.epochs, asked.every, asked.assess_every)
    found = creeping(points)
    content = {"points": [asdict(point) for point in points], "real_runs": runs, "creeping": found}
    if asked.out is not None:
        asked.out.write_text(json.dumps(content, indent=1), encoding="utf-8")
    sys.stdout.write("".join(f"{line}\n" for line in found) or "nothing creeps\n")
    return 1 if found or any(run["exit_code"] for run in runs) else 0


def lived(
    folder: Path, epochs: int, every: int, assess_every: int = 1
) -> tuple[list[Point], list[dict[str, object]]]:
    """Points after every so many epochs, and the real runs at the end."""
    template = processed_template(folder / "template")
    life = begun_life(template, folder / "life", epochs, assess_every)
    points = []
    for number in range(epochs):
        life.live(number)
        if (number + 1) % every == 0:
            points.append(point_of(life.workspace, number + 1, life.taken()))
            sys.stdout.write(f"{json.dumps(asdict(points[-1]))}\n")
            sys.stdout.flush()
    return points, real_runs(life)


if __name__ == "__main__":
    sys.exit(main())
