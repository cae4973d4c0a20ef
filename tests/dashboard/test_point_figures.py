"""Drawings of slices and of the surface: what is drawn is what the rows and the points say."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plotly.graph_objects import Figure

from dashboard.content.harmonics import Harmonic
from dashboard.content.ring import ring_of
from dashboard.content.section import Section, section_of
from dashboard.content.surface import StationMark, skin_change, skin_map
from dashboard.figures.contour import contour_figure
from dashboard.figures.slice import harmonics_figure, heights_figure, rose_figure
from dashboard.figures.surface import LONGEST_NAME, change_figure, map_figure
from tests.dashboard.test_ring import ring_points, without
from tests.dashboard.test_section import TILT, row, shaft
from tests.dashboard.test_surface_content import change_rows, map_rows
from tests.storage.campaign import slice_row

HOSTILE = "<img src=x onerror=alert(1)>"


def section(**changed: object) -> Section:
    found = section_of(row(**changed), [row(**changed)], shaft(), TILT)
    assert isinstance(found, Section)
    return found


def trace(figure: Figure, name: str) -> Any:
    return next(each for each in figure.data if (each.name or "").startswith(name))


def names(figure: Figure) -> set[str]:
    return {each.name for each in figure.data if each.name}


def with_gap() -> Section:
    whole = section()
    contour = ring_of(without(ring_points(), 40.0, 100.0), 4.0, 5.0)
    return replace(whole, contour=contour, rose=ring_of(without(ring_points(), 40.0, 100.0), 4.0, 10.0))


@pytest.mark.parametrize("times", [1, 10, 200])
def test_a_contour_is_drawn_with_its_deviations_so_many_times_as_large(times: int) -> None:
    shown = section()
    drawn = trace(contour_figure(shown, times), "contour")
    expected = 4.0 + times * (shown.contour.radial_m - 4.0)
    np.testing.assert_allclose(np.array(drawn.r, dtype=float)[:-1], expected)
    np.testing.assert_allclose(np.array(drawn.theta)[:-1], shown.contour.azimuth_deg)
    # closed
    assert drawn.r[0] == drawn.r[-1]


def test_the_exaggeration_is_written_on_the_drawing() -> None:
    texts = [a.text for a in contour_figure(section(), 50).layout.annotations]
    assert any("radial ×50" in text for text in texts)
    assert any("true to scale" in a.text for a in contour_figure(section(), 1).layout.annotations)


def test_the_drawing_has_north_up_and_goes_clockwise() -> None:
    angular = contour_figure(section(), 50).layout.polar.angularaxis
    assert (angular.direction, angular.rotation) == ("clockwise", 90)


def test_where_no_points_are_there_is_a_grey_arc_and_no_contour() -> None:
    figure = contour_figure(with_gap(), 50)
    drawn, arc = trace(figure, "contour"), trace(figure, "no points")
    inside = (np.array(drawn.theta) > 40.0) & (np.array(drawn.theta) < 100.0)
    assert np.isnan(np.array(drawn.r, dtype=float)[inside]).all()
    assert drawn.connectgaps is False
    angles = [angle for angle in arc.theta if angle is not None]
    assert (min(angles), max(angles)) == (40.0, 100.0)


def test_a_whole_contour_has_no_grey_arc() -> None:
    assert "no points" not in names(contour_figure(section(), 50))


def test_an_oval_that_was_fitted_is_drawn_as_such() -> None:
    drawn = trace(contour_figure(section(ovality_m=0.01, ovality_azimuth_deg=30.0), 50), "fitted oval")
    assert max(drawn.r) == pytest.approx(4.0 + 50 * 0.01)
    assert drawn.theta[int(np.argmax(drawn.r))] % 180.0 == pytest.approx(30.0)


def test_without_a_fit_no_circle_is_drawn() -> None:
    failed = section(center_east_m=None, center_north_m=None, radius_m=None, state="failed", reason="few")
    assert not {"fitted circle", "fitted oval", "centre"} & names(contour_figure(failed, 50))
    assert "axis (no centre)" in names(contour_figure(failed, 50))


def test_bars_are_the_deviations_of_the_sectors_in_mm() -> None:
    rose = with_gap().rose
    figure = rose_figure(rose)
    np.testing.assert_allclose(figure.data[0].y, 1e3 * rose.deviation_m[rose.seen])
    np.testing.assert_allclose(figure.data[0].x, rose.azimuth_deg[rose.seen])
    grey = [(s.x0, s.x1) for s in figure.layout.shapes if s.type == "rect"]
    assert grey == [(40.0, 100.0)]


def test_a_gap_over_north_is_grey_on_both_sides() -> None:
    rose = ring_of(without(ring_points(), 350.0, 370.0), 4.0, 10.0)
    shapes = rose_figure(rose).layout.shapes
    assert [(s.x0, s.x1) for s in shapes if s.type == "rect"] == [(350.0, 360.0), (0.0, 10.0)]


def test_a_wave_that_is_not_told_is_two_dashes_and_no_bar() -> None:
    known, missing = Harmonic(2, 0.01, 30.0, 0.001), Harmonic(3, None, None, None)
    figure = harmonics_figure([known, missing])
    assert list(figure.data[0].x) == [2]
    assert list(figure.data[0].y) == [10.0]
    assert [(a.x, a.text) for a in figure.layout.annotations] == [(3, "--")]


def test_every_slice_has_its_mark_and_its_address() -> None:
    slices = [slice_row("e0", 0), replace(slice_row("e0", 1), state="failed", rmse_m=None, reason=HOSTILE)]
    good, bad = heights_figure(slices, 1, lambda index: f"/slice?slice={index}").data
    assert [point[-1] for point in good.customdata] == ["/slice?slice=0"]
    assert [point[-1] for point in bad.customdata] == ["/slice?slice=1"]
    assert "<img" not in bad.customdata[0][0]


def test_a_map_shows_its_pieces_in_mm_with_their_address() -> None:
    skin = skin_map(map_rows())
    assert skin is not None
    figure = map_figure(skin, 3.0, [], lambda z_m: f"/slice?z={z_m:.2f}")
    heat = figure.data[0]
    np.testing.assert_allclose(heat.z, 1e3 * skin.deviation_m)
    assert (heat.zmin, heat.zmax) == (-3.0, 3.0)
    assert heat.customdata[2][0] == "/slice?z=8.25"
    assert heat.text[1][7] == "-- no points"


def test_what_is_within_its_level_of_detection_is_pale() -> None:
    change = skin_change(change_rows())
    assert change is not None
    heat, pale = change_figure(change, 3.0, [], lambda z_m: f"/slice?z={z_m}").data
    np.testing.assert_allclose(heat.z, 1e3 * change.change_m)
    within = np.isfinite(np.array(pale.z, dtype=float))
    np.testing.assert_array_equal(within, np.isfinite(change.change_m) & ~change.significant)


def test_names_of_stations_are_text_and_short() -> None:
    skin = skin_map(map_rows())
    assert skin is not None
    marks = [StationMark(HOSTILE, 12.0, 80.0)]
    figure = map_figure(skin, 3.0, marks, lambda z_m: f"/{z_m}")
    assert "<img" not in json.dumps(figure.to_plotly_json(), default=str)
    shown = figure.data[-1].text[0].replace("&lt;", "<")
    assert len(shown) == LONGEST_NAME
