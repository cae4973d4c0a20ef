"""Whole runs on a drive that is full, or becomes so: told with what to do, nothing lost, the next run as undisturbed."""

import random
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.faults.drive_site import MEGABYTES, DriveSite, Undisturbed, at_step
from tests.faults.killing.stored import shown_epochs
from tests.faults.small_drive import small_drive
from tests.flows.calls import Called

KIB = 1024

ONE, TWO, CHANGED = "one.toml", "campaign.toml", "changed.toml"

slow = pytest.mark.slow

# the fault of a stage holds its frames in a ring, and with them what reads the scan; it ends when that is collected
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


@pytest.fixture
def site(scans_of_three: Path, mountable: None, tmp_path: Path) -> Iterator[DriveSite]:
    with small_drive(tmp_path / "drive", MEGABYTES) as drive:
        yield DriveSite(scans_of_three, drive)


@slow
@pytest.mark.parametrize("free_kib", [0, 24, 150, 700, 1600, 5000])
def test_the_first_run_says_that_the_drive_is_full_and_the_next_ends_as_undisturbed(
    site: DriveSite, undisturbed: dict[str, Undisturbed], free_kib: int
) -> None:
    site.drive.fill_up(free_kib * KIB)
    told = site.run(ONE)
    assert told.code == 3, told.err
    assert_told(told.err)
    assert site.epochs_in_part(undisturbed[ONE].shown) == []
    site.drive.empty()
    assert site.faults_after(ONE, undisturbed[ONE]) == []


@slow
@pytest.mark.parametrize("free_kib", [0, 40, 300, 1000, 4000])
def test_a_second_epoch_on_a_full_drive_leaves_the_first_readable_and_the_next_run_ends_as_undisturbed(
    site: DriveSite, undisturbed: dict[str, Undisturbed], free_kib: int
) -> None:
    assert site.run(ONE).code == undisturbed[ONE].code
    before = said(site.call("status", ONE, "--json"))
    site.drive.fill_up(free_kib * KIB)
    told = site.run(TWO)
    assert told.code == 3, told.err
    assert_told(told.err)
    assert site.epochs_in_part(undisturbed[ONE].shown, undisturbed[TWO].shown) == []
    assert said(site.call("status", ONE, "--json")) == before, "status can be asked on the full drive"
    site.drive.empty()
    assert site.faults_after(TWO, undisturbed[TWO]) == []


@slow
def test_on_a_full_drive_old_results_can_be_asked_for_as_before(
    site: DriveSite, undisturbed: dict[str, Undisturbed], tmp_path: Path
) -> None:
    site.run(TWO)
    asked = [("status",), ("compare", *undisturbed[TWO].shown), ("verify",), ("alarms",)]
    before = [said(site.call(command, TWO, *words, "--json")) for command, *words in asked]
    exported = [site.call("export", TWO, "tilt", "--format", "csv", "--out", tmp_path / "tilt.csv")]
    site.drive.fill_up(0)
    assert [said(site.call(command, TWO, *words, "--json")) for command, *words in asked] == before
    (tmp_path / "tilt.csv").unlink()
    exported.append(site.call("export", TWO, "tilt", "--format", "csv", "--out", tmp_path / "tilt.csv"))
    assert exported[0] == exported[1]
    assert {code for code, _ in before} | {told.code for told in exported} <= {0, 4, 5, 6}


MOMENTS = random.Random(8)


@slow
@pytest.mark.parametrize("part", [(number + MOMENTS.random()) / 5 for number in range(5)])
@pytest.mark.parametrize("campaign", [TWO, CHANGED])
def test_a_drive_that_becomes_full_under_a_run_is_told_and_the_next_run_ends_as_undisturbed(
    site: DriveSite, undisturbed: dict[str, Undisturbed], campaign: str, part: float
) -> None:
    """At a drawn step of the run; the second campaign file replaces the results of an earlier run."""
    for earlier in (ONE, TWO)[
        : 1 + (campaign == CHANGED)
    ]:  # as the undisturbed runs: an epoch tells its campaign file
        site.run(earlier)
    before, wanted = shown_epochs(site.place), undisturbed[campaign]
    with at_step(site.workspace, 1 + int(part * wanted.steps), lambda: site.drive.fill_up(0)) as steps:
        told = site.run(campaign)
    assert told.code == 3, (told, steps.done[-3:])
    assert_told(told.err)
    assert site.epochs_in_part(before, wanted.shown) == []
    site.drive.empty()
    assert site.faults_after(campaign, wanted) == []


def said(told: Called) -> tuple[int, dict[str, object]]:
    """Exit code and answer of a command, but for how old the newest epoch is by now."""
    return told.code, {name: value for name, value in told.answer.items() if name != "age_days"}


def assert_told(errors: str) -> None:
    """That a run says what is full and what to do, in a line that begins with `error:`."""
    lines = [line for line in errors.splitlines() if line.startswith("error: ")]
    assert any("No space left" in line or "MB are free" in line for line in lines), errors
    assert all("free space" in line for line in lines), errors
