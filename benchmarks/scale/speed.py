"""The same campaign on one Dask worker and on two."""

import argparse
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.scale.processor_time import processor_seconds
from benchmarks.scale.servers import prefect_for
from storage.parquet import read_rows
from storage.records import StageRunRow
from storage.tables import table_path
from storage.workspace import Workspace
from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign
from tests.dask_cluster import DaskCluster, dask_cluster
from tests.flows.campaigns import STRUCTURE


@dataclass(frozen=True)
class Timed:
    """One run: wall and processor seconds, how many stages were computed, and the largest memory of a worker."""

    workers: int
    wall_s: float
    stages: int
    largest_mb: float
    processor_s: Counter[str]


def main(words: Sequence[str]) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser("python -m benchmarks.scale dask", description=__doc__)
    parser.add_argument("--epochs", type=int, default=8)
    parser.add_argument("--stations", type=int, default=8)
    parser.add_argument("--points", type=int, default=200_000, help="points of a station")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeats", type=int, default=1)
    asked = parser.parse_args(words)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        request = SimulatedCampaignRequest(epochs=asked.epochs, stations=asked.stations, points=asked.points)
        campaign = write_simulated_campaign(folder / "campaign", request)
        with prefect_for(folder):
            runs = [
                _timed(campaign, folder / f"{repeat}-{workers}", workers)
                for repeat in range(asked.repeats)
                for workers in asked.workers
            ]
    _report(asked, runs)


def _timed(campaign: Path, folder: Path, workers: int) -> Timed:
    """Run the campaign in a new workspace on a new cluster, whose workers have imported everything."""
    # Prefect reads its settings when it is imported
    from flows.run_campaign import RunRequest, run_campaign  # noqa: PLC0415

    with dask_cluster(folder / "cluster", workers, {}) as cluster:
        _warm_up(cluster, campaign, folder)
        own = _on(cluster, campaign)
        before, began = processor_seconds(), time.perf_counter()
        outcome = run_campaign(RunRequest(own, folder / "ws"), lambda _event: None)
        wall_s = time.perf_counter() - began
        spent = processor_seconds() - before
    failed = [
        f"{epoch.epoch}: {'; '.join(epoch.reasons)}" for epoch in outcome.epochs if epoch.state == "failed"
    ]
    if outcome.cached or failed:
        raise SystemExit("\n".join([f"no measurement: {outcome.cached} stages cached", *failed]))
    rows = read_rows(
        table_path(Workspace(outcome.workspace), "runs", STRUCTURE, outcome.run), "runs", StageRunRow
    )
    return Timed(workers, wall_s, outcome.computed, max(row.peak_rss_mb or 0.0 for row in rows), spent)


def _on(cluster: DaskCluster, campaign: Path) -> Path:
    own = campaign.with_name("on-dask.toml")
    execution = f'\n[execution]\nengine = "dask"\naddress = "{cluster.address}"\n'
    own.write_text(campaign.read_text() + execution)
    return own


def _warm_up(cluster: DaskCluster, campaign: Path, folder: Path) -> None:
    """Every worker imports what the stages need, and one epoch of the coarsest scheme runs through."""
    from flows.run_campaign import RunRequest, run_campaign  # noqa: PLC0415
    from tasks.settings import load_campaign  # noqa: PLC0415

    first = load_campaign(campaign).epochs[0].id
    run_campaign(RunRequest(_on(cluster, campaign), folder / "warm", (first,), ("E",)), lambda _event: None)


def _report(asked: argparse.Namespace, runs: Sequence[Timed]) -> None:
    kinds = sorted({kind for run in runs for kind in run.processor_s})
    print(f"{asked.epochs} epochs of {asked.stations} stations of {asked.points:,} points\n")
    print(
        "| workers | wall, s | stages | largest worker, MB |" + "".join(f" {kind}, CPU s |" for kind in kinds)
    )
    print("|---|---|---|---|" + "---|" * len(kinds))
    for run in runs:
        spent = "".join(f" {run.processor_s[kind]:.0f} |" for kind in kinds)
        print(f"| {run.workers} | {run.wall_s:.1f} | {run.stages} | {run.largest_mb:.0f} |{spent}")
    best = {n: min(run.wall_s for run in runs if run.workers == n) for n in asked.workers}
    fewest, most = min(best), max(best)
    print(f"\n{most} workers are {best[fewest] / best[most]:.2f} times as fast as {fewest}")
