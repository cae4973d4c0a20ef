"""The stated covariance of a difference of two schemes holds what repeats show, on shared points and poses."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.accuracy import (
    Centres,
    common_poses_covariance,
    lean_correlation,
    lean_difference,
    shared_points_covariance,
    whole_surface_covariance,
)

N_REPEATS = 4000
STRIP_M = 0.01
POINT_SIGMA_M = 0.01  # of the centre of one strip of 1 cm
HEIGHTS_M = 2.005 + np.arange(101.0)
# 4000 repeats know a covariance to 1/sqrt(4000) = 1.6 %; three of these
TOLERANCE = 0.05


@dataclass(frozen=True)
class Estimator:
    """Slices by their heights, made of strips of 1 cm; ``own_noise`` is what a poor contour adds, in sigmas of a strip."""

    heights_m: NDArray[np.float64]
    strips: int
    own_noise: float = 0.0

    @property
    def centre_sigma_m(self) -> float:
        return POINT_SIGMA_M * float(np.sqrt((1.0 + self.own_noise**2) / self.strips))

    @property
    def centres(self) -> Centres:
        m = len(self.heights_m)
        return Centres(
            z_m=self.heights_m,
            thickness_m=np.full(m, self.strips * STRIP_M),
            covariances_m2=np.tile(np.eye(2) * self.centre_sigma_m**2, (m, 1, 1)),
            weights=np.ones(m),
        )

    @property
    def covariance(self) -> NDArray[np.float64]:
        return np.eye(2) * self.centre_sigma_m**2 * np.sum(self.centres.lean_coefficients**2)

    def leans(self, strips: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """Lean east of every repeat; ``strips`` (repeats, 101, 20) are the centres of the strips about each metre."""
        rows = np.round(self.heights_m - HEIGHTS_M[0]).astype(int)
        first = (strips.shape[2] - self.strips) // 2
        seen = strips[:, rows, first : first + self.strips].mean(axis=2)
        noise = rng.normal(0.0, 1.0, seen.shape) * self.own_noise * POINT_SIGMA_M / np.sqrt(self.strips)
        return (seen + noise) @ self.centres.lean_coefficients


EVERY_METRE = Estimator(HEIGHTS_M, 20)
EVERY_TEN = Estimator(HEIGHTS_M[::10], 20)
ENDS = Estimator(HEIGHTS_M[[0, -1]], 20)
THIN = Estimator(HEIGHTS_M, 1)
THIN_TENS = Estimator(HEIGHTS_M[::10], 1)
POOR_CONTOUR = Estimator(HEIGHTS_M[[0, -1]], 1, own_noise=4.0)
GOOD_CONTOUR = Estimator(HEIGHTS_M[[0, -1]], 1)
BETWEEN = Estimator(HEIGHTS_M[5::10], 20)


@pytest.fixture(scope="module")
def strips() -> NDArray[np.float64]:
    return np.random.default_rng(3).normal(0.0, POINT_SIGMA_M, (N_REPEATS, len(HEIGHTS_M), 20))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        pytest.param(EVERY_TEN, EVERY_METRE, id="fewer of the same slices"),
        pytest.param(ENDS, EVERY_TEN, id="two of few slices"),
        pytest.param(THIN, EVERY_METRE, id="thin within thick"),
        pytest.param(THIN_TENS, EVERY_METRE, id="fewer and thinner"),
        pytest.param(EVERY_TEN, THIN, id="neither holds the other"),
        pytest.param(POOR_CONTOUR, GOOD_CONTOUR, id="same points, poorer contour"),
        pytest.param(POOR_CONTOUR, EVERY_METRE, id="poorer contour of fewer points"),
        pytest.param(EVERY_TEN, BETWEEN, id="no point in common"),
    ],
)
def test_stated_sigma_of_a_difference_is_its_scatter(
    strips: NDArray[np.float64], one: Estimator, other: Estimator
) -> None:
    rng = np.random.default_rng(5)
    scatter = np.std(one.leans(strips, rng) - other.leans(strips, rng))
    stated = shared_points_covariance((one.covariance, other.covariance), one.centres, other.centres)
    assert np.sqrt(stated[0, 0]) == pytest.approx(scatter, rel=TOLERANCE)


def test_the_sum_of_both_covariances_would_be_far_too_large(strips: NDArray[np.float64]) -> None:
    rng, fives = np.random.default_rng(5), Estimator(HEIGHTS_M[::5], 20)
    scatter = np.std(EVERY_TEN.leans(strips, rng) - fives.leans(strips, rng))
    assert np.sqrt(EVERY_TEN.covariance[0, 0] + fives.covariance[0, 0]) > 1.5 * scatter


@pytest.mark.parametrize("one", [EVERY_METRE, EVERY_TEN, THIN])
def test_difference_from_a_fit_of_all_points_is_the_one_less_the_other(
    strips: NDArray[np.float64], one: Estimator
) -> None:
    # all points: 100 strips a metre, of which 20 are those of the slices and 80 lie between them
    rng = np.random.default_rng(7)
    between = rng.normal(0.0, POINT_SIGMA_M / np.sqrt(80.0), strips.shape[:2])
    whole_m = 0.2 * strips.mean(axis=2) + 0.8 * between
    whole = whole_m @ EVERY_METRE.centres.lean_coefficients
    stated = whole_surface_covariance(one.covariance, EVERY_METRE.covariance / 5.0)
    assert stated is not None
    assert np.sqrt(stated[0, 0]) == pytest.approx(np.std(one.leans(strips, rng) - whole), rel=TOLERANCE)


def test_significance_is_found_by_chance_in_one_of_a_hundred_cases(strips: NDArray[np.float64]) -> None:
    rng = np.random.default_rng(9)
    other = np.random.default_rng(11).permutation(strips)
    d = np.stack(
        [EVERY_TEN.leans(seen, rng) - EVERY_METRE.leans(seen, rng) for seen in (strips, other)], axis=1
    )
    covariances = (EVERY_TEN.covariance, EVERY_METRE.covariance)
    stated = shared_points_covariance(covariances, EVERY_TEN.centres, EVERY_METRE.centres)
    found = np.mean([lean_difference(one, stated).significant for one in d[:2000]])
    # 2000 cases: 0.01 plus or minus three times 0.0022
    assert 0.0034 < found < 0.0167


def test_whole_surface_as_uncertain_as_the_slices_says_nothing() -> None:
    assert whole_surface_covariance(np.diag([1.0, 2.0]), np.diag([1.5, 1.0])) is None


def test_an_axis_against_itself_has_no_covariance() -> None:
    covariance = EVERY_TEN.covariance
    shared = shared_points_covariance((covariance, covariance), EVERY_TEN.centres, EVERY_TEN.centres)
    assert np.abs(shared).max() < 1e-9 * covariance.max()


def test_stated_covariances_larger_than_the_centres_keep_their_correlation() -> None:
    plain = shared_points_covariance(
        (EVERY_TEN.covariance, EVERY_METRE.covariance), EVERY_TEN.centres, EVERY_METRE.centres
    )
    larger = shared_points_covariance(
        (4.0 * EVERY_TEN.covariance, 4.0 * EVERY_METRE.covariance), EVERY_TEN.centres, EVERY_METRE.centres
    )
    assert larger == pytest.approx(4.0 * plain)


@pytest.mark.parametrize("seed", range(8))
def test_a_difference_never_has_a_negative_variance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = random_centres(rng), random_centres(rng)
    covariances = (positive(rng), positive(rng))
    assert np.linalg.svd(lean_correlation(first, second))[1].max() <= 1.0 + 1e-12
    assert np.linalg.eigvalsh(shared_points_covariance(covariances, first, second))[0] >= -1e-12


def random_centres(rng: np.random.Generator) -> Centres:
    m = int(rng.integers(2, 9))
    return Centres(
        z_m=np.sort(rng.uniform(0.0, 10.0, m)),
        thickness_m=rng.uniform(0.1, 6.0, m),
        covariances_m2=np.array([positive(rng) for _ in range(m)]),
        weights=rng.uniform(0.1, 1.0, m),
    )


def positive(rng: np.random.Generator) -> NDArray[np.float64]:
    half = rng.normal(size=(2, 2))
    return half @ half.T + 0.1 * np.eye(2)


@pytest.mark.parametrize("turn", [lambda C: C, lambda C: 4.0 * C])
def test_common_poses_leave_only_the_difference_of_their_effects(
    turn: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> None:
    poses = np.array([[4.0, 1.0], [1.0, 3.0]])
    share = 1.0 - np.sqrt(np.linalg.det(turn(poses)) / np.linalg.det(poses)) ** 0.5
    assert common_poses_covariance(poses, turn(poses)) == pytest.approx(share**2 * poses)


def test_centres_of_unequal_number_are_refused() -> None:
    with pytest.raises(ShapeError, match=r"centres need z_m, thickness_m and weights \(m,\)"):
        Centres(np.zeros(3), np.zeros(2), np.zeros((3, 2, 2)), np.zeros(3))
