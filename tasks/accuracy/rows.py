"""The rows of the accuracy view."""

from collections.abc import Sequence

from storage.errors import ShapeError
from storage.records import AccuracyRow, TiltRow
from tasks.accuracy.control import QUANTITIES, Control, label_of
from tasks.accuracy.relative_error import relative_error_pct
from tasks.geometry.failure import FitFailure


def accuracy_rows(rows: Sequence[TiltRow], control: Control) -> list[AccuracyRow]:
    """Compare every quantity of every scheme with the control; the control itself is left out.

    Of the azimuth there is a difference only, by the shorter way round: a relative error of a direction
    has no meaning. A quantity that does not exist on either side (an azimuth of an axis that does not
    lean) gives no row; a control of exactly zero gives a row without relative error.

    Parameters
    ----------
    rows : sequence of TiltRow
        Of one structure and epoch.
    control : Control
        What to compare with.

    Returns
    -------
    list of AccuracyRow
        In the order of the rows, then of the quantities.

    Raises
    ------
    ShapeError
        If the rows are of more than one structure or epoch.
    """
    check_one_epoch(rows)
    compared = [row for row in rows if label_of(row) != control.label]
    return [line for row in compared for quantity in QUANTITIES if (line := _compare(row, quantity, control))]


def check_one_epoch(rows: Sequence[TiltRow]) -> None:
    """Refuse rows that cannot stand in one table.

    Raises
    ------
    ShapeError
        If they are of more than one structure or epoch.
    """
    epochs = sorted({f"{row.structure} {row.epoch}" for row in rows})
    if len(epochs) > 1:
        raise ShapeError(f"accuracy needs the rows of one structure and epoch; got {', '.join(epochs)}")


def difference(quantity: str, value: float, reference: float) -> float:
    """Value minus reference in the unit of the quantity; azimuths by the shorter way round."""
    if quantity == "azimuth_deg":
        return (value - reference + 180.0) % 360.0 - 180.0
    return value - reference


def error_pct(quantity: str, value: float, reference: float) -> float | None:
    """Relative error in percent, None where it has no meaning."""
    if quantity == "azimuth_deg":
        return None
    error = relative_error_pct(value, reference)
    return None if isinstance(error, FitFailure) else error


def _compare(row: TiltRow, quantity: str, control: Control) -> AccuracyRow | None:
    value: float | None = getattr(row, quantity)
    reference: float | None = getattr(control, quantity)
    if value is None or reference is None:
        return None
    return AccuracyRow(
        structure=row.structure,
        epoch=row.epoch,
        scheme=row.scheme,
        method=row.method,
        control=control.label,
        quantity=quantity,
        value=value,
        reference=reference,
        difference=difference(quantity, value, reference),
        relative_error_pct=error_pct(quantity, value, reference),
        reference_sigma=control.sigma_of(quantity),
    )
