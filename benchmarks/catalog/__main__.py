"""What a workspace of many epochs costs: catalog, publication, readers and campaign file, by the number of epochs.

`.venv/bin/python -m benchmarks.catalog [--epochs 1000] [--repeats 3] [--workspace DIR]` makes a workspace of made-up
epochs as large as real ones (8 stations, 14 schemes and methods of 100 slices) and measures it at 10, 100, ... epochs up
to the number asked for. Times are the least of several, in seconds; "one more" is what a run adds for its own epoch.
Some minutes and 1.5 GB of disk for 1,000 epochs.
"""

import argparse
import tempfile
from pathlib import Path

from benchmarks.catalog.measures import Row, measured
from benchmarks.catalog.workspace import grown_workspace


def main() -> None:
    """Measure and print a Markdown table."""
    parser = argparse.ArgumentParser(
        "python -m benchmarks.catalog", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--epochs", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--workspace", type=Path, help="a folder of its own; a temporary one where missing")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        _report(asked.workspace or Path(folder) / "ws", asked.epochs, asked.repeats)


def _report(folder: Path, n_epochs: int, repeats: int) -> None:
    sizes = [size for size in (10, 100, 1000, 10_000) if size < n_epochs] + [n_epochs]
    print("| what | " + " | ".join(f"{size:,} epochs" for size in sizes) + " |")
    print("|---|" + "---|" * len(sizes))
    columns: list[list[Row]] = []
    for size in sizes:
        columns.append(measured(grown_workspace(folder, size), size, repeats))
    for rows in zip(*columns, strict=True):
        print(f"| {rows[0].what} | " + " | ".join(row.shown for row in rows) + " |")


if __name__ == "__main__":
    main()
