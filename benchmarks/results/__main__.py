"""The figures of this program, measured on this machine and written to benchmarks/RESULTS.md.

`make bench`, or `.venv/bin/python -m benchmarks.results [SECTION ...]` for some of: points, las, stations, cores,
start, queries, dashboard, peers, epochs. Sections that are measured replace theirs in the file, the others stay. Scans are
simulated once into --folder. With `--millions 1 10 100` it takes about an hour and 20 GB of disk.
"""

import argparse
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from benchmarks.results.dashboard import visits
from benchmarks.results.epochs import more_epochs
from benchmarks.results.growth import by_cores, by_points, by_points_of_las, by_stations
from benchmarks.results.machine import ROOT
from benchmarks.results.peers import beside_peers
from benchmarks.results.queries import query_times
from benchmarks.results.report import put_section
from benchmarks.results.section import Section
from benchmarks.results.start import starts

Measurement = Callable[[argparse.Namespace, Path], Section]

SECTIONS: Mapping[str, Measurement] = {
    "points": lambda asked, folder: by_points(folder, asked.millions),
    "las": lambda asked, folder: by_points_of_las(folder, asked.millions),
    "stations": lambda asked, folder: by_stations(folder, asked.points // 8, asked.stations),
    "cores": lambda asked, folder: by_cores(folder, asked.points),
    "start": lambda _asked, folder: starts(folder, 160_000),
    "queries": lambda asked, folder: query_times(folder, asked.epochs),
    "dashboard": lambda _asked, folder: visits(folder, 160_000),
    "peers": lambda asked, folder: beside_peers(folder, asked.points),
    "epochs": lambda _asked, folder: more_epochs(folder, (1, 10, 30)),
}


def main() -> None:
    """Measure section by section; what is done is written at once."""
    parser = argparse.ArgumentParser(
        "python -m benchmarks.results", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("sections", nargs="*", choices=[*SECTIONS, []], help="all where none is named")
    parser.add_argument("--millions", type=float, nargs="+", default=[1, 2, 10], help="points of `points`")
    parser.add_argument("--points", type=int, default=5_000_000, help="points of the other sections")
    parser.add_argument("--stations", type=int, nargs="+", default=[2, 4, 8, 16])
    parser.add_argument("--epochs", type=int, default=1000, help="of `queries`")
    parser.add_argument("--folder", type=Path, help="keeps simulated scans; a temporary one where missing")
    parser.add_argument("--out", type=Path, default=ROOT / "benchmarks" / "RESULTS.md")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = asked.folder or Path(name)
        for section in asked.sections or SECTIONS:
            put_section(asked.out, section, SECTIONS[section](asked, folder))


if __name__ == "__main__":
    main()
