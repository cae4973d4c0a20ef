"""P3: the engineer's page: the axis from foot to top, along the lean and across it, straight or bent."""

from collections.abc import Sequence

from dash import html
from dash.development.base_component import Component

from dashboard import numbers
from dashboard.content.direction import direction_of
from dashboard.content.profile import Profile, profile_of, shaft_of
from dashboard.figures.profile import axis_profile
from dashboard.page import Page
from dashboard.panel import Panel, Table
from dashboard.view import View
from storage.records import ChangeTestRow, TiltRow
from storage.views import axis_parameter_rows, change_test_rows, coverage_rows


def fill(view: View) -> Sequence[Panel]:
    """Make the panels of the axis."""
    return [_profile(view), _numbers(view), _tests(view)]


PAGE = Page("profile", 3, "Axis", "Where does it lean, is it straight, and which height moved?", fill)


def profile_at(view: View, epoch: str, reference: str | None = None) -> Profile | None:
    """The profile of an epoch, along the lean of another or its own; None where it has no axis."""
    tilt = view.tilt(epoch)
    if tilt is None:
        return None
    direction = direction_of(view.tilt(reference) if reference else tilt)
    parameters = view.reader.ask(axis_parameter_rows, view.structure, epoch)
    of_result = [row for row in parameters if (row.scheme, row.method) == view.result]
    shaft_z_m = shaft_of(view.reader.ask(coverage_rows, view.structure, epoch))
    return profile_of(tilt, view.slices(epoch), of_result, direction, shaft_z_m)


def _profile(view: View) -> Panel:
    epoch = view.epoch.epoch
    profile = profile_at(view, epoch)
    title = f"Axis of {epoch}, {'/'.join(view.result)}"
    if profile is None:
        reason = view.epoch.reason or f"{'/'.join(view.result)} gave no axis in this epoch"
        return Panel("axis", title, None, span=12, missing=reason)
    reference = view.reference
    is_other = reference is not None and reference.epoch != epoch
    ghost = profile_at(view, reference.epoch, epoch) if reference is not None and is_other else None
    address = view.address.at("slice")
    columns = ["slice_index", "z_m", "center_east_m", "center_north_m", "center_cov_ee", "center_cov_en"]
    columns += ["center_cov_nn", "offset_east_m", "offset_north_m", "residual_m", "weight", "state", "reason"]
    rows = [[getattr(row, name) for name in columns] for row in view.slices()]
    note = "Offsets are from the plumb line through the foot of the axis; bars k=2, from the points alone. "
    note += "A click on a centre opens its slice."
    if ghost is not None and reference is not None:
        note += f" Grey: {reference.epoch}."
    return Panel(
        "axis",
        title,
        axis_profile(profile, ghost, lambda index: address.with_more(slice=str(index)).href),
        Table(columns, rows),
        span=12,
        least_px=720,
        note=note,
        missing=None if len(profile.z_m) else "no slice of this axis has a centre",
    )


def _numbers(view: View) -> Panel:
    tilt = view.tilt()
    if tilt is None:
        return Panel("numbers", "In numbers", None, span=6, missing="no axis in this epoch")
    rows = _facts(tilt)
    body = html.Table(
        html.Tbody([html.Tr([html.Th(name), html.Td(text)]) for name, text in rows]), className="facts"
    )
    content: list[Component] = [body]
    if tilt.warning:
        content.append(html.P([html.B("Mind: "), tilt.warning], className="note"))
    return Panel("numbers", "In numbers", html.Div(content), span=6)


def _facts(tilt: TiltRow) -> list[tuple[str, str]]:
    sigma_permille = None if tilt.deviation_sigma_m is None else 2e3 * tilt.deviation_sigma_m / tilt.height_m
    azimuth_u = None if tilt.azimuth_sigma_deg is None else 2.0 * tilt.azimuth_sigma_deg
    tilt_u = None if tilt.tilt_sigma_deg is None else 2.0 * tilt.tilt_sigma_deg
    azimuth = f"{numbers.degrees(tilt.azimuth_deg)} ± {numbers.degrees(azimuth_u)}"
    return [
        ("tilt (k=2)", f"{numbers.dms(tilt.tilt_deg)} ± {numbers.dms(tilt_u)}"),
        (
            "azimuth of lean, clockwise from grid north (k=2)",
            azimuth if tilt.azimuth_deg is not None else numbers.MISSING,
        ),
        (
            "verticality (k=2)",
            f"{numbers.number(tilt.verticality_permille, 3)} ± {numbers.number(sigma_permille, 3)} ‰",
        ),
        (
            f"deviation at {numbers.number(tilt.height_m, 1)} m (k=2)",
            numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m),
        ),
        ("form of the axis", tilt.axis_model or numbers.MISSING),
        ("why that form", tilt.axis_reason or numbers.MISSING),
        ("bending, largest off the straight axis", numbers.mm(tilt.bending_m, 2)),
        ("centres off the axis, RMS", numbers.mm(tilt.rmse_m, 2)),
        ("slices that gave a centre", f"{tilt.n_centres} of {tilt.n_slices}"),
        ("effective number of centres", numbers.number(tilt.n_effective, 1)),
        ("least movement a second epoch would show", numbers.mm(tilt.smallest_detectable_m)),
        ("uncertainty comes from", tilt.covariance_source or numbers.MISSING),
    ]


def _tests(view: View) -> Panel:
    title = f"What changed since {view.reference.epoch}" if view.reference else "What changed"
    rows = [
        row
        for row in view.reader.ask(change_test_rows, view.structure, view.epoch.epoch)
        if (row.scheme, row.method) == view.result
    ]
    asked = view.reference.epoch if view.reference else None
    rows = [row for row in rows if row.reference_epoch == asked]
    if not rows:
        return Panel("tests", title, None, span=6, missing=_untested(view))
    head = ("quantity", "size (k=2)", "p", "found", "from which size on")
    looks = ("", "n", "n", "", "n")
    body = html.Table(
        [
            html.Thead(html.Tr([html.Th(name, className=n) for name, n in zip(head, looks, strict=True)])),
            html.Tbody(
                [
                    html.Tr([html.Td(c, className=n) for c, n in zip(_test(row), looks, strict=True)])
                    for row in rows
                ]
            ),
        ]
    )
    columns = ["quantity", "size_m", "sigma_m", "p_value", "significant", "smallest_detectable_m"]
    columns += ["z_low_m", "z_high_m", "basis", "reason"]
    table = Table(columns, [[getattr(row, name) for name in columns] for row in rows])
    return Panel("tests", title, html.Div(body, className="wide"), table, span=6)


def _untested(view: View) -> str:
    if view.reference is None:
        return "one epoch only: a change takes two"
    if view.reference.epoch == view.epoch.epoch:
        return "changes are counted from this epoch"
    return "not compared with this reference; `tiltwatch compare` does, for any two epochs"


def _test(row: ChangeTestRow) -> list[str]:
    found = {True: "significant", False: "nothing found", None: "not tested"}[row.significant]
    where = (
        "" if row.z_low_m is None else f", {numbers.number(row.z_low_m)} to {numbers.number(row.z_high_m)} m"
    )
    reason = f": {row.reason}" if row.reason else ""
    size = numbers.mm_with_u(row.size_m, row.sigma_m)
    return [
        row.quantity,
        size,
        numbers.probability(row.p_value),
        found + where + reason,
        numbers.mm(row.smallest_detectable_m),
    ]
