"""Laws of the isolation on clouds whose truth is known."""

import numpy as np
import pytest

from tasks.preprocessing import KEPT, REASONS, ShaftOptions, StructurePrior
from tests.unit.preprocessing.scenes import (
    ARCSEC,
    CHIMNEY,
    LEAN,
    Oddity,
    counts_of,
    isolated,
    ladder_cloud,
    lean_of,
    off_surface_m,
    shaft_cloud,
    stray_cloud,
)

# sd of a component for 1500 points in each of 24 bands, 8 mm noise: 8 mm * sqrt(24 / 36000) / 60 m = 0.7"; 5 sd
STATISTICAL_ARCSEC = 4.0


def test_a_plain_shaft_gives_its_lean() -> None:
    shaft = isolated(shaft_cloud(np.random.default_rng(1)))
    assert np.abs(lean_of(shaft) - LEAN).max() * ARCSEC < STATISTICAL_ARCSEC


def test_nearly_all_points_of_a_plain_shaft_are_kept() -> None:
    shaft = isolated(shaft_cloud(np.random.default_rng(1)))
    counts = counts_of(shaft)
    # a gate of 4 sigma plus 12 mm loses fewer than one normal point in 10000
    assert counts["inside the shaft"] + counts["off the surface (ladder, platform, surroundings)"] <= 2


def test_counts_add_up_to_all_points() -> None:
    rng = np.random.default_rng(2)
    cloud = np.vstack([shaft_cloud(rng), ladder_cloud(rng), stray_cloud(rng, 5_000)])
    assert sum(removal.n_points for removal in isolated(cloud).removed) == len(cloud)


def test_counts_are_those_of_the_reasons_of_the_points() -> None:
    rng = np.random.default_rng(2)
    shaft = isolated(np.vstack([shaft_cloud(rng), stray_cloud(rng, 5_000)]))
    assert list(counts_of(shaft).values()) == np.bincount(shaft.reason_index, minlength=len(REASONS)).tolist()


def test_kept_indices_ascend_and_are_those_marked_kept() -> None:
    shaft = isolated(shaft_cloud(np.random.default_rng(3)))
    assert np.array_equal(shaft.keep, np.flatnonzero(shaft.reason_index == KEPT))


def test_a_rigid_motion_about_the_vertical_turns_the_lean_with_it() -> None:
    rng = np.random.default_rng(4)
    cloud = np.vstack([shaft_cloud(rng), ladder_cloud(rng)])
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    moved = np.column_stack([cloud[:, :2] @ turn.T + (500.0, -300.0), cloud[:, 2]])
    prior = StructurePrior("chimney", (2.0, 62.0), (500.0, -300.0), (3.0, 2.0))
    # the fit stops when a step is below a hundredth of the noise: 0.08 mm over 60 m are 0.3"
    assert np.abs(lean_of(isolated(moved, prior)) - turn @ lean_of(isolated(cloud))).max() * ARCSEC < 0.5


@pytest.mark.parametrize("offset_m", [(1.0, 0.0), (-0.7, 0.7), (0.0, -1.0)])
@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_a_prior_off_by_a_metre_and_30_percent_finds_the_same_points(
    offset_m: tuple[float, float], factor: float
) -> None:
    rng = np.random.default_rng(5)
    cloud = np.vstack([shaft_cloud(rng, 12_000), ladder_cloud(rng)])
    rough = StructurePrior("chimney", (2.0, 62.0), offset_m, (3.0 * factor, 2.0 * factor))
    kept = np.zeros(len(cloud), dtype=bool)
    kept[isolated(cloud).keep] = True
    found = np.zeros(len(cloud), dtype=bool)
    found[isolated(cloud, rough).keep] = True
    # other knots and another sample move the gate by a fraction of a millimetre
    assert np.count_nonzero(kept ^ found) < 0.001 * len(cloud)


def test_an_oval_shaft_keeps_its_ovality() -> None:
    cloud = shaft_cloud(np.random.default_rng(6), oddity=Oddity(oval_m=0.10))
    shaft = isolated(cloud)
    in_range = np.count_nonzero(shaft.reason_index != REASONS.index("outside the height range"))
    assert len(shaft.keep) > 0.999 * in_range


