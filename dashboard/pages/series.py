"""P2: quantities of the axis over the epochs, each with its band: absolute, and since the reference."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from dashboard.choices import choice_links, chosen_of
from dashboard.content.series import SeriesPoint, series_points
from dashboard.figures.plan import plan_of_movements
from dashboard.figures.schemes_over_time import far_off, schemes_over_time
from dashboard.figures.series import Quantity, quantity_series
from dashboard.page import Page
from dashboard.panel import Panel, Table
from dashboard.series_panels import deviation_panel, marking, movement_panel, movements_of, no_movement
from dashboard.view import View

BANDS: Final = (("2", "k=2"), ("1", "k=1"), ("3", "k=3"))

QUANTITIES: Final = {
    "tilt": Quantity("tilt, °", lambda t: (t.tilt_deg, t.tilt_sigma_deg), digits=5),
    "azimuth": Quantity(
        "azimuth from grid north, °", lambda t: (t.azimuth_deg, t.azimuth_sigma_deg), digits=2
    ),
    "verticality": Quantity(
        "verticality, ‰",
        lambda t: (
            t.verticality_permille,
            None if t.deviation_sigma_m is None else 1e3 * t.deviation_sigma_m / t.height_m,
        ),
        digits=4,
    ),
    "bending": Quantity("bending, mm", lambda t: (t.bending_m, None), scale=1e3, digits=2),
}
_NOTES: Final = {
    "azimuth": "Only where the lean is above 3 sigma: a plumb axis has no direction.",
    "bending": "Largest distance of a parabola through the centres from the straight axis; it has no sigma of its own here.",
}


def fill(view: View) -> Sequence[Panel]:
    """Make the panels of the time series."""
    k = float(chosen_of(view, "k", BANDS))
    points = series_points(view.epochs, view.series())
    movements = movements_of(view)
    deviation = deviation_panel(view, points, span=12, k=k)
    tool = choice_links(view, "k", BANDS, chosen_of(view, "k", BANDS), "uncertainty")
    return [
        replace(deviation, tools=(tool,)),
        movement_panel(view, movements, component=0, span=6, k=k),
        movement_panel(view, movements, component=1, span=6, k=k),
        _plan(view),
        _schemes(view),
        *[_quantity(view, points, name, k) for name in QUANTITIES],
    ]


PAGE = Page("series", 2, "Time series", "What changed from epoch to epoch, and how sure is that?", fill)


def _plan(view: View) -> Panel:
    movements = movements_of(view)
    reference = "" if view.reference is None else view.reference.epoch
    found = sorted(movements.values(), key=lambda m: m.time)
    columns = ("epoch", "epoch_time", "east_m", "north_m", "size_m", "sigma_m", "significant")
    rows = [
        [
            m.epoch,
            m.time,
            float(m.east_north_m[0]),
            float(m.east_north_m[1]),
            m.size_m,
            m.sigma_m,
            m.significant,
        ]
        for m in found
    ]
    return Panel(
        "movement-plan",
        f"Movement of the top since {reference or '--'}, 95 % ellipses, grid north up",
        plan_of_movements({m.epoch: m for m in found}, reference, marking(view)),
        Table(columns, rows),
        span=6,
        missing=no_movement(view, movements),
        note="Diamonds: significant at 1 %. Older epochs are paler.",
    )


def _schemes(view: View) -> Panel:
    rows = view.tilts()
    columns = ("epoch", "epoch_time", "scheme", "method", "deviation_m", "deviation_sigma_m")
    outside = far_off([1e3 * row.deviation_m for row in rows])
    return Panel(
        "schemes",
        "Deviation by every scheme and method",
        schemes_over_time(rows, marking(view, page="schemes")),
        Table(columns, [[getattr(row, name) for name in columns] for row in rows]),
        span=6,
        missing=None if rows else "no epoch has an axis",
        note=f"{outside} far outside of what is drawn; a double click shows all." if outside else None,
    )


def _quantity(view: View, points: Sequence[SeriesPoint], name: str, k: float) -> Panel:
    quantity = QUANTITIES[name]
    rows = [(row.epoch, row.epoch_time, *quantity.value(row)) for row in view.series()]
    missing = None if any(row[2] is not None for row in rows) else _nothing(name, bool(rows))
    return Panel(
        name,
        name.capitalize(),
        quantity_series(points, quantity, marking(view, k)),
        Table(("epoch", "epoch_time", name, "sigma"), rows),
        span=6,
        missing=missing,
        note=_NOTES.get(name) if missing is None else None,
    )


def _nothing(name: str, has_axis: bool) -> str:
    if not has_axis:
        return "no epoch has an axis of this scheme and method"
    return {"azimuth": "the lean is below 3 sigma in every epoch: it has no direction"}.get(
        name, "this scheme and method does not give it"
    )
