"""What one epoch more costs a campaign that has many."""

import shutil
from collections.abc import Sequence
from pathlib import Path

from benchmarks.one_more_epoch import GrowingCampaign
from benchmarks.results.section import Section
from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign

STATIONS = 4
POINTS = 20_000
REPEATS = 2


def more_epochs(folder: Path, sizes: Sequence[int]) -> Section:
    """Runs that find one epoch more, and runs that find nothing new."""
    home = folder / "epochs"
    shutil.rmtree(home, ignore_errors=True)
    request = SimulatedCampaignRequest(epochs=max(sizes) + REPEATS, stations=STATIONS, points=POINTS)
    campaign = GrowingCampaign(write_simulated_campaign(home / "campaign", request), home / "ws")
    rows = []
    for size in sizes:
        campaign.run(size)
        more = [campaign.run(size + number + 1) for number in range(REPEATS)]
        nothing = [campaign.run(size + REPEATS) for _ in range(REPEATS)]
        rows.append([str(size), f"{min(more):.1f}", f"{min(nothing):.1f}"])
    return Section(
        "One epoch more",
        "python -m benchmarks.one_more_epoch",
        f"The whole `tiltwatch run --only-new`; {STATIONS} stations of {POINTS:,} points, so that the rest shows.",
        ["epochs there", "one more, s", "nothing new, s"],
        rows,
    )
