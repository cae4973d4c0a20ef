"""The axes of an epoch that stand side by side in a figure: one of each scheme, of the paper's method where it has one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from dashboard.paper_figures.subject import Subject
from storage.records import SchemeRow, SliceRow, TiltRow
from storage.views import scheme_rows, slice_rows_of, tilt_rows
from storage.workspace import Workspace

MOST_SCHEMES: Final = 8
PREFERRED: Final = ("paper", "robust", "surface")


@dataclass(frozen=True, slots=True)
class SchemeShown:
    """A scheme under one method: its slices from the bottom, and its axis or the reason why there is none."""

    scheme: str
    method: str
    slices: Sequence[SliceRow]
    axis: TiltRow | None
    reason: str | None

    @property
    def label(self) -> str:
        """Scheme and method."""
        return f"{self.scheme}/{self.method}"


@dataclass(frozen=True, slots=True)
class SchemesShown:
    """Schemes side by side, and the direction and the foot that all are seen from: those of the primary axis."""

    shown: Sequence[SchemeShown]
    left_out: Sequence[str]
    along_deg: float
    foot_m: tuple[float, float]
    height_m: float
    nothing: str
    """What to say where there are none."""

    def turned(self, east_m: NDArray[np.float64], north_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Along the lean and across it (n, 2), counted from the foot; across is to the left of the lean, seen from above."""
        east, north = east_m - self.foot_m[0], north_m - self.foot_m[1]
        sine, cosine = np.sin(np.radians(self.along_deg)), np.cos(np.radians(self.along_deg))
        return np.column_stack([east * sine + north * cosine, north * sine - east * cosine])


def schemes_of(ws: Workspace, subject: Subject) -> SchemesShown:
    """Read the schemes of an epoch, those of the paper first, S and those of users after them."""
    epoch = subject.epoch
    states = _one_method_each(scheme_rows(ws, epoch.structure, epoch.epoch))
    tilts = tilt_rows(ws, epoch.structure, epoch.epoch)
    slices = slice_rows_of(ws, epoch.structure, epoch.epoch)
    primary = next(iter(sorted(tilts, key=lambda row: (row.scheme, row.method) != subject.primary)), None)
    shown = [_shown(state, slices, tilts) for state in states]
    return SchemesShown(
        shown[:MOST_SCHEMES],
        [scheme.label for scheme in shown[MOST_SCHEMES:]],
        90.0
        if primary is None
        else float(np.degrees(np.arctan2(primary.lean_east, primary.lean_north))) % 360.0,
        (0.0, 0.0) if primary is None else (primary.base_east_m, primary.base_north_m),
        epoch.height_m,
        subject.because("no scheme of this epoch was measured"),
    )


def left_out_told(schemes: SchemesShown) -> str:
    """Which schemes a figure had no room for; nothing where it shows all."""
    return f" Not shown: {', '.join(schemes.left_out)}." if schemes.left_out else ""


def _one_method_each(states: Sequence[SchemeRow]) -> list[SchemeRow]:
    chosen: dict[str, SchemeRow] = {}
    for state in sorted(
        states, key=lambda row: PREFERRED.index(row.method) if row.method in PREFERRED else len(PREFERRED)
    ):
        chosen.setdefault(state.scheme, state)
    return sorted(
        chosen.values(), key=lambda row: (row.scheme not in "ABCDEF", row.scheme != "S", row.scheme)
    )


def _shown(state: SchemeRow, slices: Sequence[SliceRow], tilts: Sequence[TiltRow]) -> SchemeShown:
    which = (state.scheme, state.method)
    return SchemeShown(
        *which,
        [row for row in slices if (row.scheme, row.method) == which],
        next((row for row in tilts if (row.scheme, row.method) == which), None),
        state.reason,
    )
