"""What is measured on a workspace of many epochs."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.catalog.campaign_text import campaign_text
from benchmarks.catalog.made_up import (
    STRUCTURE,
    epoch_content,
    epoch_name,
    run_content,
    run_name,
    series_content,
)
from benchmarks.catalog.workspace import rebuilt_from_nothing
from storage.catalog import rebuild_catalog
from storage.ledger import append_run
from storage.parquet import rows_from_table
from storage.publish import publish_epoch
from storage.records import TABLES
from storage.series import publish_series
from storage.tables import epochs_on_disk
from storage.views import change_test_rows, tilt_rows
from storage.views.condition import conditions
from storage.workspace import Workspace
from tasks.settings import load_campaign

PRIMARY: Final = ("S", "surface")


@dataclass(frozen=True, slots=True)
class Row:
    """A line of the report."""

    what: str
    shown: str


def measured(ws: Workspace, n_epochs: int, repeats: int) -> list[Row]:
    """Measure a workspace; it has some epochs more afterwards."""
    anew = _seconds(lambda: rebuilt_from_nothing(ws))
    size_mb = ws.catalog.stat().st_size / 1e6
    more = [_one_more(ws) for _ in range(repeats)]
    campaign_file = ws.root / "campaign.toml"
    campaign_file.write_text(campaign_text(n_epochs), encoding="utf-8")
    return [
        Row("catalog of all Parquet files, nothing there before", f"{anew:.2f}"),
        *(_least(name, [times[name] for times in more]) for name in more[0]),
        _least("state of every epoch (`status`)", _times(repeats, lambda: _conditions(ws))),
        _least("axes of every epoch read", _times(repeats, lambda: tilt_rows(ws, STRUCTURE))),
        _least("change tests of every epoch read", _times(repeats, lambda: change_test_rows(ws, STRUCTURE))),
        _least("campaign file read and checked", _times(repeats, lambda: load_campaign(campaign_file))),
        Row("catalog, MB", f"{size_mb:.0f}"),
        Row(f"catalog after {repeats} epochs more, MB", f"{ws.catalog.stat().st_size / 1e6:.0f}"),
        Row("tables, MB", f"{_size_mb(ws.tables):.0f}"),
    ]


def _one_more(ws: Workspace) -> dict[str, float]:
    """Publish one epoch more, as a run does, and let the catalog follow."""
    number = len(epochs_on_disk(ws))
    rows = {name: rows_from_table(table, TABLES[name]) for name, table in epoch_content(number).items()}
    ran = rows_from_table(run_content(number), TABLES["runs"])
    series = {
        name: rows_from_table(table, TABLES[name]) for name, table in series_content(number + 1).items()
    }
    return {
        "one more: its tables published": _seconds(
            lambda: publish_epoch(ws, STRUCTURE, epoch_name(number), rows)
        ),
        "one more: its run noted": _seconds(lambda: append_run(ws, run_name(number), STRUCTURE, ran)),
        "one more: the catalog follows": _seconds(lambda: rebuild_catalog(ws)),
        "one more: the series of all epochs stored": _seconds(lambda: publish_series(ws, STRUCTURE, series)),
        "one more: the catalog follows the series": _seconds(lambda: rebuild_catalog(ws)),
        "nothing new: the catalog is current": _seconds(lambda: rebuild_catalog(ws)),
    }


def _conditions(ws: Workspace) -> object:
    return conditions(ws, STRUCTURE, PRIMARY)


def _seconds(do: Callable[[], object]) -> float:
    began = time.perf_counter()
    do()
    return time.perf_counter() - began


def _times(repeats: int, do: Callable[[], object]) -> list[float]:
    return [_seconds(do) for _ in range(repeats)]


def _least(what: str, times: list[float]) -> Row:
    return Row(what, f"{min(times):.3f}")


def _size_mb(folder: Path) -> float:
    return sum(path.stat().st_size for path in folder.rglob("*.parquet")) / 1e6
