"""One small campaign of two sound epochs for all tests of faults: processed once, copied for each."""

import shutil
from pathlib import Path

import pytest

from storage.publish import remove_epoch
from storage.tables import ALARM_EVENTS, SERIES_TABLES
from storage.workspace import Workspace
from tests.faults.sites import EPOCHS, Site
from tests.flows.campaigns import STRUCTURE, run, small_campaign
from tests.made_once import made_once

STATIONS = 5
"""With fewer the scans of so few points overlap too little, and the epochs would not be ok to begin with."""


@pytest.fixture(scope="session")
def sound(tmp_path_factory: pytest.TempPathFactory, prefect_api: str) -> Site:
    """Two epochs that are ok, and the workspace after one run of them; run by whichever worker comes first."""
    return Site(made_once(tmp_path_factory, "sound", _make_sound))


def _make_sound(folder: Path) -> None:
    site = Site(folder)
    small_campaign(site.folder, epochs=2, stations=STATIONS)
    outcome = run(site.file, site.workspace)
    assert [epoch.state for epoch in outcome.epochs] == ["ok", "ok"], outcome.epochs


@pytest.fixture
def published(sound: Site, tmp_path: Path) -> Site:
    """A copy in which both epochs are published."""
    return copy_of(sound, tmp_path / "campaign")


@pytest.fixture
def unpublished(sound: Site, tmp_path: Path) -> Site:
    """A copy in which every stage is in the cache and no epoch is published yet."""
    site = copy_of(sound, tmp_path / "campaign")
    for epoch in EPOCHS:
        assert remove_epoch(Workspace(site.workspace), STRUCTURE, epoch)
    ws = Workspace(site.workspace)
    for table in (*SERIES_TABLES, ALARM_EVENTS):
        shutil.rmtree(ws.tables / table, ignore_errors=True)
    # a second copy would be put back, and the mark says that series should be there
    shutil.rmtree(ws.second / "tables" / ALARM_EVENTS, ignore_errors=True)
    shutil.rmtree(ws.runs / "assessed", ignore_errors=True)
    return site


def copy_of(site: Site, folder: Path) -> Site:
    """Copy campaign and workspace."""
    shutil.copytree(site.folder, folder)
    return Site(folder)
