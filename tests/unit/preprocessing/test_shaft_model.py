"""Laws of the model that later stages get."""

import json
from dataclasses import replace

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.exchange import plain, rebuild
from tasks.preprocessing import ShaftModel

MODEL = ShaftModel(
    base_east_m=1.0 / 3.0,
    base_north_m=-2.0,
    lean_east=0.01,
    lean_north=-0.02,
    radius_z_m=(2.0, 12.0, 22.0),
    radius_m=(4.0, 3.5, 3.3),
    bend_east_m=(0.01, -0.02, 0.01),
    bend_north_m=(0.0, 0.0, 0.0),
    noise_sigma_m=0.007,
)


def test_a_model_survives_json_to_the_last_bit() -> None:
    assert rebuild(ShaftModel, json.loads(json.dumps(plain(MODEL)))) == MODEL


def test_profiles_of_different_length_are_misuse() -> None:
    with pytest.raises(ShapeError, match="as many radii"):
        replace(MODEL, radius_m=(3.0, 2.0))


def test_the_straight_axis_passes_the_base_at_height_zero() -> None:
    assert MODEL.straight_axis_at(0.0) == pytest.approx([1.0 / 3.0, -2.0])


def test_the_axis_is_the_straight_one_and_the_bending() -> None:
    assert MODEL.axis_at(12.0) - MODEL.straight_axis_at(12.0) == pytest.approx([-0.02, 0.0])


def test_the_taper_is_the_slope_of_the_radius() -> None:
    z = np.array([3.0, 11.0, 13.0, 21.0])
    slope = (MODEL.radius_at(z + 0.5) - MODEL.radius_at(z - 0.5)) / 1.0
    assert MODEL.taper_at(z) == pytest.approx(slope)


def test_heights_of_any_shape_give_positions_of_that_shape() -> None:
    assert MODEL.axis_at(np.zeros((2, 3))).shape == (2, 3, 2)