def test_an_oval_shaft_leaves_the_lean_alone() -> None:
    shaft = isolated(shaft_cloud(np.random.default_rng(6), oddity=Oddity(oval_m=0.10)))
    assert np.abs(lean_of(shaft) - LEAN).max() * ARCSEC < STATISTICAL_ARCSEC


def test_a_bent_shaft_is_kept_to_its_ends() -> None:
    shaft = isolated(shaft_cloud(np.random.default_rng(7), oddity=Oddity(bend_m=0.40)))
    in_range = np.count_nonzero(shaft.reason_index != REASONS.index("outside the height range"))
    assert len(shaft.keep) > 0.999 * in_range


def test_the_axis_of_a_bent_shaft_follows_the_bending() -> None:
    model = isolated(shaft_cloud(np.random.default_rng(7), oddity=Oddity(bend_m=0.40))).model
    z = np.linspace(2.0, 62.0, 30)
    true_east = LEAN[0] * z + 0.40 * (z / 62.0) ** 2
    # centre of a band: 8 mm * sqrt(2 / 800) = 0.4 mm, five times that, and 0.1 mm of chords for a parabola
    assert np.abs(model.axis_at(z)[:, 0] - true_east).max() < 0.003


def test_the_straight_axis_of_a_bent_shaft_does_not_depend_on_where_points_are_dense() -> None:
    rng = np.random.default_rng(8)
    cloud = shaft_cloud(rng, 60_000, Oddity(bend_m=0.40))
    thinned = cloud[(cloud[:, 2] < 20.0) | (rng.random(len(cloud)) < 0.15)]
    assert (
        np.abs(lean_of(isolated(thinned)) - lean_of(isolated(cloud))).max() * ARCSEC < 2 * STATISTICAL_ARCSEC
    )


def test_a_ladder_on_one_side_does_not_bias_the_axis() -> None:
    rng = np.random.default_rng(9)
    plain, ladder = shaft_cloud(rng), ladder_cloud(rng)
    shift = lean_of(isolated(np.vstack([plain, ladder]))) - lean_of(isolated(plain))
    # another sample of points is drawn: the statistical bound again
    assert np.abs(shift).max() * ARCSEC < STATISTICAL_ARCSEC


def test_no_point_of_a_ladder_is_kept() -> None:
    rng = np.random.default_rng(9)
    plain, ladder = shaft_cloud(rng), ladder_cloud(rng)
    assert isolated(np.vstack([plain, ladder])).keep.max() < len(plain)


def test_bands_that_are_half_hidden_do_not_bias_the_axis() -> None:
    cloud = shaft_cloud(np.random.default_rng(10))
    hidden = (cloud[:, 2] > 20.0) & (cloud[:, 2] < 45.0) & (cloud[:, 0] < LEAN[0] * cloud[:, 2])
    shift = lean_of(isolated(cloud[~hidden])) - LEAN
    assert np.abs(shift).max() * ARCSEC < STATISTICAL_ARCSEC


def test_half_hidden_bands_of_an_oval_shaft_lose_no_points() -> None:
    cloud = shaft_cloud(np.random.default_rng(10), oddity=Oddity(oval_m=0.08))
    hidden = (cloud[:, 2] > 20.0) & (cloud[:, 2] < 45.0) & (cloud[:, 0] < LEAN[0] * cloud[:, 2])
    shaft = isolated(cloud[~hidden])
    in_range = np.count_nonzero(shaft.reason_index != REASONS.index("outside the height range"))
    assert len(shaft.keep) > 0.999 * in_range


def test_bands_without_any_point_are_bridged() -> None:
    cloud = shaft_cloud(np.random.default_rng(11))
    shaft = isolated(cloud[(cloud[:, 2] < 25.0) | (cloud[:, 2] > 40.0)])
    assert np.abs(shaft.model.axis_at(32.0) - 32.0 * LEAN).max() < 0.003


