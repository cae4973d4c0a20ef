"""What a killed process was writing is swept by the next run, wherever it lies; what a living one writes stays."""

import subprocess
import sys
from pathlib import Path

import pytest

from storage.atomic import temp_beside, write_atomically
from storage.publish import recover, stale_temps
from storage.verify import verify_workspace
from storage.workspace import Workspace
from storage.writers import is_writer_gone, mark_of_this_process

PLACES = (
    "artifacts/incoming",
    "records/ingest-1",
    "runs/settled/chimney/e0.json",
    "runs/settings/1.json",
    "intake/s/e1.toml",
    "previews/s/e1.json",
)

DIES = """
import os, sys
from pathlib import Path
from storage.atomic import write_temp
write_temp(Path(sys.argv[1]), b"half")
os.kill(os.getpid(), 9)
"""


@pytest.mark.parametrize("place", PLACES)
def test_what_a_killed_process_was_writing_is_told_and_swept_by_the_next(ws: Workspace, place: str) -> None:
    died = subprocess.run([sys.executable, "-c", DIES, str(ws.root / place)], check=False)
    assert died.returncode == -9
    (temp,) = (ws.root / place).parent.glob("*.tmp")
    assert [fault.where for fault in verify_workspace(ws).faults] == [temp.relative_to(ws.root).as_posix()]
    assert recover(ws).temps_swept == 1
    assert not temp.exists()


@pytest.mark.parametrize("place", ["artifacts/incoming", "records/ingest-1", "runs/settled/chimney/e0.json"])
def test_what_a_living_process_is_writing_stays(ws: Workspace, place: str) -> None:
    temps: list[Path] = []

    def sweep_meanwhile(file: object) -> None:
        temps.extend((ws.root / place).parent.glob("*.tmp"))
        assert recover(ws).temps_swept == 0
        assert temps[0].exists()

    write_atomically(ws.root / place, sweep_meanwhile)
    assert (ws.root / place).exists()
    assert stale_temps(ws) == []


def test_of_a_process_elsewhere_and_of_an_older_program_nobody_can_tell(tmp_path: Path) -> None:
    own = temp_beside(tmp_path / "one")
    elsewhere = own.with_name(own.name.replace(mark_of_this_process(), "00000000-4000000"))
    older = own.with_name(own.name.replace(f".{mark_of_this_process()}", ""))
    gone = own.with_name(own.name.replace(mark_of_this_process(), f"{mark_of_this_process()[:9]}4194305"))
    assert [is_writer_gone(path) for path in (own, elsewhere, older, gone)] == [False, False, False, True]
