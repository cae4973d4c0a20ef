import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.simulation import Horizontal, Movement, ShaftShape, axis_truth
from tasks.simulation.shape import BendForm

FORMS: list[BendForm] = ["parabola", "cantilever", "sweep"]


def test_truth_of_a_straight_axis_is_its_own_lean_and_base() -> None:
    shape = ShaftShape(base_m=Horizontal(3.0, -2.0))
    truth = axis_truth(shape, 2.0, 102.01)
    # nothing but rounding separates the quadrature from the formula
    assert truth.lean.as_array() == pytest.approx(shape.lean.as_array(), abs=1e-14)
    assert truth.base_m.as_array() == pytest.approx([3.0, -2.0], abs=1e-12)
    assert truth.bending_m < 1e-12


@pytest.mark.parametrize("form", FORMS)
def test_truth_of_a_bent_axis_is_the_numeric_least_squares_line(form: BendForm) -> None:
    shape = ShaftShape(bend_top_m=Horizontal(0.05, -0.12), bend_form=form)
    truth = axis_truth(shape, 2.0, 102.01)
    z_m = np.linspace(2.0, 102.01, 200_001)
    slope, base_m = np.polyfit(z_m, shape.axis_at(z_m), 1)
    # even sampling of n points differs from the integral by 1/n of the bending part of the slope
    assert truth.lean.as_array() == pytest.approx(slope, abs=2e-8)
    assert truth.base_m.as_array() == pytest.approx(base_m, abs=1e-6)


def test_line_of_a_cantilever_leans_by_six_and_a_half_per_cent_more_than_its_chord() -> None:
    shape = ShaftShape(
        lean=Horizontal(0.0, 0.0), bend_top_m=Horizontal(0.1, 0.0), bend_form="cantilever", height_m=100.0
    )
    truth = axis_truth(shape, 0.0, 100.0)
    # docs/estimators.md: +6.5 % against the chord, printed to one decimal
    assert truth.lean.east * 100.0 / 0.1 == pytest.approx(1.065, abs=0.002)


@pytest.mark.parametrize("form", FORMS)
def test_slope_is_the_derivative_of_the_axis(form: BendForm) -> None:
    shape = ShaftShape(bend_top_m=Horizontal(0.3, 0.2), bend_form=form)
    z_m = np.array([1.0, 40.0, 109.0])
    numeric = (shape.axis_at(z_m + 1e-3) - shape.axis_at(z_m - 1e-3)) / 2e-3
    assert shape.slope_at(z_m) == pytest.approx(numeric, abs=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_bending_moves_the_top_by_the_stated_amount_and_leaves_the_foot(form: BendForm) -> None:
    bent = ShaftShape(bend_top_m=Horizontal(0.3, 0.2), bend_form=form)
    ends_m = np.array([0.0, 110.0])
    moved_m = bent.axis_at(ends_m) - ShaftShape().axis_at(ends_m)
    assert moved_m == pytest.approx(np.array([[0.0, 0.0], [0.3, 0.2]]), abs=1e-12)


def test_range_of_no_height_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"z_lo_m < z_hi_m; got 5.0 and 5.0"):
        axis_truth(ShaftShape(), 5.0, 5.0)


def test_shaft_without_radius_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"positive radii; got 110.0, 0.0"):
        ShaftShape(radius_foot_m=0.0)


def test_unknown_bend_form_is_answered_with_the_known_ones() -> None:
    with pytest.raises(ShapeError, match=r"'banana'.*known: parabola, cantilever"):
        ShaftShape(bend_form="banana")  # type: ignore[arg-type]


def test_default_movement_is_millimetres_to_two_centimetres_at_102_m() -> None:
    first = ShaftShape()
    moved_mm = [
        1e3 * 102.0 * np.hypot(*(Movement().shape_at(first, i).lean.as_array() - first.lean.as_array()))
        for i in range(4)
    ]
    assert moved_mm == pytest.approx([0.0, 3.96, 7.91, 19.78], abs=0.01)


def test_movement_goes_towards_its_azimuth() -> None:
    moved = Movement(azimuth_deg=90.0, lean_arcsec=(0.0, 10.0)).shape_at(
        ShaftShape(lean=Horizontal(0.0, 0.0)), 1
    )
    assert moved.lean.east == pytest.approx(10.0 / 206264.806, rel=1e-8)
    assert moved.lean.north == pytest.approx(0.0, abs=1e-18)


def test_movement_goes_on_by_its_last_step_beyond_its_end() -> None:
    movement = Movement(azimuth_deg=0.0, lean_arcsec=(0.0,), bend_top_m=(0.0, 0.01, 0.03))
    assert movement.shape_at(ShaftShape(), 4).bend_top_m.north == pytest.approx(0.07, abs=1e-15)
    assert movement.shape_at(ShaftShape(), 4).lean.north == ShaftShape().lean.north
