"""What of a workspace is drawn: an epoch, and the axes of it that were asked for."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from storage.drawing.content import DrawingFrame
from storage.errors import StorageError, UsageError
from storage.records import EpochRow, SliceRow, TiltRow
from storage.views import epoch_rows, tilt_rows
from storage.workspace import Workspace

SchemeRow = TypeVar("SchemeRow", TiltRow, SliceRow)


@dataclass(frozen=True, slots=True)
class DrawingChoice:
    """Which epoch, scheme and method; None is the newest epoch, the primary axis.

    ``frame_of`` gives the frame in which the geometry of an epoch is to lie.
    """

    structure: str
    primary: tuple[str, str]
    frame_of: Callable[[EpochRow], DrawingFrame]
    epoch: str | None = None
    scheme: str | None = None
    method: str | None = None

    @property
    def names_an_axis(self) -> bool:
        """Whether a scheme or a method is asked for."""
        return self.scheme is not None or self.method is not None

    def takes(self, scheme: str, method: str) -> bool:
        """Whether an axis is meant."""
        if not self.names_an_axis:
            return (scheme, method) == self.primary
        return scheme == (self.scheme or scheme) and method == (self.method or method)


def epoch_with_axes(ws: Workspace, choice: DrawingChoice) -> EpochRow:
    """The epoch that was asked for, else the newest that has an axis.

    Raises
    ------
    UsageError
        If there is no such epoch.
    StorageError
        If no epoch has an axis, or the catalog cannot be read.
    """
    measured = {row.epoch for row in tilt_rows(ws, choice.structure)}
    return _epoch(ws, choice, lambda row: row.epoch in measured, "an axis")


def epoch_with_points(ws: Workspace, choice: DrawingChoice) -> EpochRow:
    """The epoch that was asked for, else the newest that has points on the shaft.

    Raises
    ------
    UsageError
        If there is no such epoch.
    StorageError
        If no epoch has points, or the catalog cannot be read.
    """
    return _epoch(ws, choice, lambda row: row.n_points_used > 0, "an isolated shaft")


def _epoch(ws: Workspace, choice: DrawingChoice, is_fit: Callable[[EpochRow], bool], needed: str) -> EpochRow:
    rows = epoch_rows(ws, choice.structure)
    if choice.epoch is None:
        fit = [row for row in rows if is_fit(row)]
        if not fit:
            raise StorageError(
                f"no epoch of {choice.structure} in {ws.root} has {needed}; `tiltwatch run FILE` processes what is missing"
            )
        return fit[-1]
    named = next((row for row in rows if row.epoch == choice.epoch), None)
    if named is None:
        known = ", ".join(row.epoch for row in rows) or "none"
        raise UsageError(f"unknown epoch {choice.epoch!r} of {choice.structure}; in the workspace: {known}")
    if not is_fit(named):
        because = f": {named.reason}" if named.reason else ""
        raise StorageError(f"epoch {named.epoch} is {named.state} and has not {needed}{because}")
    return named


def of_the_axes(rows: Sequence[SchemeRow], choice: DrawingChoice, epoch: str) -> list[SchemeRow]:
    """Rows of the schemes and methods that were asked for.

    Raises
    ------
    UsageError
        If the epoch has none of them, with those that it has.
    """
    taken = [row for row in rows if choice.takes(row.scheme, row.method)]
    if not taken:
        wanted = f"{choice.scheme or 'any scheme'}/{choice.method or 'any method'}"
        asked = wanted if choice.names_an_axis else f"the primary {'/'.join(choice.primary)}"
        raise UsageError(f"epoch {epoch} has nothing of {asked}; known: {_labels(rows)}")
    return taken


def _labels(rows: Iterable[SchemeRow]) -> str:
    return ", ".join(dict.fromkeys(f"{row.scheme}/{row.method}" for row in rows)) or "none"
