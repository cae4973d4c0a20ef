"""Slicing schemes and methods of an epoch beside each other: what each gave, at which price, against the primary."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from storage.records import (
    AccuracyRow,
    ReferenceLeanRow,
    SchemeComparisonRow,
    SchemeRow,
    SliceRow,
    StageRunRow,
    TiltRow,
)

Pair: TypeAlias = tuple[str, str]

METHODS_FIRST: Final = ("surface", "robust", "paper")

TWO_CENTRES: Final = "a line through two centres: nothing is left over to adjust"
"""Why schemes of two slices have neither iterations nor residuals."""


@dataclass(frozen=True, slots=True)
class Way:
    """A scheme and method of an epoch; ``tilt`` is None where it gave no axis, and ``reason`` says why.

    ``seconds`` is what slicing, contours and axis took when they were computed; None with ``seconds_reason``.
    """

    scheme: str
    method: str
    row: SchemeRow | None
    tilt: TiltRow | None
    beside: SchemeComparisonRow | None
    n_contours: int | None
    seconds: float | None
    seconds_reason: str | None
    is_primary: bool

    @property
    def label(self) -> str:
        """Scheme and method as they are written everywhere."""
        return f"{self.scheme}/{self.method}"

    @property
    def reason(self) -> str:
        """Why there is no axis."""
        stored = None if self.row is None else self.row.reason
        return stored or "no axis, and no reason is stored"

    @property
    def is_direct(self) -> bool:
        """Whether the axis is a line through two centres."""
        return self.tilt is not None and self.tilt.iterations is None


@dataclass(frozen=True, slots=True)
class Given:
    """The rows of an epoch that tell of its schemes."""

    schemes: Sequence[SchemeRow]
    tilts: Sequence[TiltRow]
    comparison: Sequence[SchemeComparisonRow]
    slices: Sequence[SliceRow]
    runs: Sequence[StageRunRow]
    """Stages of the epoch, of all its runs."""


def ways(given: Given, primary: Pair) -> list[Way]:
    """All schemes and methods of an epoch, S first, those that failed too."""
    tilts = {(row.scheme, row.method): row for row in given.tilts}
    rows = {(row.scheme, row.method): row for row in given.schemes}
    beside = {(row.scheme, row.method): row for row in given.comparison if row.scheme is not None}
    contours = contours_made(given.slices)
    return [
        Way(
            *pair,
            row=rows.get(pair),
            tilt=tilts.get(pair),
            beside=beside.get(pair),
            n_contours=contours.get(pair),
            seconds=(found := seconds_of(given.runs, pair))[0],
            seconds_reason=found[1],
            is_primary=pair == primary,
        )
        for pair in sorted({*rows, *tilts}, key=order_of)
    ]


def order_of(pair: Pair) -> tuple[bool, str, int, str]:
    """Where a scheme and method stands among the others."""
    scheme, method = pair
    place = METHODS_FIRST.index(method) if method in METHODS_FIRST else len(METHODS_FIRST)
    return scheme != "S", scheme, place, method


def contours_made(slices: Iterable[SliceRow]) -> dict[Pair, int]:
    """How many slices of each scheme and method got a contour."""
    made: dict[Pair, int] = {}
    for row in slices:
        pair = (row.scheme, row.method)
        made[pair] = made.get(pair, 0) + (row.contour is not None or row.center_east_m is not None)
    return made


def seconds_of(runs: Sequence[StageRunRow], pair: Pair) -> tuple[float | None, str | None]:
    """What the stages of a scheme and method took, and why that is not known.

    What the newest run took from the cache counts as it was computed, found by the key of its record.
    """
    ours = [row for row in runs if row.stage.endswith(f" {pair[0]}/{pair[1]}")]
    if not ours:
        return None, "no run of the ledger tells of it"
    newest = max(row.run for row in ours)
    spent = {row.cache_key: row.seconds for row in ours if row.seconds is not None}
    parts = [spent.get(row.cache_key) for row in ours if row.run == newest]
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None, "taken from the cache, and no run of the ledger computed it"
    return sum(known), None


@dataclass(frozen=True, slots=True)
class Mark:
    """The deviation that a way or a reference measurement found, metres; ``scheme`` is None for a measurement."""

    label: str
    scheme: str | None
    method: str | None
    value_m: float
    sigma_m: float | None
    is_primary: bool


def marks(found: Sequence[Way], references: Sequence[ReferenceLeanRow]) -> list[Mark]:
    """What there is to draw of an epoch; measurements by other means come last."""
    drawn = [
        Mark(
            way.label,
            way.scheme,
            way.method,
            way.tilt.deviation_m,
            way.tilt.deviation_sigma_m,
            way.is_primary,
        )
        for way in found
        if way.tilt is not None
    ]
    return drawn + [
        Mark(row.source, None, None, row.deviation_m, row.deviation_sigma_m, is_primary=False)
        for row in references
    ]


def near_range(values: Sequence[tuple[float, float]], middle: float, share: float = 2.0 / 3.0) -> float:
    """How far from the middle such a share of (value, half-width) reaches, so that a wild one hides no other.

    Raises
    ------
    ValueError
        If there is nothing.
    """
    if not values:
        raise ValueError("needs a value or more, got none")
    reaches = sorted(abs(value - middle) + half for value, half in values)
    return reaches[min(int(share * len(reaches)), len(reaches) - 1)]


def recommended(found: Sequence[Way]) -> Way | None:
    """The way of fewest slices that is enough."""
    return next((way for way in found if way.beside is not None and way.beside.is_recommended), None)


QUANTITIES: Final[Mapping[str, str]] = {
    "beta_deg": "β",
    "tilt_deg": "tilt",
    "verticality_permille": "verticality",
    "deviation_m": "deviation",
}
"""What table 3 compares, and how it is called."""


@dataclass(frozen=True, slots=True)
class Control:
    """What table 3 compares with; ``values`` by quantity."""

    label: str
    values: Mapping[str, float]


def stored_control(rows: Sequence[AccuracyRow]) -> Control | None:
    """The control of the campaign; None where it has no axis in the epoch."""
    if not rows:
        return None
    label = rows[0].control
    return Control(label, {row.quantity: row.reference for row in rows if row.control == label})


def control_of(way: Way) -> Control | None:
    """Any way as a control; None where it has no axis."""
    if way.tilt is None:
        return None
    return Control(way.label, {name: getattr(way.tilt, name) for name in QUANTITIES})


def relative_error_pct(value: float, reference: float | None) -> float | None:
    """Eq. 23 of the paper; None without a reference, or one of zero."""
    return None if not reference else 100.0 * abs(value - reference) / abs(reference)


def means(
    found: Sequence[Way], quantity: str, control: Control
) -> dict[str, tuple[list[str], float, float | None]]:
    """Per method: which ways, their mean value, and its relative error; as the paper, without the control."""
    answer = {}
    for method in sorted({way.method for way in found}, key=lambda name: order_of(("", name))):
        counted = [way for way in found if way.method == method and way.tilt and way.label != control.label]
        if len(counted) < 2:
            continue
        mean = sum(getattr(way.tilt, quantity) for way in counted) / len(counted)
        answer[method] = (
            [way.scheme for way in counted],
            mean,
            relative_error_pct(mean, control.values.get(quantity)),
        )
    return answer
