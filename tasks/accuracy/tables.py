"""Tables 1 to 3 of the paper as records, of one epoch and one method."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from storage.errors import ShapeError
from storage.records import TiltRow
from tasks.accuracy.control import QUANTITIES, Control, label_of
from tasks.accuracy.rows import check_one_epoch, difference, error_pct
from tasks.conventions import azimuth_deg


@dataclass(frozen=True, slots=True)
class FittingTable:
    """Table 1: how the axis of each scheme was fitted; means over the schemes that have the figure."""

    rows: tuple[TiltRow, ...]
    mean_mean_deviation_m: float | None
    mean_rmse_m: float | None


@dataclass(frozen=True, slots=True)
class MonitoringTable:
    """Table 2: what each scheme found."""

    rows: tuple[TiltRow, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """One quantity in table 3: the schemes, their mean, and all of them against the control.

    ``errors_pct`` and ``mean_error_pct`` are eq. 23, None for the azimuth; ``mean_error_pct`` is that of the
    mean value, not the mean of the errors.
    """

    quantity: str
    values: tuple[float | None, ...]
    mean: float | None
    reference: float | None
    differences: tuple[float | None, ...]
    mean_difference: float | None
    errors_pct: tuple[float | None, ...]
    mean_error_pct: float | None


@dataclass(frozen=True, slots=True)
class ComparisonTable:
    """Table 3: every scheme but the control, against the control."""

    control: str
    method: str
    schemes: tuple[str, ...]
    comparisons: tuple[Comparison, ...]
    height_m: float
    allowable_m: float | None

    def comparison(self, quantity: str) -> Comparison:
        """Return the line of that quantity.

        Raises
        ------
        ShapeError
            If the table has none.
        """
        for line in self.comparisons:
            if line.quantity == quantity:
                return line
        raise ShapeError(f"table 3 has no quantity {quantity!r}; it has {', '.join(QUANTITIES)}")


def fitting_table(rows: Sequence[TiltRow]) -> FittingTable:
    """Table 1 from the rows of one epoch and method.

    Raises
    ------
    ShapeError
        If there are none, or they are of several epochs or methods.
    """
    _check_one_method(rows)
    return FittingTable(
        rows=tuple(rows),
        mean_mean_deviation_m=_mean([row.mean_deviation_m for row in rows]),
        mean_rmse_m=_mean([row.rmse_m for row in rows]),
    )


def monitoring_table(rows: Sequence[TiltRow]) -> MonitoringTable:
    """Table 2 from the rows of one epoch and method.

    Raises
    ------
    ShapeError
        If there are none, or they are of several epochs or methods.
    """
    _check_one_method(rows)
    return MonitoringTable(rows=tuple(rows))


def comparison_table(rows: Sequence[TiltRow], control: Control) -> ComparisonTable:
    """Table 3 from the rows of one epoch and method; the control may be of another method.

    Raises
    ------
    ShapeError
        If there is nothing but the control, or rows are of several epochs or methods.
    """
    compared = [row for row in rows if label_of(row) != control.label]
    _check_one_method(compared)
    return ComparisonTable(
        control=control.label,
        method=compared[0].method,
        schemes=tuple(row.scheme for row in compared),
        comparisons=tuple(_comparison(compared, quantity, control) for quantity in QUANTITIES),
        height_m=compared[0].height_m,
        allowable_m=compared[0].allowable_m,
    )


def _comparison(rows: Sequence[TiltRow], quantity: str, control: Control) -> Comparison:
    values: list[float | None] = [getattr(row, quantity) for row in rows]
    reference: float | None = getattr(control, quantity)
    mean = _mean_direction_deg(values) if quantity == "azimuth_deg" else _mean(values)
    return Comparison(
        quantity=quantity,
        values=tuple(values),
        mean=mean,
        reference=reference,
        differences=tuple(_difference(quantity, value, reference) for value in values),
        mean_difference=_difference(quantity, mean, reference),
        errors_pct=tuple(_error_pct(quantity, value, reference) for value in values),
        mean_error_pct=_error_pct(quantity, mean, reference),
    )


def _difference(quantity: str, value: float | None, reference: float | None) -> float | None:
    return None if value is None or reference is None else difference(quantity, value, reference)


def _error_pct(quantity: str, value: float | None, reference: float | None) -> float | None:
    return None if value is None or reference is None else error_pct(quantity, value, reference)


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _mean_direction_deg(values: Sequence[float | None]) -> float | None:
    """Mean of azimuths as directions; None where there are none or they cancel out."""
    angles = np.radians([value for value in values if value is not None])
    if len(angles) == 0:
        return None
    east, north = float(np.mean(np.sin(angles))), float(np.mean(np.cos(angles)))
    # directions that cancel leave rounding only, of the order of 1e-16
    # the modulo of a tiny negative angle rounds to 360 itself; a second one makes it 0
    return azimuth_deg(east, north) if np.hypot(east, north) > 1e-9 else None


def _check_one_method(rows: Sequence[TiltRow]) -> None:
    check_one_epoch(rows)
    methods = sorted({row.method for row in rows})
    if len(methods) != 1:
        raise ShapeError(
            f"a table of the paper needs rows of one method; got {', '.join(methods) or 'no rows'}"
        )
