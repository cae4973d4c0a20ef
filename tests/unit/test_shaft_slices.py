"""Slices that follow the points of a shaft, and what their centres really scatter by."""

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.records import SectionFit
from tasks.contours import CONTOURS
from tasks.methods import Method, methods_of, needs_sights
from tasks.preprocessing import ShaftModel
from tasks.sections import fit_sections
from tasks.shaft_slices import ShaftCloud, slice_cloud
from tasks.slicing import SCHEMES, AdaptiveCut, user_scheme

NOISE_M = 0.012
WANTED_M = 0.003
SHAFT_M = (2.0, 102.0)
MODEL = ShaftModel(
    0.3, -0.2, 0.007, -0.007, (2.0, 102.0), (4.6, 2.7), (0.0, 0.0), (0.0, 0.0), noise_sigma_m=NOISE_M
)
SCHEME = user_scheme("G", adaptive=AdaptiveCut(WANTED_M, most_thickness_m=20.0))
ROBUST = methods_of(SCHEME)[0]
WEIGHING = next(name for name, model in CONTOURS.items() if model.weighs_sights)


def uneven_cloud(seed: int, n: int = 12_000) -> NDArray[np.float64]:
    """A shaft whose density falls sixfold to the top, whose back is seen ever less, and thinner than the front."""
    rng = np.random.default_rng(seed)
    z = 2.0 + 100.0 * rng.beta(0.9, 1.6, n)
    half_arc = np.where(z < 40.0, np.pi, np.radians(165.0 - 0.6 * (z - 40.0)))
    place = rng.uniform(-1.0, 1.0, n)
    azimuth = half_arc * np.sign(place) * np.abs(place) ** 1.3 + 0.5
    radius = MODEL.radius_at(z) + NOISE_M * rng.normal(size=n)
    out = np.column_stack([np.sin(azimuth), np.cos(azimuth)])
    return np.column_stack([MODEL.axis_at(z) + radius[:, None] * out, z])


def errors(sections: tuple[SectionFit, ...]) -> Iterator[tuple[float, float]]:
    """Height, and error of the less certain component, of every centre that was to reach the wanted sigma."""
    for fit in sections:
        covariance = np.array(
            [[fit.center_cov_ee, fit.center_cov_en], [fit.center_cov_en, fit.center_cov_nn]]
        )
        direction = np.linalg.eigh(covariance)[1][:, -1]
        found = np.array([fit.center_east_m, fit.center_north_m])
        yield fit.z_m, float((found - MODEL.axis_at(fit.z_m)) @ direction)


def test_centres_scatter_by_the_wanted_sigma_whatever_density_and_coverage() -> None:
    found = np.array(
        [
            one
            for seed in range(4)
            for one in errors(fit_sections(uneven_cloud(seed), MODEL, SCHEME, ROBUST, SHAFT_M))
        ]
    )
    # about 200 centres a part: their scatter is told to 5 %
    for part in np.array_split(found[np.argsort(found[:, 0])], 5):
        assert np.sqrt(np.mean(part[:, 1] ** 2)) == pytest.approx(WANTED_M, rel=0.15)


def test_every_slice_of_an_uneven_shaft_states_its_own_thickness_and_place() -> None:
    points = uneven_cloud(1)
    sections = fit_sections(points, MODEL, SCHEME, ROBUST, SHAFT_M)
    thickness = np.array([fit.thickness_m for fit in sections])
    middles = np.array([fit.z_m for fit in sections])
    assert thickness[-3:].min() > 5.0 * thickness[:3].max()
    assert np.diff(middles) == pytest.approx((thickness[1:] + thickness[:-1]) / 2.0)
    assert sum(fit.n_points for fit in sections) == len(points)


def test_sigmas_of_sights_count_by_their_ratios() -> None:
    points = uneven_cloud(1)
    alone = fit_sections(points, MODEL, SCHEME, ROBUST, SHAFT_M)
    stated_wrong = fit_sections(points, MODEL, SCHEME, ROBUST, SHAFT_M, np.full(len(points), 0.001))
    assert stated_wrong == alone


def test_points_of_less_noise_make_thinner_slices_for_a_contour_that_weighs_them() -> None:
    points = uneven_cloud(1, n=60_000)
    sigma_m = np.where(np.arange(len(points)) % 2, NOISE_M, NOISE_M / 4.0)
    weighing = Method("robust", WEIGHING, "robust_line", 0.02)
    fine = user_scheme("G", adaptive=AdaptiveCut(0.001, least_thickness_m=0.01, most_thickness_m=20.0))
    cloud = ShaftCloud(points, MODEL, sigma_m)
    alike, weighed = (len(slice_cloud(cloud, fine, method, SHAFT_M)) for method in (ROBUST, weighing))
    # variances in units of the larger one: the mean of 1 and 1/16, against one over the mean of 1 and 16
    assert weighed / alike == pytest.approx((17.0 / 32.0) / (2.0 / 17.0), rel=0.1)


def test_a_contour_that_weighs_sights_says_why_it_cannot_without_stations() -> None:
    method = Method("robust", WEIGHING, "robust_line", 0.2)
    (section, *_) = fit_sections(uneven_cloud(1), MODEL, SCHEMES["C"], method, SHAFT_M)
    assert section.state == "failed"
    assert section.reason is not None
    assert "sigma of every point" in section.reason


def test_only_adaptive_slices_and_weighing_contours_need_the_sigma_of_points() -> None:
    paper, robust = methods_of(SCHEMES["A"])
    assert not needs_sights(SCHEMES["A"], paper)
    assert not needs_sights(SCHEMES["A"], robust)
    assert needs_sights(SCHEMES["A"], Method("robust", WEIGHING, "robust_line", 0.2))
    assert needs_sights(SCHEME, ROBUST)


def test_the_paper_does_not_measure_slices_that_follow_the_points() -> None:
    assert [method.name for method in methods_of(SCHEME)] == ["robust"]
