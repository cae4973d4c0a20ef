"""Laws of the whole-surface fit: what is done to the points is done to the answer."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tasks.surface import StationPoses, SurfaceFit, SurfacePoints, SurfaceRequest, SurfaceStart, fit_surface
from tests.unit.surface.shafts import Shaft, request_of, scanned, start_of

POINTS = 3000
LEANS = st.tuples(st.floats(-0.09, 0.09), st.floats(-0.09, 0.09))
SEEDS = st.integers(0, 10_000)


def fit_of(request: SurfaceRequest, model: str = "shaft") -> SurfaceFit:
    fit = fit_surface(model, request)
    assert isinstance(fit, SurfaceFit), fit
    return fit


def sigma(fit: SurfaceFit) -> float:
    return float(np.sqrt(np.linalg.eigvalsh(fit.point_covariance)[-1]))


def mapped(request: SurfaceRequest, matrix: NDArray[np.float64], scale: float = 1.0) -> SurfaceRequest:
    """Everything that is asked, with the horizontal plane mapped by an orthogonal matrix and lengths scaled."""
    full = np.eye(3)
    full[:2, :2] = matrix
    full *= scale
    cloud, start = request.cloud, request.start
    axis = scale * np.column_stack([start.east_m, start.north_m]) @ matrix.T
    low, high = start.shaft_z_m
    assert request.poses is not None
    return SurfaceRequest(
        replace(cloud, points_m=cloud.points_m @ full.T),
        SurfaceStart(
            start.z_m * scale, axis[:, 0], axis[:, 1], start.radius_m * scale, (low * scale, high * scale)
        ),
        request.sections,
        StationPoses(request.poses.positions_m @ full.T, request.poses.covariance),
    )


@settings(max_examples=3, deadline=None, derandomize=True)
@given(lean=LEANS, seed=SEEDS, angle=st.floats(0.0, 2 * np.pi))
def test_a_turn_and_a_mirror_of_the_plane_turn_and_mirror_the_lean(
    lean: tuple[float, float], seed: int, angle: float
) -> None:
    shaft = Shaft(points=POINTS, lean=lean)
    request = request_of(scanned(shaft, seed), shaft)
    base = fit_of(request)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    mirror = np.diag([1.0, -1.0])
    # the cells stand still while the points turn under them: the answer follows within a part of its own sigma
    assert fit_of(mapped(request, turn)).lean == pytest.approx(turn @ base.lean, abs=0.25 * sigma(base))
    assert fit_of(mapped(request, mirror)).lean == pytest.approx(mirror @ base.lean, abs=0.25 * sigma(base))


@settings(max_examples=3, deadline=None, derandomize=True)
@given(seed=SEEDS, scale=st.sampled_from([0.1, 10.0, 1000.0]))
def test_a_scale_of_lengths_leaves_the_lean(seed: int, scale: float) -> None:
    shaft = Shaft(points=POINTS)
    request = request_of(scanned(shaft, seed), shaft)
    base = fit_of(request)
    assert fit_of(mapped(request, np.eye(2), scale)).lean == pytest.approx(base.lean, abs=0.02 * sigma(base))


@settings(max_examples=3, deadline=None, derandomize=True)
@given(seed=SEEDS)
def test_every_point_twice_leaves_the_lean_and_halves_its_variance(seed: int) -> None:
    # of a form that is given: twice the points are twice the evidence for bending and waves, and may change a choice
    shaft = Shaft(points=POINTS)
    cloud = scanned(shaft, seed)
    base = fit_of(request_of(cloud, shaft), "cone")
    twice = SurfacePoints(
        np.concatenate([cloud.points_m] * 2), np.concatenate([cloud.station_index] * 2), cloud.n_stations
    )
    doubled = fit_of(request_of(twice, shaft), "cone")
    assert doubled.lean == pytest.approx(base.lean, abs=0.6 * sigma(base))
    assert np.trace(doubled.point_covariance) < 0.65 * np.trace(base.point_covariance)


@settings(max_examples=3, deadline=None, derandomize=True)
@given(
    seed=SEEDS,
    azimuth_deg=st.sampled_from([359.9, 0.0, 0.1, 180.0, 270.0]),
    tilt=st.sampled_from([0.0, 0.5, 5.0]),
)
def test_any_direction_and_tilt_up_to_five_degrees_is_found(
    seed: int, azimuth_deg: float, tilt: float
) -> None:
    tangent = float(np.tan(np.radians(tilt)))
    lean = (
        tangent * float(np.sin(np.radians(azimuth_deg))),
        tangent * float(np.cos(np.radians(azimuth_deg))),
    )
    shaft = Shaft(points=POINTS, lean=lean)
    request = SurfaceRequest(scanned(shaft, seed), start_of(shaft, off_m=0.05), "horizontal", None)
    fit = fit_of(request)
    off = fit.lean - np.array(lean)
    covariance = fit.point_covariance + fit.form_covariance
    assert float(off @ np.linalg.solve(covariance, off)) < 22.0
