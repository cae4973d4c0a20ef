"""Whole runs whose drive becomes read-only or is taken away: nothing is made anew in the mount point that stays behind."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from storage.errors import StorageError
from storage.presence import check_mounted
from storage.upgrade import ready_or_new_workspace
from tests.faults.drive_site import MEGABYTES, DriveSite, Undisturbed, at_step, call
from tests.faults.killing.stored import shown_epochs
from tests.faults.sites import state_of
from tests.faults.small_drive import fail, failing_drive, small_drive
from tests.shared import unavailable

ONE, TWO = "one.toml", "campaign.toml"

slow = pytest.mark.slow

# the fault of a stage holds its frames in a ring, and with them what reads the scan; it ends when that is collected
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


@pytest.fixture
def site(scans_of_three: Path, mountable: None, tmp_path: Path) -> Iterator[DriveSite]:
    with small_drive(tmp_path / "drive", MEGABYTES) as drive:
        yield DriveSite(scans_of_three, drive)


@pytest.fixture
def image(tmp_path: Path) -> Path:
    """A drive in a file, which has been mounted once."""
    image = tmp_path / "image"
    try:
        with failing_drive(image, tmp_path / "drive", MEGABYTES):
            return image
    except OSError as fault:
        unavailable(f"no image can be mounted here: {fault}")


@slow
@pytest.mark.parametrize("part", [0.05, 0.35, 0.65, 0.95])
def test_a_drive_that_is_taken_away_under_a_run_is_told_and_the_folder_beneath_stays_empty(
    site: DriveSite, undisturbed: dict[str, Undisturbed], part: float
) -> None:
    wanted = undisturbed[ONE]
    with at_step(site.workspace, 1 + int(part * wanted.steps), site.drive.take_away):
        told = site.run(ONE)
    assert told.code == 3, told.err
    assert "bring it back and run again" in told.err
    assert list(site.drive.place.iterdir()) == []


@slow
def test_a_drive_that_comes_back_gives_the_results_that_were_there(
    scans_of_three: Path, image: Path, undisturbed: dict[str, Undisturbed], tmp_path: Path
) -> None:
    with failing_drive(image, tmp_path / "drive", MEGABYTES) as drive:
        site = DriveSite(scans_of_three, drive)
        assert site.run(ONE).code == 0
        with at_step(site.workspace, 60, drive.take_away):
            assert site.run(TWO).code == 3
        assert list(drive.place.iterdir()) == []
    with failing_drive(image, tmp_path / "drive", MEGABYTES) as drive:
        site = DriveSite(scans_of_three, drive)
        assert shown_epochs(site.place) == undisturbed[ONE].shown
        assert site.faults_after(TWO, undisturbed[TWO]) == []


@slow
@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
def test_a_drive_that_becomes_read_only_under_a_run_is_told_and_the_next_run_ends_as_undisturbed(
    scans_of_three: Path, image: Path, undisturbed: dict[str, Undisturbed], tmp_path: Path, part: float
) -> None:
    wanted = undisturbed[ONE]
    with failing_drive(image, tmp_path / "drive", MEGABYTES) as drive:
        site = DriveSite(scans_of_three, drive)
        with at_step(site.workspace, 1 + int(part * wanted.steps), lambda: fail(drive)):
            told = site.run(ONE)
        assert told.code == 3, told.err
        assert "Read-only file system" in told.err
        assert site.epochs_in_part(wanted.shown) == []
        told = site.run(ONE)
        assert (told.code, "Read-only file system" in told.err) == (3, True), "nor before a run"
    with failing_drive(image, tmp_path / "drive", MEGABYTES) as drive:
        assert DriveSite(scans_of_three, drive).faults_after(ONE, wanted) == []


@slow
def test_scans_whose_drive_is_taken_away_cost_their_epoch_alone(
    scans_of_three: Path, mountable: None, prefect_api: str, tmp_path: Path
) -> None:
    """The second epoch lies on a drive that goes when the first is published; when it is back, the epoch is whole."""
    folder = tmp_path / "scans"
    shutil.copytree(scans_of_three, folder)
    shutil.rmtree(folder / "2025-04")
    with small_drive(folder / "2025-04", 8) as drive:
        shutil.copytree(scans_of_three / "2025-04", drive.place, dirs_exist_ok=True)
        words = ["run", folder / TWO, "--workspace", tmp_path / "ws", "--json"]
        with at_step(tmp_path / "ws", 150, drive.take_away):
            told = call(words)
    states = {epoch["epoch"]: epoch["state"] for epoch in told.answer["epochs"]}
    assert (told.code, states) == (3, {"2025-01": "ok", "2025-04": "failed"}), told.err
    assert state_of(told, "2025-04")["storage_fault"] is True
    assert f"{folder / '2025-04'} is empty or gone: mount its drive" in told.err
    shutil.copytree(scans_of_three / "2025-04", folder / "2025-04", dirs_exist_ok=True)
    told = call(words)
    assert (told.code, {epoch["state"] for epoch in told.answer["epochs"]}) == (0, {"ok"}), told.err


@slow
def test_a_slow_drive_gives_what_a_quick_one_gives(
    site: DriveSite, undisturbed: dict[str, Undisturbed]
) -> None:
    """Every step (a file opened to be written, a rename, removal or fsync) takes a tenth of a second more."""
    with at_step(site.workspace, 0, pause_s=0.1) as steps:
        assert site.run(ONE).code == 0
    assert len(steps.done) > 100
    assert site.faults_after(ONE, undisturbed[ONE]) == []


def test_no_workspace_is_made_where_a_drive_of_the_system_is_missing(tmp_path: Path) -> None:
    fstab = tmp_path / "fstab"
    fstab.write_text(
        f"# UUID=0 {tmp_path} ext4\nproc /proc proc defaults 0 0\nUUID=1 {tmp_path}/my\\040drive ext4 noauto 0 0\n",
        encoding="utf-8",
    )
    check_mounted(tmp_path / "ws", fstab)
    check_mounted(Path("/proc/ws"), fstab)
    with pytest.raises(StorageError, match=r"my drive is the place of a drive .* mount it .*my drive"):
        check_mounted(tmp_path / "my drive" / "ws", fstab)
    check_mounted(tmp_path / "ws", tmp_path / "none")


def test_a_new_workspace_below_a_missing_drive_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fstab = tmp_path / "fstab"
    fstab.write_text(f"UUID=1 {tmp_path}/drive ext4 defaults 0 0\n", encoding="utf-8")
    monkeypatch.setattr("storage.presence.FSTAB", fstab)
    with pytest.raises(StorageError, match="none is mounted there"):
        ready_or_new_workspace(tmp_path / "drive" / "ws")
    assert not (tmp_path / "drive").exists()
