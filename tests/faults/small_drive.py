"""A drive of a few megabytes, that can be filled, made read-only and taken away."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

BALLAST = "ballast"


@dataclass(frozen=True)
class Drive:
    """A mounted tmpfs."""

    place: Path

    def fill_up(self, free_bytes: int) -> None:
        """Leave so many bytes."""
        self.empty()
        there = shutil.disk_usage(self.place).free - free_bytes
        with (self.place / BALLAST).open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, max(there, 1))

    def empty(self) -> None:
        """Give the space back."""
        (self.place / BALLAST).unlink(missing_ok=True)

    def read_only(self) -> None:
        """Let nobody write."""
        _mount("-o", "remount,ro", str(self.place))

    def take_away(self) -> None:
        """Unmount it under whoever uses it: their open files go on, every path leads to the folder beneath."""
        subprocess.run(["umount", "-l", str(self.place)], check=True, capture_output=True)

    def writable(self) -> None:
        """Let people write again."""
        _mount("-o", "remount,rw", str(self.place))


@contextmanager
def small_drive(place: Path, megabytes: int) -> Iterator[Drive]:
    """Mount a drive for as long as the block lasts.

    Raises
    ------
    OSError
        Where this system lets nobody mount: without root, or in a container that may not.
    """
    place.mkdir(parents=True, exist_ok=True)
    _mount("-t", "tmpfs", "-o", f"size={megabytes}m", "none", str(place))
    try:
        yield Drive(place)
    finally:
        subprocess.run(["umount", "-l", str(place)], check=False, capture_output=True)


def may_mount(place: Path) -> str:
    """Why no drive can be mounted here; nothing where it can."""
    try:
        with small_drive(place, 1):
            return ""
    except OSError as fault:
        return str(fault)


def _mount(*words: str) -> None:
    program = shutil.which("mount")
    if program is None:
        raise OSError("there is no mount")
    done = subprocess.run([program, *words], check=False, capture_output=True, text=True)
    if done.returncode:
        raise OSError(done.stderr.strip() or f"mount ended with {done.returncode}")


@contextmanager
def failing_drive(image: Path, place: Path, megabytes: int) -> Iterator[Drive]:
    """Mount a drive that becomes read-only under whoever writes to it, as a real one does at its first fault.

    A drive is not made read-only by hand as long as a file on it is open to be written.

    Raises
    ------
    OSError
        Where this system lets nobody mount a file with ext4 in it.
    """
    maker = shutil.which("mkfs.ext4")
    if maker is None:
        raise OSError("there is no mkfs.ext4")
    if not image.exists():
        with image.open("wb") as file:
            file.truncate(megabytes << 20)
        subprocess.run([maker, "-q", str(image)], check=True, capture_output=True)
    place.mkdir(parents=True, exist_ok=True)
    _mount("-o", "loop,errors=remount-ro", str(image), str(place))
    try:
        yield Drive(place)
    finally:
        subprocess.run(["umount", "-l", str(place)], check=False, capture_output=True)


def fail(drive: Drive) -> None:
    """Let the file system of a failing drive find a fault: it is read-only from now on."""
    number = drive.place.stat().st_dev
    name = Path(f"/sys/dev/block/{os.major(number)}:{os.minor(number)}").resolve().name
    Path(f"/sys/fs/ext4/{name}/trigger_fs_error").write_text("1", encoding="utf-8")
