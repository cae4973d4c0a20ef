"""P4: one slice: what its points show, what was fitted to them, and what became of it in the axis."""

from collections.abc import Sequence

from dash import dcc, html
from dash.development.base_component import Component

from dashboard import numbers
from dashboard.content.ring import Ring
from dashboard.content.section import EXAGGERATIONS, NoSection, Section, exaggeration_for, section_of
from dashboard.figures.contour import contour_figure
from dashboard.figures.slice import harmonics_figure, heights_figure, rose_figure
from dashboard.page import Page
from dashboard.panel import Panel, Table
from dashboard.slides import slide
from dashboard.view import View
from storage.errors import StorageError, UsageError
from storage.records import SliceRow
from storage.views.shaft_points import shaft_points

MOST_MARKS = 8
"""Heights written at the slide."""


def fill(view: View) -> Sequence[Panel]:
    """Make the panels of a slice."""
    slices = view.slices()
    if not slices:
        reason = numbers.brief(
            view.epoch.reason or f"{'/'.join(view.result)} cut no slice in this epoch", 400
        )
        return [Panel("contour", f"Slices of {view.epoch.epoch}", None, span=12, missing=reason)]
    row = chosen_slice(view, slices)
    section = _section(view, row, slices)
    return [
        _place(view, row, slices),
        _contour(view, row, section),
        _heights(view, row, slices),
        _numbers(row, section),
        _rose(section),
        _harmonics(row, section),
    ]


PAGE = Page("slice", 4, "Slice", "Is this section round, complete, and where is its centre?", fill)


