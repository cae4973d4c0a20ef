"""What one epoch more costs a campaign that has many: the whole `tiltwatch run --only-new`, start and all.

`.venv/bin/python -m benchmarks.one_more_epoch [--epochs 100] [--points 20000] [--stations 4] [--repeats 3]` simulates a
campaign, processes it, and times runs that find one epoch more, and runs that find nothing new, with 1, 10, 100 epochs
there. Small scans: what does not depend on them is what grows. Seconds, the least of the repeats; some minutes.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign


def main() -> None:
    """Measure and print a Markdown table."""
    parser = argparse.ArgumentParser("python -m benchmarks.one_more_epoch", description=__doc__)
    parser.add_argument("--epochs", type=int, default=100)
    parser.add_argument("--points", type=int, default=20_000, help="points of a station")
    parser.add_argument("--stations", type=int, default=4)
    parser.add_argument("--repeats", type=int, default=3)
    asked = parser.parse_args()
    sizes = [size for size in (1, 10, 100, 1000) if size < asked.epochs] + [asked.epochs]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        request = SimulatedCampaignRequest(
            epochs=asked.epochs + asked.repeats, stations=asked.stations, points=asked.points
        )
        campaign = GrowingCampaign(write_simulated_campaign(folder / "campaign", request), folder / "ws")
        print("| epochs there | one more, s | nothing new, s |\n|---|---|---|")
        for size in sizes:
            campaign.run(size)
            more = [campaign.run(size + number + 1) for number in range(asked.repeats)]
            nothing = [campaign.run(size + asked.repeats) for _ in range(asked.repeats)]
            print(f"| {size} | {min(more):.1f} | {min(nothing):.1f} |", flush=True)


class GrowingCampaign:
    """A campaign file that can be cut to its first epochs."""

    def __init__(self, file: Path, workspace: Path) -> None:
        self._file, self._workspace = file, workspace
        self._head, *self._epochs = file.read_text(encoding="utf-8").split("\n[[epochs]]\n")

    def run(self, epochs: int) -> float:
        """Run with the first epochs alone; seconds."""
        text = "\n[[epochs]]\n".join([self._head, *self._epochs[:epochs]])
        self._file.write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "flows.cli", "-q", "run", str(self._file), "--only-new"]
        began = time.perf_counter()
        subprocess.run([*command, "--workspace", str(self._workspace)], check=True, stdout=subprocess.DEVNULL)
        return time.perf_counter() - began


if __name__ == "__main__":
    main()
