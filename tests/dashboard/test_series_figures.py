"""Drawings over time."""

import pytest

from dashboard.content.direction import direction_of
from dashboard.content.movement import movements_since
from dashboard.content.plan import tops
from dashboard.content.profile import profile_of
from dashboard.content.series import series_points
from dashboard.figures.plan import plan_of_movements, plan_of_tops
from dashboard.figures.profile import axis_profile
from dashboard.figures.schemes_over_time import far_off, schemes_over_time, usual_range
from dashboard.figures.series import Marking, deviation_series, movement_series
from tests.storage.campaign import HEIGHT_M, epoch_row, slice_row, tilt_row

MARKING = Marking(lambda epoch: f"/profile?epoch={epoch}", "e1")
LEANS = ((0.007, -0.0057), (0.0071, -0.0057))
TILTS = [tilt_row(f"e{n}", n, lean, allowable_m=0.0605) for n, lean in enumerate(LEANS)]
EPOCHS = [
    epoch_row("e0", 0),
    epoch_row("e1", 1),
    epoch_row("e2", 2, state="failed", reason="no <scan> of it"),
]


def _marks(figure):
    return next(trace for trace in figure.data if trace.customdata is not None)


def test_points_are_the_deviations_in_millimetres_and_open_their_epochs() -> None:
    marks = _marks(deviation_series(series_points(EPOCHS, TILTS), MARKING))
    assert list(marks.y) == pytest.approx([1e3 * row.deviation_m for row in TILTS])
    assert [data[-1] for data in marks.customdata] == ["/profile?epoch=e0", "/profile?epoch=e1"]


def test_the_limit_is_within_the_drawing() -> None:
    figure = deviation_series(series_points(EPOCHS, TILTS), MARKING)
    assert [shape.y0 for shape in figure.layout.shapes] == [60.5]
    assert max(max(trace.y) for trace in figure.data) > 60.5


def test_a_failed_epoch_is_marked_with_its_reason_and_has_no_value() -> None:
    figure = deviation_series(series_points(EPOCHS, TILTS), MARKING)
    (missing,) = [trace for trace in figure.data if trace.name == "no result"]
    assert "no &lt;scan&gt; of it" in missing.customdata[0][0]
    assert len(_marks(figure).y) == 2


def test_no_band_is_drawn_across_an_epoch_without_a_result() -> None:
    epochs = [epoch_row(f"e{n}", n) for n in range(5)]
    tilts = [tilt_row(f"e{n}", n) for n in (0, 1, 3, 4)]
    figure = deviation_series(series_points(epochs, tilts), MARKING)
    bands = [trace for trace in figure.data if trace.fill == "toself"]
    assert [len(band.x) for band in bands] == [4, 4]


def test_movements_are_drawn_along_the_lean_of_the_reference() -> None:
    direction = direction_of(TILTS[0])
    found = list(movements_since("e0", TILTS, []).values())
    figure = movement_series(found, direction, 0, MARKING)
    moved = HEIGHT_M * 1e-4 * 0.007 / (0.007**2 + 0.0057**2) ** 0.5
    assert list(_marks(figure).y) == pytest.approx([1e3 * moved])


def test_the_plan_has_the_limit_as_a_circle_and_equal_scales() -> None:
    figure = plan_of_tops(tops(TILTS), MARKING)
    (circle,) = [trace for trace in figure.data if trace.name == "limit 60.5 mm"]
    assert (circle.x**2 + circle.y**2) == pytest.approx(60.5**2)
    assert figure.layout.yaxis.scaleanchor == "x"
    assert "N" in [note.text for note in figure.layout.annotations]


def test_movements_in_the_plan_are_east_and_north() -> None:
    marks = _marks(plan_of_movements(movements_since("e0", TILTS, []), "e0", MARKING))
    assert (list(marks.x), list(marks.y)) == (pytest.approx([1e3 * HEIGHT_M * 1e-4]), pytest.approx([0.0]))


def test_a_click_on_a_centre_opens_its_slice() -> None:
    profile = profile_of(
        TILTS[0], [slice_row("e0", index) for index in range(3)], [], direction_of(TILTS[0]), None
    )
    figure = axis_profile(profile, None, lambda index: f"/slice?slice={index}")
    links = {data[-1] for trace in figure.data if trace.customdata is not None for data in trace.customdata}
    assert links == {f"/slice?slice={index}" for index in range(3)}


def test_one_scheme_gone_wrong_does_not_flatten_the_others() -> None:
    values = [1000.0, 1001.0, 1002.0, 1001.5, 1000.5, 480.0]
    limits = usual_range(values)
    assert limits is not None
    assert limits[0] > 900.0
    assert far_off(values) == 1
    assert usual_range([]) is None


def test_every_scheme_and_method_has_a_line_of_its_own() -> None:
    rows = [tilt_row("e0"), tilt_row("e0", scheme="S", method="surface"), tilt_row("e1", 1)]
    assert [trace.name for trace in schemes_over_time(rows, MARKING).data] == ["A/paper", "S/surface"]