def chosen_slice(view: View, slices: Sequence[SliceRow]) -> SliceRow:
    """The slice that the address asks for: by ``slice``, its number, or ``z``, a height; else the middle one.

    Raises
    ------
    UsageError
        If it asks for none of them.
    """
    number, height = view.address.more.get("slice"), view.address.more.get("z")
    if number is None and height is None:
        return slices[len(slices) // 2]
    if number is None:
        z_m = _height_of(height or "")
        return min(slices, key=lambda row: abs(row.z_m - z_m))
    found = next((row for row in slices if str(row.slice_index) == number), None)
    if found is not None:
        return found
    raise UsageError(
        f"unknown slice {number[:40]!r} of {'/'.join(view.result)} in epoch {view.epoch.epoch}; known: "
        f"{slices[0].slice_index} to {slices[-1].slice_index}"
    )


def _height_of(text: str) -> float:
    try:
        z_m = float(text)
    except ValueError:
        z_m = float("nan")
    if abs(z_m) < float("inf"):
        return z_m
    raise UsageError(f"z needs a height in metres; got {text[:40]!r}")


def _section(view: View, row: SliceRow, slices: Sequence[SliceRow]) -> Section | NoSection:
    try:
        points = view.reader.ask(shaft_points, view.structure, view.epoch.epoch)
    except StorageError as fault:
        return NoSection(str(fault))
    return section_of(row, slices, points, view.tilt())


def _place(view: View, row: SliceRow, slices: Sequence[SliceRow]) -> Panel:
    place = slices.index(row)
    step = max(1, -(-(len(slices) - 1) // MOST_MARKS))
    marks = {at: f"{slices[at].z_m:.0f} m" for at in range(0, len(slices), step)}
    known = f"{slices[0].slice_index} to {slices[-1].slice_index}"
    title = f"Slice {row.slice_index} ({known}), z = {row.z_m:.2f} m, {1e3 * row.thickness_m:.0f} mm thick"
    tools = [
        _step(view, slices, place - 1, "key-down", "↓ below"),
        _step(view, slices, place + 1, "key-up", "↑ above"),
    ]
    content = html.Div(slide("slice", row.slice_index, _by_index(marks, slices), slices[-1].slice_index))
    return Panel("place", title, content, span=12, tools=tools)


def _by_index(marks: dict[int, str], slices: Sequence[SliceRow]) -> dict[int, str]:
    return {slices[at].slice_index: text for at, text in marks.items()}


def _step(view: View, slices: Sequence[SliceRow], place: int, key: str, text: str) -> Component:
    if not 0 <= place < len(slices):
        return html.Span(text, className="calm turn")
    href = _link(view, slices[place].slice_index)
    return dcc.Link(text, href=href, id=key, className="turn", title="arrow keys do the same")


def _link(view: View, index: int) -> str:
    more = {key: value for key, value in view.asked.more.items() if key == "times"}
    return view.asked.at("slice", **more, slice=str(index)).href


def _contour(view: View, row: SliceRow, section: Section | NoSection) -> Panel:
    title = "Contour, grid north up"
    if isinstance(section, NoSection):
        return Panel("contour", title, None, span=5, missing=section.reason)
    times = _times(view, section)
    chips = [
        dcc.Link(
            f"×{each}", href=_scaled(view, row, each), className="chip here" if each == times else "chip"
        )
        for each in EXAGGERATIONS
    ]
    return Panel(
        "contour",
        title,
        contour_figure(section, times),
        _ring_table(section.contour),
        span=5,
        tools=[html.Div(chips, className="chips", style={"margin": 0})],
        note=_contour_note(section),
    )


def _scaled(view: View, row: SliceRow, times: int) -> str:
    return view.asked.at("slice", slice=str(row.slice_index), times=str(times)).href


def _times(view: View, section: Section) -> int:
    wanted = view.address.more.get("times")
    if wanted is None:
        return exaggeration_for(section)
    if wanted not in map(str, EXAGGERATIONS):
        raise UsageError(f"times needs one of {', '.join(map(str, EXAGGERATIONS))}; got {wanted[:40]!r}")
    return int(wanted)


def _contour_note(section: Section) -> str:
    parts = ["Points are brought to the middle height along the wall."]
    if section.is_flat:
        parts.append("The wall has flat faces: what is off the circle is their form.")
    if not section.has_centre:
        parts.append(
            "No contour was fitted: the slice is seen from the axis, and the circle is the median of its sectors."
        )
    if section.contour.gaps:
        widest = max(gap.width_deg for gap in section.contour.gaps)
        parts.append(
            f"{360.0 - section.contour.coverage_deg:.0f}° have no points, {widest:.0f}° of them in one gap."
        )
    return " ".join(parts)


def _heights(view: View, row: SliceRow, slices: Sequence[SliceRow]) -> Panel:
    columns = ["slice_index", "z_m", "thickness_m", "n_points", "radius_m", "rmse_m", "arc_coverage_deg"]
    columns += ["ovality_m", "ovality_azimuth_deg", "roundness_m", "state", "reason"]
    return Panel(
        "heights",
        "All slices",
        heights_figure(slices, row.slice_index, lambda index: _link(view, index)),
        Table(columns, [[getattr(each, name) for name in columns] for each in slices]),
        span=3,
    )


def _numbers(row: SliceRow, section: Section | NoSection) -> Panel:
    rows = [*_fitted(row), *_in_axis(row)]
    if isinstance(section, Section):
        rows[3:3] = _shown(section)
    body = html.Table(html.Tbody([html.Tr([html.Td(name), html.Td(text)]) for name, text in rows]))
    return Panel("numbers", "In numbers", html.Div(body), span=4)


def _fitted(row: SliceRow) -> list[tuple[str, str]]:
    azimuth = numbers.degrees(row.ovality_azimuth_deg, 0)
    return [
        ("points, of them in the fit", f"{numbers.count(row.n_points)}, {numbers.count(row.n_points_fit)}"),
        ("circumference with points", numbers.degrees(row.arc_coverage_deg, 0)),
        ("radius", numbers.number(row.radius_m, 4, "m")),
        ("points off the contour, RMS", numbers.mm(row.rmse_m, 2)),
        ("noise of the points, robust", numbers.mm(row.noise_m, 2)),
        ("ovality of the fit, larger diameter at", f"{numbers.mm(row.ovality_m, 2)}, {azimuth}"),
        ("contour", row.contour or numbers.MISSING),
        *([("why this contour", row.contour_reason)] if row.contour_reason else []),
    ]


def _shown(section: Section) -> list[tuple[str, str]]:
    ring = section.contour
    least = "at least " if ring.gaps and ring.range_m is not None else ""
    name = f"largest minus smallest radius, sectors of {ring.sector_deg:.0f}°"
    return [(name, f"{least}{numbers.mm(ring.range_m)}")]


def _in_axis(row: SliceRow) -> list[tuple[str, str]]:
    u_m = None if row.sigma_center_m is None else numbers.COVERAGE * row.sigma_center_m
    east, north = (numbers.number(value, 4) for value in (row.center_east_m, row.center_north_m))
    became = "kept" if row.state == "ok" else f"rejected: {row.reason or 'no reason is stored'}"
    return [
        ("centre east, north", numbers.MISSING if row.center_east_m is None else f"{east}, {north} m"),
        ("uncertainty of either (k=2)", numbers.mm(u_m, 2)),
        ("centre off the axis", numbers.mm(row.residual_m, 2)),
        ("weight in the axis", numbers.number(row.weight, 3)),
        ("radius off the line of all", numbers.signed_mm(row.radius_offset_m, 2)),
        ("this slice was", became),
    ]


def _rose(section: Section | NoSection) -> Panel:
    title = "Deviation from the circle by sector of 10°, bars k=2"
    if isinstance(section, NoSection):
        return Panel("rose", title, None, span=7, missing=section.reason)
    return Panel("rose", title, rose_figure(section.rose), _ring_table(section.rose), span=7)


def _harmonics(row: SliceRow, section: Section | NoSection) -> Panel:
    title = "Waves of the contour, bars k=2"
    if isinstance(section, NoSection) or section.is_flat:
        reason = section.reason if isinstance(section, NoSection) else f"a {row.contour} has no waves"
        return Panel("harmonics", title, None, span=5, missing=reason)
    if all(each.amplitude_m is None for each in section.harmonics):
        reason = "too little of the circumference has points for any wave to be told"
        return Panel("harmonics", title, None, span=5, missing=reason)
    columns = ["order", "amplitude_m", "sigma_m", "azimuth_deg"]
    rows = [[getattr(each, name) for name in columns] for each in section.harmonics]
    note = "Pale: not told from 0."
    if any(each.amplitude_m is None for each in section.harmonics):
        note += " --: the gaps do not let it be told."
    return Panel(
        "harmonics", title, harmonics_figure(section.harmonics), Table(columns, rows), span=5, note=note
    )


def _ring_table(ring: Ring) -> Table:
    columns = ["azimuth_low_deg", "azimuth_high_deg", "n_points", "radius_m", "deviation_m", "sigma_m"]
    low = ring.azimuth_deg - ring.sector_deg / 2
    values = zip(
        low, low + ring.sector_deg, ring.n_points, ring.radial_m, ring.deviation_m, ring.sigma_m, strict=True
    )
    return Table(
        columns,
        [[_or_none(float(value)) if i != 2 else int(value) for i, value in enumerate(row)] for row in values],
    )


def _or_none(value: float) -> float | None:
    return None if value != value else value  # noqa: PLR0124 (NaN stands for what does not exist)
