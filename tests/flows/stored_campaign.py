"""A campaign file and a workspace that holds its epochs, made of rows without any run."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

from storage.catalog import rebuild_catalog
from storage.publish import publish_epoch
from storage.records import TiltRow
from storage.workspace import Workspace, open_workspace
from tasks.accuracy import accuracy_rows, control_of_scheme
from tasks.geometry.failure import FitFailure
from tests.storage.campaign import epoch_tables, fill, tilt_row
from tests.unit.settings.campaign_text import WHOLE, edited

LEAN = (0.007, -0.0057)


@dataclass(frozen=True)
class Stored:
    """A campaign file and its workspace, where the commands look for it."""

    file: Path
    workspace: Workspace


def stored_campaign(folder: Path) -> Stored:
    """Campaign of two epochs, e1 and e2, of which nothing is published yet."""
    file = folder / "campaign.toml"
    file.write_text(edited('["S", "surface"]', '["A", "paper"]', WHOLE), encoding="utf-8")
    return Stored(file, open_workspace(folder / "tiltwatch-data"))


def publish(
    stored: Stored,
    epoch: str,
    number: int,
    tilt: dict[str, object] | None = None,
    moved_m: float = 0.0,
    **epoch_row: object,
) -> None:
    """Publish an epoch with schemes A and F; ``tilt`` changes rows of both, ``epoch_row`` the row of the epoch."""
    if not list(stored.workspace.runs.glob("settings/*")):
        fill(stored.workspace, 0)
    lean = (LEAN[0] + moved_m / 102.0, LEAN[1])
    rows = [_row(epoch, number, lean, scheme, **(tilt or {})) for scheme in ("A", "F")]
    tables = epoch_tables(epoch, number, lean, **epoch_row)
    control = control_of_scheme(rows, "F", "paper")
    if isinstance(control, FitFailure):
        raise TypeError(control.reason)
    tables["tilt"] = rows
    tables["accuracy"] = accuracy_rows(rows, control)
    tables["reference_leans"] = []
    publish_epoch(stored.workspace, "chimney-01", epoch, tables)
    rebuild_catalog(stored.workspace)


def publish_without_result(stored: Stored, epoch: str, number: int, **epoch_row: object) -> None:
    """Publish an epoch that gave no axis."""
    if not list(stored.workspace.runs.glob("settings/*")):
        fill(stored.workspace, 0)
    tables = {**epoch_tables(epoch, number, LEAN, **epoch_row), "tilt": [], "accuracy": []}
    publish_epoch(stored.workspace, "chimney-01", epoch, tables)
    rebuild_catalog(stored.workspace)


def _row(epoch: str, number: int, lean: tuple[float, float], scheme: str, **changed: object) -> TiltRow:
    row = replace(tilt_row(epoch, number, lean), scheme=scheme, deviation_m=102.0 * math.hypot(*lean))
    return replace(row, **changed)
