"""Three kinds of runs to kill: the first of a workspace, one that replaces an epoch, one that adds an epoch."""

import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from storage.workspace import Workspace
from tests.flows.campaigns import small_campaign

STATIONS, POINTS = 3, 8_000
"""So few that a run takes a few seconds, most of them its start."""


@dataclass(frozen=True, slots=True)
class Scene:
    """A run, and the workspace that it begins with."""

    name: str
    campaign: Path
    words: tuple[str, ...]
    before: Path | None
    """Workspace as it was before; None where there is none. Put in the same place each time: settings name paths."""
    workspace: Path

    @property
    def place(self) -> Workspace:
        """The workspace."""
        return Workspace(self.workspace)

    @property
    def command(self) -> Sequence[str]:
        """Words of the command line."""
        return ("run", str(self.campaign), "--workspace", str(self.workspace), *self.words)

    def restore(self, *, keep_home: bool = False) -> None:
        """Put the workspace back as it was before the run; the home of a server that is kept may stay."""
        for path in self.workspace.iterdir() if self.workspace.exists() else ():
            if path.is_dir() and not (keep_home and path == self.place.prefect):
                shutil.rmtree(path)
            elif path.is_file():
                path.unlink()
        if self.before is not None:
            copy_with_stamps(self.before, self.workspace)


def copy_with_stamps(source: Path, target: Path) -> None:
    """Copy a workspace so that the tables keep their inodes and times, by which settled epochs know them.

    Tables are replaced and never changed, so that a link is as good as a copy.
    """

    def copy(found: str, wanted: str) -> None:
        if found.startswith(f"{source}/tables/"):
            os.link(found, wanted)
        else:
            shutil.copy2(found, wanted)

    # a server's home belongs to the place where it was
    ours = shutil.ignore_patterns("prefect")
    shutil.copytree(source, target, copy_function=copy, ignore=ours, dirs_exist_ok=True)


def campaigns_in(folder: Path) -> tuple[Path, Path, Path]:
    """Three campaign files over the same scans: one epoch, two, and two with another setting."""
    two = small_campaign(folder, epochs=2, stations=STATIONS, points=POINTS)
    text = two.read_text(encoding="utf-8")
    one, changed = folder / "one.toml", folder / "changed.toml"
    one.write_text(text[: text.rindex("[[epochs]]")], encoding="utf-8")
    lower = "shaft_z_m = [2.0,"
    if lower not in text:
        raise AssertionError(
            "the simulated campaign has another shaft; change it here, so that results are replaced"
        )
    changed.write_text(text.replace(lower, "shaft_z_m = [4.0,"), encoding="utf-8")
    return one, two, changed
