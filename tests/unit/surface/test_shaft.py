import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.geometry.failure import FitFailure
from tasks.surface import SURFACES, StationPoses, SurfaceFit, SurfacePoints, SurfaceRequest, fit_surface
from tests.unit.surface.shafts import (
    ARCSEC,
    HIGH_M,
    LEAN,
    LOW_M,
    Shaft,
    positions,
    request_of,
    scanned,
    start_of,
    turned,
)


def fitted(shaft: Shaft, seed: int = 1, model: str = "shaft") -> SurfaceFit:
    return fit_of(request_of(scanned(shaft, seed), shaft), model)


def fit_of(request: SurfaceRequest, model: str = "shaft") -> SurfaceFit:
    fit = fit_surface(model, request)
    assert isinstance(fit, SurfaceFit), fit
    return fit


def sigmas(fit: SurfaceFit) -> NDArray[np.float64]:
    return np.asarray(np.sqrt(np.diag(fit.point_covariance)))


def test_a_round_shaft_has_the_lean_that_it_was_given() -> None:
    fit = fitted(Shaft())
    assert (np.abs(fit.lean - LEAN) < 3.5 * sigmas(fit)).all()
    assert sigmas(fit) / ARCSEC == pytest.approx([1.39, 1.39], rel=0.08)
    assert fit.curve.model == "straight"
    assert fit.coverage_deg == 360.0


def test_the_stated_sigma_is_the_scatter() -> None:
    shaft = Shaft(points=4000)
    fits = [fitted(shaft, seed) for seed in range(30)]
    chi2 = [float((fit.lean - LEAN) @ np.linalg.solve(fit.point_covariance, fit.lean - LEAN)) for fit in fits]
    # mean 2 with a standard deviation of 2 / sqrt(30)
    assert np.mean(chi2) == pytest.approx(2.0, abs=1.1)


def test_of_a_bent_axis_the_lean_is_the_line_that_fits_best_whatever_the_density() -> None:
    span = HIGH_M - LOW_M

    def cantilever(z: NDArray[np.float64]) -> NDArray[np.float64]:
        s = (z - LOW_M) / span
        return np.column_stack([0.2 * (6 * s**2 - 4 * s**3 + s**4) / 3, np.zeros(len(z))])

    fit = fitted(Shaft(bend=cantilever, density=0.5))
    z = np.linspace(LOW_M, HIGH_M, 4001)
    best = LEAN + np.array([np.polyfit(z, cantilever(z)[:, 0], 1)[0], 0.0])
    assert np.abs(fit.lean - best).max() < 4 * sigmas(fit).max()
    assert fit.curve.model == "cubic"
    assert fit.curve.chord_lean[0] == pytest.approx(LEAN[0] + 0.2 / span, abs=5e-5)
    # a cubic is off the tangent of a cantilever by 3 % of its bending
    assert fit.curve.base_lean[0] == pytest.approx(
        LEAN[0], abs=5 * fit.curve.base_lean_sigma + 0.03 * 0.2 / span * 4
    )


