"""One small campaign of two sound epochs for all tests of faults: processed once, copied for each."""

import shutil
from pathlib import Path
from typing import Final

import pytest

from storage.publish import remove_epoch
from storage.tables import ALARM_EVENTS, SERIES_TABLES
from storage.workspace import Workspace
from tests.faults.drive_site import NEVER, DriveSite, Undisturbed, at_step
from tests.faults.killing.scenes import campaigns_in
from tests.faults.killing.stored import content_of, shown_epochs
from tests.faults.sites import EPOCHS, Site
from tests.faults.small_drive import Drive, may_mount
from tests.flows.campaigns import STRUCTURE, run, small_campaign
from tests.made_once import made_once
from tests.shared import unavailable

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


@pytest.fixture
def mountable(tmp_path: Path) -> None:
    """Skip where no drive can be mounted, but never in CI."""
    why_not = may_mount(tmp_path / "try")
    if why_not:
        unavailable(f"no drive can be mounted here: {why_not}")


@pytest.fixture(scope="session")
def scans_of_three(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with three small campaign files over the same scans; nobody may change it."""
    return made_once(tmp_path_factory, "three", campaigns_in)


@pytest.fixture(scope="session")
def undisturbed(
    scans_of_three: Path, tmp_path_factory: pytest.TempPathFactory, prefect_api: str
) -> dict[str, Undisturbed]:
    """What runs of the three files give that nobody disturbs: the second adds an epoch, the third replaces both."""
    site = DriveSite(scans_of_three, Drive(tmp_path_factory.mktemp("undisturbed")))
    return {campaign: _undisturbed(site, campaign) for campaign in CAMPAIGNS}


CAMPAIGNS: Final = ("one.toml", "campaign.toml", "changed.toml")


def _undisturbed(site: DriveSite, campaign: str) -> Undisturbed:
    with at_step(site.workspace, NEVER) as steps:
        code = site.run(campaign).code
    assert code == 0, campaign
    return Undisturbed(code, content_of(site.place), shown_epochs(site.place), len(steps.done))
