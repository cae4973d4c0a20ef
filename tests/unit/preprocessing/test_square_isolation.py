"""Laws of the isolation of towers with four plane faces, on clouds whose truth is known."""

import json

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.exchange import plain, rebuild
from tasks.geometry.failure import FitFailure
from tasks.preprocessing import REASONS, Shaft, ShaftModel, StructurePrior, isolate_shaft
from tests.unit.preprocessing.scenes import ARCSEC, shaft_cloud, stray_cloud
from tests.unit.preprocessing.square_scenes import (
    SQUARE,
    SQUARE_AZIMUTH_RAD,
    SQUARE_LEAN,
    Square,
    gallery,
    long_wall,
    square_cloud,
    square_ladder,
)

# sd of a component for 9500 points on two opposite faces, 6 mm noise: 6 mm / sqrt(9500) / (40 m / sqrt(12)) = 1.1"; 5 sd
STATISTICAL_ARCSEC = 6.0


def isolated(points_m: NDArray[np.float64], prior: StructurePrior = SQUARE) -> Shaft:
    shaft = isolate_shaft(points_m, prior)
    assert isinstance(shaft, Shaft), shaft
    return shaft


def off_lean_arcsec(shaft: Shaft) -> float:
    lean = np.array([shaft.model.lean_east, shaft.model.lean_north])
    return float(np.abs(lean - SQUARE_LEAN).max() * ARCSEC)


def in_range(shaft: Shaft) -> int:
    return int(np.count_nonzero(shaft.reason_index != REASONS.index("outside the height range")))


@pytest.fixture(scope="module")
def crowded() -> Shaft:
    """A tower of 20,000 points, then a ladder, a platform, a denser wall that runs another way, and strays."""
    rng = np.random.default_rng(1)
    return isolated(
        np.vstack(
            [square_cloud(rng), square_ladder(rng), gallery(rng), long_wall(rng), stray_cloud(rng, 5_000)]
        )
    )


def test_a_crowded_site_leaves_the_lean_alone(crowded: Shaft) -> None:
    assert off_lean_arcsec(crowded) < STATISTICAL_ARCSEC


def test_of_ladder_platform_and_wall_nothing_is_kept(crowded: Shaft) -> None:
    assert np.count_nonzero((crowded.keep >= 20_000) & (crowded.keep < 41_000)) == 0


def test_of_the_tower_nearly_everything_is_kept(crowded: Shaft) -> None:
    tower = crowded.reason_index[:20_000]
    lost = np.count_nonzero((tower != REASONS.index("kept")) & (tower != 0))
    assert (
        lost <= 10
    )  # a gate of 4 sigma plus 13 mm loses fewer than one normal point in 10000; some stray duplicates


def test_faces_have_their_azimuths_and_distances(crowded: Shaft) -> None:
    model = crowded.model
    # 6 mm / (1.7 m * sqrt(4800)) = 0.05 mrad, and 6 mm * sqrt(40 / 4800) = 0.5 mm a knot; 5 sd
    nominal = (SQUARE_AZIMUTH_RAD + np.arange(4) * np.pi / 2) % (2 * np.pi)
    assert sorted(face.azimuth_rad for face in model.faces) == pytest.approx(sorted(nominal), abs=4e-4)
    for z in (5.0, 20.0, 37.0):
        assert model.face_distances_at(z) == pytest.approx(np.full(4, 3.0 - 0.02 * (z - 1.0)), abs=3e-3)


def test_two_faces_that_meet_are_enough_to_find_the_tower() -> None:
    rng = np.random.default_rng(2)
    shaft = isolated(np.vstack([square_cloud(rng, 10_000, (0, 1)), square_ladder(rng), long_wall(rng)]))
    assert len(shaft.keep) > 0.995 * np.count_nonzero(shaft.reason_index[:10_000] != 0)


