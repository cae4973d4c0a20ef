"""What an epoch takes: bytes, processor seconds, requests to an S3 store."""

import argparse
import os
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any

from benchmarks.scale.processor_time import processor_seconds
from benchmarks.scale.servers import prefect_for
from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign
from tests.s3_server import s3_server

ASKED = ("get", "put", "_label", "_upload", "_pieces", "remove", "names")
"""Methods of the store that talk to the server."""


def main(words: Sequence[str]) -> None:
    """Measure two epochs, the second beside the first, and print what it took."""
    parser = argparse.ArgumentParser("python -m benchmarks.scale figures", description=__doc__)
    parser.add_argument("--stations", type=int, default=8)
    parser.add_argument("--points", type=int, default=200_000, help="points of a station")
    asked = parser.parse_args(words)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        request = SimulatedCampaignRequest(epochs=2, stations=asked.stations, points=asked.points)
        campaign = write_simulated_campaign(folder / "campaign", request)
        with s3_server(folder / "s3") as endpoint, prefect_for(folder):
            os.environ.update(endpoint.environment, TILTWATCH_CACHE=str(folder / "cache"))
            place = f"{endpoint.make_bucket('figures')}/x"
            own = campaign.with_name("on-s3.toml")
            own.write_text(campaign.read_text() + f'\n[execution]\nstore = "{place}"\n')
            _measure(own, folder / "ws", place)


def _measure(campaign: Path, workspace: Path, place: str) -> None:
    # Prefect reads its settings when it is imported
    from flows.run_campaign import RunRequest, run_campaign  # noqa: PLC0415
    from tasks.settings import load_campaign  # noqa: PLC0415

    first, second = (epoch.id for epoch in load_campaign(campaign).epochs)
    run_campaign(RunRequest(campaign, workspace, (first,)), lambda _event: None)
    stored, tables = _stored_bytes(place), _bytes_below(workspace / "tables")
    with counted_requests() as computing:
        before = processor_seconds()
        outcome = run_campaign(RunRequest(campaign, workspace, (second,)), lambda _event: None)
        spent = processor_seconds() - before
    grown = _stored_bytes(place) - stored
    with counted_requests() as cached:
        run_campaign(RunRequest(campaign, workspace, (second,)), lambda _event: None)
    scans = _bytes_below(campaign.parent / second)
    print("| of one epoch | figure |\n|---|---|")
    print(f"| stages computed | {outcome.computed} |")
    print(f"| scans, MB | {scans / 1e6:.2f} |")
    for kind in sorted(grown):
        print(f"| {kind} in the store, MB | {grown[kind] / 1e6:.2f} |")
    print(f"| tables, MB | {(_bytes_below(workspace / 'tables') - tables) / 1e6:.2f} |")
    print(f"| catalog of two epochs, MB | {(workspace / 'catalog.duckdb').stat().st_size / 1e6:.2f} |")
    print(f"| processor time of the run, s | {spent['this process']:.1f} |")
    print(f"| requests while computing | {_told(computing)} |")
    print(f"| requests when all is cached | {_told(cached)} |")


@contextmanager
def counted_requests() -> Iterator[Counter[str]]:
    """Count what is asked of the S3 server in the block."""
    from storage.s3_store import S3Store  # noqa: PLC0415

    counts: Counter[str] = Counter()
    kept = {name: getattr(S3Store, name) for name in ASKED}
    words = {"_label": ("HEAD",), "get": ("HEAD", "GET"), "_pieces": ("HEAD", "GET"), "_upload": ("PUT",)}
    words |= {"put": (), "remove": ("DELETE",), "names": ("LIST",)}
    for name, method in kept.items():
        setattr(S3Store, name, _counting(method, counts, words[name]))
    try:
        yield counts
    finally:
        for name, method in kept.items():
            setattr(S3Store, name, method)


def _counting(
    method: Callable[..., Any], counts: Counter[str], requests: Sequence[str]
) -> Callable[..., Any]:
    @wraps(method)
    def counting(*args: Any, **kwargs: Any) -> Any:
        counts.update(requests)
        return method(*args, **kwargs)

    return counting


def _told(counts: Counter[str]) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in sorted(counts.items()))


def _bytes_below(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def _stored_bytes(place: str) -> Counter[str]:
    """Bytes in the store: scans, arrays, other artifacts and records."""
    from storage.places import store_at  # noqa: PLC0415

    store = store_at(place)
    kept: Counter[str] = Counter()
    for name in store.names("artifacts"):
        is_array = name.endswith((".npy", ".cloud"))
        kind = "arrays" if is_array else "scans" if name.endswith(".laz") else "other artifacts"
        kept[kind] += store.size(name) or 0
    for name in store.names("records"):
        kept["records"] += store.size(name) or 0
    return kept