def test_an_oval_is_found_with_its_size_and_direction_and_leaves_the_lean() -> None:
    azimuth = 35.0

    def oval(z: NDArray[np.float64], turn: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(0.03 * np.cos(2 * (turn - np.radians(90 - azimuth))) + 0.0 * z)

    fit = fitted(Shaft(wall=oval))
    assert (np.abs(fit.lean - LEAN) < 3.5 * sigmas(fit)).all()
    bands = [band for band in fit.bands if band.state == "ok"]
    assert np.mean([band.ovality_m for band in bands if band.ovality_m]) == pytest.approx(0.03, abs=0.001)
    assert np.mean([band.roundness_m for band in bands if band.roundness_m]) == pytest.approx(0.06, abs=0.003)
    directions = [band.ovality_azimuth_deg for band in bands if band.ovality_azimuth_deg is not None]
    assert np.median(directions) == pytest.approx(azimuth, abs=1.0)
    assert "harmonics to 2" in fit.section_reason


@pytest.mark.parametrize("arc_deg", [360.0, 120.0])
def test_a_tenth_of_the_points_on_a_ladder_do_not_move_the_lean(arc_deg: float) -> None:
    shaft = Shaft(arc_deg=arc_deg)
    cloud = scanned(shaft, 3)
    clean = fit_of(request_of(cloud, shaft))
    rng = np.random.default_rng(0)
    points = cloud.points_m.copy()
    rows = rng.choice(len(points), len(points) // 10, replace=False)
    turn = np.radians(rng.uniform(20, 50, len(rows)))
    away = 4.6 - 0.019 * (points[rows, 2] - LOW_M) + rng.uniform(0.2, 1.2, len(rows))
    points[rows, :2] = np.outer(points[rows, 2], LEAN) + away[:, None] * np.column_stack(
        [np.cos(turn), np.sin(turn)]
    )
    laddered = fit_of(turned(request_of(cloud, shaft), points))
    assert np.abs(laddered.lean - clean.lean).max() < 1.5 * sigmas(clean).max()


def test_points_that_err_together_are_not_taken_for_many() -> None:
    def rough(z: NDArray[np.float64], turn: NDArray[np.float64]) -> NDArray[np.float64]:
        # patches of 3 m by 15 degrees, 6 mm in or out
        cells = np.random.default_rng(5).normal(0, 0.006, (40, 24))
        return np.asarray(
            cells[((z - LOW_M) / 3.0).astype(int), (np.mod(turn, 2 * np.pi) / np.radians(15)).astype(int)]
        )

    smooth, patched = fitted(Shaft(points=60_000)), fitted(Shaft(points=60_000, wall=rough))
    assert smooth.common_sigma_m < 0.001
    assert patched.common_sigma_m == pytest.approx(0.006, abs=0.002)
    stated, alone = (
        np.sqrt(np.diag(fit.point_covariance + fit.form_covariance)) for fit in (patched, smooth)
    )
    assert stated.min() > 1.5 * alone.max()
    assert (np.abs(patched.lean - LEAN) < 3.5 * stated).all()


@pytest.mark.parametrize("tilt_deg", [0.5, 5.0])
def test_a_cone_that_was_built_plumb_and_leaned_is_round_across_its_axis(tilt_deg: float) -> None:
    """Horizontal cuts of it lean more than its axis by 1 + k^2, and sections across the axis do not."""
    taper, tangent = -0.02, float(np.tan(np.radians(tilt_deg)))
    direction = np.array([tangent, 0.0, 1.0]) / np.hypot(tangent, 1.0)
    rng = np.random.default_rng(2)
    along, turn = rng.uniform(-8.0, 115.0, 40_000), rng.uniform(0, 2 * np.pi, 40_000)
    radius = 4.6 + taper * along + 0.002 * rng.standard_normal(40_000)
    across = np.array([direction[2], 0.0, -direction[0]])
    skin = along[:, None] * direction + (radius * np.cos(turn))[:, None] * across
    skin[:, 1] += radius * np.sin(turn)
    cloud = SurfacePoints(skin, np.zeros(len(skin), dtype=np.uint16), 1)
    shaft = Shaft(lean=(tangent, 0.0), taper=taper)
    right = fit_of(request_of(cloud, shaft, "perpendicular"), "cone")
    wrong = fit_of(request_of(cloud, shaft, "horizontal"), "cone")
    assert right.lean[0] == pytest.approx(tangent, abs=4 * sigmas(right)[0])
    factor = (1 + taper**2) / (1 - taper**2 * tangent**2)
    assert (wrong.lean[0] - right.lean[0]) / tangent == pytest.approx(factor - 1, rel=0.1)


def test_the_pose_of_a_station_moves_the_lean_as_the_jacobian_says() -> None:
    shaft = Shaft(points=20_000, stations=4, sigma_m=0.003)
    request = request_of(scanned(shaft, 4), shaft)
    base = fit_of(request)
    assert base.pose_jacobian is not None
    place = positions(4)[1]
    own = request.cloud.station_index == 1
    # points move by 1 to 2 mm, less than their noise: further out robust weights are not linear any more
    for number, size in enumerate([2e-5, 2e-5, 4e-6, 1e-3, 1e-3, 1e-3]):
        step = np.zeros(6)
        step[number] = size
        points = request.cloud.points_m.copy()
        points[own] += np.cross(step[:3], points[own] - place) + step[3:]
        moved = fit_of(turned(request, points)).lean - base.lean
        foreseen = base.pose_jacobian[:, 6:12] @ step
        # robust weights follow too, which changes a lean by a twentieth of its sigma
        noise = 0.06 * float(sigmas(base).max())
        assert moved == pytest.approx(foreseen, abs=0.15 * float(np.abs(foreseen).max()) + noise)


def test_a_station_that_is_left_out_changes_the_lean_as_foreseen() -> None:
    shaft = Shaft(points=20_000, stations=6)
    request = request_of(scanned(shaft, 6), shaft)
    base = fit_of(request)
    assert base.station_changes is not None
    for station in (0, 3):
        left = request.cloud.station_index != station
        cloud = SurfacePoints(request.cloud.points_m[left], request.cloud.station_index[left], 6)
        moved = fit_of(request_of(cloud, shaft)).lean - base.lean
        assert moved == pytest.approx(base.station_changes[station], abs=0.35 * sigmas(base).max())


def test_the_bootstrap_agrees_with_propagation_on_white_noise() -> None:
    fit = fitted(Shaft(points=20_000))
    assert fit.bootstrap_covariance is not None
    ratio = np.trace(fit.bootstrap_covariance) / np.trace(fit.point_covariance)
    assert 0.5 < ratio < 1.8


def test_what_an_arc_cannot_tell_is_counted_and_what_a_ring_can_is_not() -> None:
    ring, arc = fitted(Shaft()), fitted(Shaft(arc_deg=120.0))
    assert np.trace(ring.form_covariance) < 0.01 * np.trace(ring.point_covariance)
    assert np.trace(arc.form_covariance) > np.trace(arc.point_covariance)


@pytest.mark.parametrize("model", sorted(name for name in SURFACES if name != "faces"))
def test_shifts_turns_and_order_of_points_leave_the_answer(model: str) -> None:
    shaft = Shaft(points=5000, taper=0.0 if model == "cylinder" else -0.019)
    cloud = scanned(shaft, 7)
    base = fit_of(request_of(cloud, shaft), model)
    order = np.random.default_rng(1).permutation(len(cloud.points_m))
    shuffled = SurfacePoints(cloud.points_m[order], cloud.station_index[order], cloud.n_stations)
    assert fit_of(request_of(shuffled, shaft), model).lean == pytest.approx(base.lean, abs=1e-9)
    far = np.array([4.4e6, 6.0e6, 0.0])
    start = start_of(shaft)
    moved = SurfaceRequest(
        SurfacePoints(cloud.points_m + far, cloud.station_index, cloud.n_stations),
        type(start)(
            start.z_m, start.east_m + far[0], start.north_m + far[1], start.radius_m, start.shaft_z_m
        ),
        "horizontal",
        StationPoses(positions(8) + far, 1e-20 * np.eye(48)),
    )
    there = fit_of(moved, model)
    assert there.lean == pytest.approx(base.lean, abs=0.02 * sigmas(base).max())
    assert there.point_m - far == pytest.approx(base.point_m, abs=1e-4)


def test_a_turn_about_the_plumb_line_turns_the_lean() -> None:
    shaft = Shaft(points=8000)
    cloud = scanned(shaft, 8)
    base = fit_of(request_of(cloud, shaft))
    angle = np.radians(90.0)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    points = cloud.points_m.copy()
    points[:, :2] = points[:, :2] @ turn.T
    after = Shaft(points=8000, lean=tuple((turn @ np.array(shaft.lean)).tolist()))
    turned_fit = fit_of(turned(request_of(cloud, after), points))
    assert turned_fit.lean == pytest.approx(turn @ base.lean, abs=0.1 * sigmas(base).max())


def test_a_half_seen_cone_without_noise_has_its_lean() -> None:
    fit = fitted(Shaft(points=6000, sigma_m=0.0, arc_deg=180.0), model="cone")
    assert fit.lean == pytest.approx(LEAN, abs=1e-9)


def test_too_few_points_and_too_short_an_arc_are_refused_with_the_reason() -> None:
    few = fit_surface("shaft", request_of(scanned(Shaft(points=150), 1), Shaft()))
    assert few == FitFailure("needs 200 points on the shaft, got 150")
    short = fit_surface("shaft", request_of(scanned(Shaft(arc_deg=20.0), 1), Shaft()))
    assert isinstance(short, FitFailure)
    assert "deg of the circumference" in short.reason


def test_an_unknown_model_is_answered_with_the_known_ones() -> None:
    with pytest.raises(InputError, match="unknown surface model 'ball'; known: cone, cylinder"):
        fit_surface("ball", request_of(scanned(Shaft(points=300), 1), Shaft()))