def test_a_side_that_was_not_seen_whole_is_not_claimed_to_be_measured() -> None:
    shaft = isolated(square_cloud(np.random.default_rng(3), 10_000, (0, 1, 2)))
    measured = [face.sigma_m is not None for face in shaft.model.faces]
    assert sorted(measured) == [False, False, True, True]


def test_a_rectangle_has_sides_of_its_own() -> None:
    tower = Square(first_m=(3.4, 2.6), second_m=(2.4, 2.0))
    model = isolated(square_cloud(np.random.default_rng(4), square=tower)).model
    assert sorted(model.face_distances_at(21.0)) == pytest.approx([2.2, 2.2, 3.0, 3.0], abs=3e-3)


def test_a_tower_that_twists_keeps_its_points() -> None:
    shaft = isolated(square_cloud(np.random.default_rng(5), square=Square(twist_rad_per_m=0.001)))
    assert shaft.model.twist_rad_per_m == pytest.approx(0.001, abs=2e-5)
    assert len(shaft.keep) > 0.999 * in_range(shaft)


def test_the_straight_axis_of_a_bent_tower_is_the_best_uniform_one() -> None:
    shaft = isolated(square_cloud(np.random.default_rng(6), square=Square(bend_m=0.2)))
    # the best line through a parabola of 0.2 m over 40 m rises by 0.2 / 40
    assert shaft.model.lean_east == pytest.approx(
        SQUARE_LEAN[0] + 0.2 / 40.0, abs=STATISTICAL_ARCSEC / ARCSEC
    )


def test_a_prior_off_by_a_metre_and_30_percent_finds_the_same_points() -> None:
    cloud = square_cloud(np.random.default_rng(7), 12_000)
    rough = StructurePrior("square-tower", (1.0, 41.0), (1.0, -0.9), (3.9, 2.9))
    near, far = isolated(cloud), isolated(cloud, rough)
    # another sample and other knots move the gate by a fraction of a millimetre
    assert len(np.setxor1d(near.keep, far.keep)) < 0.001 * len(cloud)


def test_heights_with_two_faces_only_are_kept_to_the_top() -> None:
    rng = np.random.default_rng(8)
    shaft = isolated(
        np.vstack([square_cloud(rng, z_m=(0.0, 25.0)), square_cloud(rng, 6_000, (0, 1), z_m=(25.0, 42.0))])
    )
    assert len(shaft.keep) > 0.998 * in_range(shaft)


@pytest.mark.parametrize("faces", [(0,), (0, 2)])
def test_a_wall_or_two_parallel_ones_are_no_tower(faces: tuple[int, ...]) -> None:
    answer = isolate_shaft(square_cloud(np.random.default_rng(9), 8_000, faces), SQUARE)
    assert isinstance(answer, FitFailure)
    assert "faces" in answer.reason


def test_a_round_shaft_taken_for_a_square_tower_is_not_found() -> None:
    prior = StructurePrior("square-tower", (2.0, 62.0), (0.0, 0.0), (3.0, 2.0))
    answer = isolate_shaft(shaft_cloud(np.random.default_rng(10)), prior)
    assert isinstance(answer, FitFailure)
    assert "plane faces" in answer.reason


def test_a_tower_in_feet_is_recognised() -> None:
    answer = isolate_shaft(square_cloud(np.random.default_rng(11), 12_000) / 0.3048, SQUARE)
    assert isinstance(answer, FitFailure)
    assert "looks like feet" in answer.reason


def test_a_model_with_faces_travels_between_stages(crowded: Shaft) -> None:
    assert rebuild(ShaftModel, json.loads(json.dumps(plain(crowded.model)))) == crowded.model


def test_points_of_the_true_surface_are_on_the_surface_of_the_model(crowded: Shaft) -> None:
    exact = square_cloud(np.random.default_rng(12), 3_000, square=Square(noise_m=0.0), z_m=(1.0, 41.0))
    off_m = np.abs(crowded.model.off_surface_m(exact))
    assert (
        np.quantile(off_m, 0.99) < 0.003
    )  # 0.5 mm a knot, five times that; beyond it only at the very corners
