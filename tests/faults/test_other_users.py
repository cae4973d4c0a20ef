"""A workspace, scans or a folder that belong to somebody else: what may be read is read, the rest is said with its file.

The user without rights is root without the right to override them, because another user may not reach the interpreter.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.faults.drive_site import DriveSite
from tests.faults.small_drive import Drive
from tests.flows.calls import ROOT, Called
from tests.shared import unavailable

NOBODY = 65534

NO_RIGHTS = ("--bounding-set", "-dac_override,-dac_read_search,-fowner,-chown")

FOLDERS = ("artifacts", "records", "tables", "runs", "prefect", "locks", "tmp")

CAMPAIGN = "campaign.toml"

slow = pytest.mark.slow


@pytest.fixture
def site(scans_of_three: Path, prefect_api: str, tmp_path: Path) -> DriveSite:
    """A campaign and the place of a workspace."""
    if os.geteuid() != 0 or shutil.which("setpriv") is None:
        unavailable("only root can give its rights away, by setpriv")
    shutil.copytree(scans_of_three, tmp_path / "scans")
    (tmp_path / "place").mkdir()
    return DriveSite(tmp_path / "scans", Drive(tmp_path / "place"))


def give_away(*places: Path) -> None:
    """Let somebody else own files and folders, with all that is in them."""
    for place in places:
        for each in (place, *place.rglob("*")):
            os.chown(each, NOBODY, NOBODY)


def call(site: DriveSite, *words: object) -> Called:
    """Call the command line without rights."""
    asked = ["setpriv", *NO_RIGHTS, sys.executable, "-m", "flows.cli", *words, "--workspace", site.workspace]
    done = subprocess.run(
        [str(word) for word in asked],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert "Traceback" not in done.stdout + done.stderr
    return Called(done.returncode, done.stdout, done.stderr)


@slow
def test_a_user_who_may_only_read_reads_and_is_told_what_he_may_not(site: DriveSite, tmp_path: Path) -> None:
    assert site.run(CAMPAIGN).code == 0
    give_away(site.drive.place)
    file, out = site.scans / CAMPAIGN, tmp_path / "out"
    out.mkdir()
    told = call(site, "run", file)
    assert told.code == 3, told.err
    assert "Permission denied" in told.err
    assert "the folder must be writable" in told.err
    for words in (
        ("status", file),
        ("compare", file, "2025-04", "2025-01"),
        ("verify", file),
        ("export", file, "tilt", "--format", "csv", "--out", out / "tilt.csv"),
        ("report", file, "--html", out / "report.html"),
    ):
        told = call(site, *words)
        assert told.code in (0, 4, 5, 6), (words, told.err)


@slow
def test_scans_that_may_not_be_read_are_named(site: DriveSite) -> None:
    scan = site.scans / "2025-01" / "ST01.laz"
    give_away(scan)
    scan.chmod(0o600)
    told = call(site, "run", site.scans / "one.toml")
    assert told.code == 3, told.err
    assert str(scan) in told.err
    assert "Permission denied" in told.err


@slow
@pytest.mark.parametrize("folder", ["artifacts", "records", "tables", "runs", "locks"])
def test_one_folder_of_somebody_else_is_named(site: DriveSite, folder: str) -> None:
    for name in FOLDERS:
        (site.workspace / name).mkdir(parents=True)
    give_away(site.workspace / folder)
    told = call(site, "run", site.scans / "one.toml")
    assert told.code == 3, told.err
    assert str(site.workspace / folder) in told.err
    assert "Permission denied" in told.err