def test_as_many_stray_points_as_shaft_points_do_not_bias_the_axis() -> None:
    rng = np.random.default_rng(12)
    plain = shaft_cloud(rng)
    shaft = isolated(np.vstack([plain, stray_cloud(rng, 20_000)]))
    assert np.abs(lean_of(shaft) - LEAN).max() * ARCSEC < STATISTICAL_ARCSEC


def test_stray_points_are_kept_only_within_the_gate() -> None:
    rng = np.random.default_rng(12)
    cloud = np.vstack([shaft_cloud(rng), stray_cloud(rng, 20_000)])
    # 4 sigma and half a per cent of the radius: 32 + 15 mm, and 3 mm for the model's own error
    assert np.abs(off_surface_m(cloud[isolated(cloud).keep])).max() < 0.050


def test_a_platform_around_the_shaft_is_removed() -> None:
    rng = np.random.default_rng(13)
    angle, radius = rng.uniform(0.0, 2.0 * np.pi, 5_000), rng.uniform(2.1, 3.3, 5_000)
    platform = np.column_stack(
        [0.61 + radius * np.cos(angle), -0.37 + radius * np.sin(angle), rng.normal(61.5, 0.02, 5_000)]
    )
    plain = shaft_cloud(rng)
    assert isolated(np.vstack([plain, platform])).keep.max() < len(plain)


def test_a_stray_point_in_a_hidden_part_is_isolated() -> None:
    rng = np.random.default_rng(14)
    cloud = shaft_cloud(rng)
    seen = cloud[(np.abs(cloud[:, 2] - 35.0) > 8.0) | (cloud[:, 0] > LEAN[0] * cloud[:, 2])]
    stray = np.array([[LEAN[0] * 35.0 - true_edge_m(), LEAN[1] * 35.0, 35.0]])
    shaft = isolated(np.vstack([seen, stray]))
    assert REASONS[shaft.reason_index[-1]] == "isolated"


def true_edge_m() -> float:
    return 3.0 - 33.0 / 60.0


def test_every_point_given_twice_is_kept_once() -> None:
    cloud = shaft_cloud(np.random.default_rng(15))
    twice = isolated(np.vstack([cloud, cloud]))
    # the second copies come later in the input and go
    assert twice.keep.max() < len(cloud)


def test_the_answer_is_the_same_each_time() -> None:
    cloud = shaft_cloud(np.random.default_rng(16))
    assert isolated(cloud).model == isolated(cloud).model


def test_another_seed_moves_the_lean_by_less_than_the_noise() -> None:
    cloud = shaft_cloud(np.random.default_rng(16), 60_000)
    shift = lean_of(isolated(cloud)) - lean_of(isolated(cloud, options=ShaftOptions(seed=99)))
    assert np.abs(shift).max() * ARCSEC < STATISTICAL_ARCSEC


def test_the_stated_noise_is_that_of_the_points() -> None:
    shaft = isolated(shaft_cloud(np.random.default_rng(17), oddity=Oddity(noise_m=0.015)))
    # 20000 points: the median absolute value is good to 1 %; the fit takes up as much
    assert shaft.model.noise_sigma_m == pytest.approx(0.015, rel=0.05)


def test_ovality_is_not_taken_for_noise() -> None:
    shaft = isolated(shaft_cloud(np.random.default_rng(17), oddity=Oddity(oval_m=0.10)))
    # as above, and 2 % for the lobes being held back a little
    assert shaft.model.noise_sigma_m == pytest.approx(0.008, rel=0.07)


def test_the_stated_radius_is_the_true_one() -> None:
    model = isolated(shaft_cloud(np.random.default_rng(18))).model
    true_m = [3.0, 2.5, 2.0]
    # 800 points a knot: 8 mm / sqrt(800) = 0.3 mm, more at the ends
    assert model.radius_at(np.array([2.0, 32.0, 62.0])) == pytest.approx(true_m, abs=0.003)


def test_the_input_is_left_as_it_was() -> None:
    cloud = shaft_cloud(np.random.default_rng(19), 5_000)
    before = cloud.copy()
    isolated(cloud, CHIMNEY)
    assert np.array_equal(cloud, before)
