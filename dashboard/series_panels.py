"""Panels over all epochs, which several pages have: the deviation, and how the top moved."""

from collections.abc import Mapping, Sequence
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from dashboard import numbers
from dashboard.content.direction import Direction, direction_of
from dashboard.content.movement import Movement, movements_since
from dashboard.content.series import SeriesPoint
from dashboard.figures.series import Marking, Trend, deviation_series, movement_series
from dashboard.panel import Cell, Panel, Table
from dashboard.view import View
from storage.records import TrendRow
from storage.views import trend_rows

SIDES = ("along", "across")


def marking(view: View, k: float = 2.0, page: str = "profile") -> Marking:
    """Mark the epoch that is shown; a click on another opens it on a page."""
    address = view.address.at(page)
    return Marking(lambda epoch: address.choosing(epoch=epoch).href, view.epoch.epoch, k)


def movements_of(view: View) -> Mapping[str, Movement]:
    """How the top moved since the reference that the reader chose, by epoch."""
    if view.reference is None:
        return {}
    return movements_since(view.reference.epoch, view.series(), view.changes())


def trend_of(view: View) -> TrendRow | None:
    """The trend of the scheme and method that is shown."""
    rows = view.reader.ask(trend_rows, view.structure)
    return next((row for row in rows if (row.scheme, row.method) == view.result), None)


def deviation_panel(view: View, points: Sequence[SeriesPoint], span: int, k: float = 2.0) -> Panel:
    """The deviation over time against its limit."""
    rows = view.series()
    columns = ("epoch", "epoch_time", "deviation_m", "deviation_sigma_m", "allowable_m", "verdict")
    return Panel(
        "deviation",
        f"Deviation at {numbers.number(view.epoch.height_m, 1)} m, {'/'.join(view.result)}, band k={k:g}",
        deviation_series(points, marking(view, k)),
        Table(columns, [[getattr(row, name) for name in columns] for row in rows]),
        span=span,
        missing=None if rows else f"{'/'.join(view.result)} gave no axis in any epoch",
        note=gone(points),
    )


def movement_panel(
    view: View, movements: Mapping[str, Movement], component: int, span: int, k: float = 2.0
) -> Panel:
    """A component of the movement of the top since the reference, with the trend where there is one."""
    reference = view.reference
    direction = direction_of(None if reference is None else view.tilt(reference.epoch))
    since = numbers.MISSING if reference is None else reference.epoch
    found = sorted(movements.values(), key=lambda m: m.time)
    origin = None if reference is None else (reference.epoch, reference.epoch_time)
    return Panel(
        f"movement-{SIDES[component]}",
        f"Change since {since}, {direction.words[component]}, bars k={k:g}",
        movement_series(
            found, direction, component, marking(view, k), origin, _trend(view, direction, component)
        ),
        _table(found, direction),
        span=span,
        missing=no_movement(view, movements),
    )


def no_movement(view: View, movements: Mapping[str, Movement]) -> str | None:
    """Say why there is no movement to show; None where there is one."""
    if view.reference is None:
        return "one epoch only: a change takes two"
    return (
        None if movements else f"{'/'.join(view.result)} gave no axis in the reference epoch, or in no other"
    )


def gone(points: Sequence[SeriesPoint]) -> str | None:
    """Name the epochs that have no result, with the reason."""
    lost = [f"{point.epoch} ({numbers.brief(point.reason)})" for point in points if point.tilt is None]
    return f"No result: {'; '.join(lost)}" if lost else None


def _trend(view: View, direction: Direction, component: int) -> Trend | None:
    """The rate in one direction, from the change point on where there is one."""
    row = trend_of(view)
    if row is None or row.rate_east_m_per_year is None or row.rate_north_m_per_year is None:
        return None
    turned = direction.turn(_vector(row.rate_east_m_per_year, row.rate_north_m_per_year))
    sigma = None
    if row.rate_cov_ee is not None and row.rate_cov_en is not None and row.rate_cov_nn is not None:
        matrix = _matrix(row.rate_cov_ee, row.rate_cov_en, row.rate_cov_nn)
        sigma = float(direction.turn_covariance(matrix)[component, component]) ** 0.5
    since: datetime = max(row.first_time, row.change_point_time or row.first_time)
    return Trend(float(turned[component]), sigma, since, row.last_time)


def _table(found: Sequence[Movement], direction: Direction) -> Table:
    columns = ["epoch", "epoch_time", "along_m", "across_m", "d_top_m", "sigma_top_m"]
    columns += ["significant", "p_value", "smallest_detectable_m", "basis"]
    return Table(columns, [_row(m, direction) for m in found])


def _row(m: Movement, direction: Direction) -> list[Cell]:
    along, across = (float(value) for value in m.turned(direction))
    tested = [m.significant, m.p_value, m.detectable_m, m.basis]
    return [m.epoch, m.time, along, across, m.size_m, m.sigma_m, *tested]


def _vector(east: float, north: float) -> NDArray[np.float64]:
    return np.array([east, north])


def _matrix(ee: float, en: float, nn: float) -> NDArray[np.float64]:
    return np.array([[ee, en], [en, nn]])
