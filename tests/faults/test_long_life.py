"""A campaign that lives long: nothing creeps; `python -m tests.faults.long_life` lives a thousand epochs."""

from dataclasses import replace
from pathlib import Path

import pytest

from storage.ledger import read_settings
from storage.views import epoch_rows, version_rows
from storage.workspace import Workspace
from tasks.settings import load_campaign
from tests.faults.long_life.__main__ import lived
from tests.faults.long_life.measures import Point, creeping
from tests.flows.campaigns import STRUCTURE

EPOCHS = 60


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_sixty_epochs_creep_nowhere_and_every_digest_leads_to_its_settings(tmp_path: Path) -> None:
    points, runs = lived(tmp_path, EPOCHS, 20)
    assert creeping(points) == []
    assert [(run["what"], run["told"]) for run in runs if run["exit_code"] != 0] == []
    ws = Workspace(tmp_path / "life" / "ws")
    epochs, versions = epoch_rows(ws, STRUCTURE), version_rows(ws, STRUCTURE)
    assert (len(epochs), len(versions)) == (EPOCHS + 1, EPOCHS // 10)
    digests = {row.campaign_digest for row in (*epochs, *versions)}
    assert len(digests) == EPOCHS + 1
    for digest in digests:
        assert digest is not None
        assert read_settings(ws, digest)
    whole = load_campaign(tmp_path / "life" / "campaign.toml")
    assert read_settings(ws, whole.digest) == whole.filled_in_json()


def point(epochs: int, size: float, files: int = 0, descriptors: int = 8) -> Point:
    return Point(epochs, {"tables": round(size)}, {"tables": files}, descriptors, 1.0, 1.0, {}, {})


def test_what_grows_as_the_epochs_does_not_creep_and_what_grows_faster_does() -> None:
    sizes = (100, 200, 300, 400)
    assert creeping([point(n, 1e5 * n, 16 * n) for n in sizes]) == []
    assert creeping([point(n, 1e3 * n**2) for n in sizes]) != []
    assert creeping([point(n, 0.0, n**2) for n in sizes]) != []


def test_files_that_stay_open_creep() -> None:
    points = [point(n, 0.0) for n in (100, 200, 300)]
    assert creeping(points) == []
    assert creeping([*points[:-1], replace(points[-1], descriptors=9)]) == ["9 open files, 8 at first"]
