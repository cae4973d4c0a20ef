"""A workspace, scans or a folder that belong to somebody else: what may be read is read, the rest is said with its file."""

import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.faults.drive_site import DriveSite
from tests.faults.small_drive import Drive
from tests.flows.calls import ROOT, Called

NOBODY = 65534

CAMPAIGN = "campaign.toml"

slow = pytest.mark.slow


@pytest.fixture
def site(scans_of_three: Path, prefect_api: str, tmp_path: Path) -> DriveSite:
    """A campaign of root's, which nobody may read, and its workspace."""
    if os.geteuid() != 0:
        pytest.skip("only root can be another user")
    folder = tmp_path / "scans"
    shutil.copytree(scans_of_three, folder)
    for above in folder.parents:
        if above.is_relative_to("/tmp") and above != Path("/tmp"):  # noqa: S108 - pytest shuts its folders to others
            above.chmod(above.stat().st_mode | 0o055)
    made = DriveSite(folder, Drive(tmp_path / "place"))
    made.drive.place.mkdir()
    return made


def call_as(user: int, site: DriveSite, *words: object, limit: Callable[[], None] | None = None) -> Called:
    """Call the command line as another user, or under a limit of the system."""
    asked = [sys.executable, "-B", "-m", "flows.cli", *words, "--workspace", site.workspace]
    home = site.drive.place.parent / f"home-{user}"
    home.mkdir(exist_ok=True)
    os.chown(home, user, user)
    done = subprocess.run(
        [str(word) for word in asked],
        cwd=ROOT,
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "HOME": str(home),
            "TMPDIR": str(home),
            "PREFECT_HOME": str(home / "p"),
        },
        user=user,
        group=user,
        extra_groups=[],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        preexec_fn=limit,
    )
    assert "Traceback" not in done.stdout + done.stderr
    return Called(done.returncode, done.stdout, done.stderr)


@slow
def test_a_user_who_may_only_read_reads_and_is_told_what_he_may_not(site: DriveSite, tmp_path: Path) -> None:
    assert site.run(CAMPAIGN).code == 0
    file, out = site.scans / CAMPAIGN, tmp_path / "home-65534" / "out"
    told = call_as(NOBODY, site, "run", file)
    assert told.code == 3
    assert "Permission denied" in told.err
    assert "the folder must be writable" in told.err
    for words in (
        ("status", file),
        ("compare", file, "2025-04", "2025-01"),
        ("verify", file),
        ("export", file, "tilt", "--format", "csv", "--out", out / "tilt.csv"),
        ("report", file, "--out", out),
    ):
        out.mkdir(exist_ok=True)
        os.chown(out, NOBODY, NOBODY)
        told = call_as(NOBODY, site, *words)
        assert told.code in (0, 4, 5, 6), (words, told.err)


@slow
def test_scans_that_may_not_be_read_are_named(site: DriveSite) -> None:
    os.chown(site.drive.place, NOBODY, NOBODY)
    scan = site.scans / "2025-01" / "ST01.laz"
    scan.chmod(0o600)
    told = call_as(NOBODY, site, "run", site.scans / "one.toml")
    assert told.code == 3
    assert f"{scan}: Permission denied" in told.err, told.err


@slow
@pytest.mark.parametrize("folder", ["artifacts", "records", "tables", "locks", "tmp"])
def test_one_folder_of_somebody_else_is_named(site: DriveSite, folder: str) -> None:
    os.chown(site.drive.place, NOBODY, NOBODY)
    for name in ("", "artifacts", "records", "tables", "runs", "prefect", "locks", "tmp"):
        place = site.workspace / name
        place.mkdir()
        os.chown(place, NOBODY, NOBODY)
    os.chown(site.workspace / folder, 0, 0)
    told = call_as(NOBODY, site, "run", site.scans / "one.toml")
    assert told.code == 3, told.err
    assert str(site.workspace / folder) in told.err
    assert "Permission denied" in told.err


@slow
@pytest.mark.parametrize(
    ("which", "most", "words"),
    [(resource.RLIMIT_FSIZE, 20_000, "File too large"), (resource.RLIMIT_NOFILE, 24, "Too many open files")],
    ids=["size of a file", "open files"],
)
def test_a_limit_of_the_system_is_told_and_the_next_run_ends_well(
    site: DriveSite, which: int, most: int, words: str
) -> None:
    file = site.scans / "one.toml"
    told = call_as(0, site, "run", file, limit=lambda: resource.setrlimit(which, (most, most)))
    assert told.code == 3, told.err
    assert words in told.err
    assert call_as(0, site, "run", file).code == 0
