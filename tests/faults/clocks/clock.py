"""Another wall clock and another time zone for real processes of the command line."""

import os
import shutil
import struct
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tests.faults.sites import Site
from tests.flows.calls import ROOT, Called

YEAR_S: Final = 366 * 86_400

SOURCE: Final = Path(__file__).with_name("set_clock.c")


def why_not() -> str | None:
    """Why no process can be given another clock here; None where it can."""
    if not sys.platform.startswith("linux"):
        return "another clock needs LD_PRELOAD, which only Linux has"
    return None if shutil.which("cc") else "another clock needs a C compiler, cc"


@dataclass(frozen=True)
class Clock:
    """A clock that can be set, also while a process lives by it; files are dated by that of the machine."""

    folder: Path

    def __post_init__(self) -> None:
        """Compile what shifts the clock; it runs right."""
        self.folder.mkdir(parents=True, exist_ok=True)
        asked = ["cc", "-shared", "-fPIC", "-O1", "-o", str(self._library), str(SOURCE)]
        subprocess.run(asked, check=True, timeout=60)
        self.set(0)

    @property
    def _library(self) -> Path:
        return self.folder / "set_clock.so"

    @property
    def _file(self) -> Path:
        return self.folder / "shift"

    def set(self, shift_s: int) -> None:
        """Let the clock be so far ahead of the machine's."""
        with self._file.open("r+b" if self._file.exists() else "wb") as file:
            file.write(struct.pack("=q", shift_s))

    def environment(self, zone: str | None = None) -> dict[str, str]:
        """What a process is started with to live by this clock, in a time zone."""
        kept = {name: value for name, value in os.environ.items() if not name.startswith("PREFECT_")}
        kept |= {"PYTHONPATH": str(ROOT), "TILTWATCH_KEEP_SERVER_S": "0", "OMP_NUM_THREADS": "1"}
        kept |= {"LD_PRELOAD": str(self._library), "SET_CLOCK_FILE": str(self._file)}
        return kept if zone is None else kept | {"TZ": zone}

    def start(
        self, site: Site, *words: object, zone: str | None = None, file: Path | None = None
    ) -> "subprocess.Popen[str]":
        """Begin a command on a site, or on another campaign file in it."""
        name, *rest = words
        asked = [
            sys.executable,
            "-m",
            "flows.cli",
            name,
            file or site.file,
            *rest,
            "--workspace",
            site.workspace,
        ]
        return subprocess.Popen(
            [str(word) for word in asked],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            env=self.environment(zone),
        )

    def call(self, site: Site, *words: object, zone: str | None = None) -> Called:
        """Call a command on a site."""
        process = self.start(site, *words, zone=zone)
        try:
            out, err = process.communicate(timeout=300)
        finally:
            process.kill()
        return Called(process.returncode, out, err)
