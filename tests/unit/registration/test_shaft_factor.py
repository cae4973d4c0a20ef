from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares

from tasks.conventions import ARCSEC_RAD, rotation_site_scanner
from tasks.geometry.rotations import rotation_from_vector
from tasks.registration import ShaftHint, StationPose
from tasks.registration.adjustment import Adjusted, Gates, Network, adjust, rotation_vector_from
from tasks.registration.planar import scan_planes
from tasks.registration.shaft_factor import (
    FORM_BLOCKS,
    FORM_SIGMA_M,
    KNOTS,
    ShaftPoints,
    shaft_equations,
    shaft_points,
)
from tasks.registration.stated import StatedPose, stated_information
from tests.unit.registration.courtyard import SIGMAS

HINT = ShaftHint((0.0, 0.0), (0.0, 100.0), (4.5, 2.5))
AWAY_M = 230.0
OPPOSITE = (0.2, 0.2 + np.pi)

Form = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


def round_form(azimuth_rad: NDArray[np.float64], z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.zeros_like(z_m)


def twisting_oval(azimuth_rad: NDArray[np.float64], z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """10 mm out of round, and turning by a quarter from foot to top: as like a lean as an oval can be."""
    return 0.01 * np.cos(2.0 * azimuth_rad - np.pi * z_m / 100.0)


def facing(
    rng: np.random.Generator, azimuth_rad: float, n: int, form: Form = round_form, noise_m: float = 0.0005
) -> NDArray[np.float64]:
    """What a station at an azimuth sees of a leaning, tapered shaft: less than half of it, site frame."""
    z = rng.uniform(0.5, 99.5, n)
    azimuth = azimuth_rad + rng.uniform(-1.2, 1.2, n)
    radius = np.interp(z, (0.0, 100.0), (4.5, 2.5)) + form(azimuth, z) + noise_m * rng.normal(size=n)
    return np.column_stack([radius * np.sin(azimuth) + 0.007 * z, radius * np.cos(azimuth) - 0.005 * z, z])


def pose_at(azimuth_rad: float, name: str) -> StationPose:
    position = np.array([AWAY_M * np.sin(azimuth_rad), AWAY_M * np.cos(azimuth_rad), 1.6])
    return StationPose(name, rotation_site_scanner(azimuth_rad + np.pi), position)


def seen_from(azimuths_rad: tuple[float, ...], n: int) -> tuple[ShaftPoints, list[StationPose]]:
    rng = np.random.default_rng(4)
    poses = [pose_at(azimuth, str(k)) for k, azimuth in enumerate(azimuths_rad)]
    points = tuple(
        (facing(rng, azimuth, n) - pose.position_m) @ pose.rotation
        for azimuth, pose in zip(azimuths_rad, poses, strict=True)
    )
    return ShaftPoints(points, HINT), poses


def moved(poses: list[StationPose], step: NDArray[np.float64]) -> list[StationPose]:
    return [
        StationPose(pose.station, rotation_from_vector(own[:3]) @ pose.rotation, pose.position_m + own[3:])
        for pose, own in zip(poses, step.reshape(-1, 6), strict=True)
    ]


def eliminated_cost(shaft: ShaftPoints, poses: list[StationPose]) -> float:
    """Half the weighted sum of squares that is left when axis and radii are free; residuals far below the form."""
    placed = np.concatenate([pose.to_site(own) for pose, own in zip(poses, shaft.points_m, strict=True)])
    z = placed[:, 2]
    knots = np.linspace(0.0, 100.0, KNOTS)
    powers = ((z - 50.0) / 100.0)[:, None] ** np.arange(3)

    def residuals(free: NDArray[np.float64]) -> NDArray[np.float64]:
        axis = powers @ free[:6].reshape(3, 2)
        return np.hypot(*(placed[:, :2] - axis).T) - np.interp(z, knots, free[6:])

    start = np.r_[0.35, -0.25, 0.7, -0.5, 0.0, 0.0, np.interp(knots, (0.0, 100.0), (4.5, 2.5))]
    left = least_squares(residuals, start, xtol=1e-14, ftol=1e-14, gtol=1e-14).cost
    return float(left * FORM_BLOCKS / FORM_SIGMA_M**2 / len(shaft.points_m[0]))


def common_motion(
    poses: list[StationPose], turn: NDArray[np.float64], shift: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Parameters (6n,) of a rigid motion of everything, about the foot of the shaft."""
    return np.concatenate([np.r_[turn, np.cross(turn, pose.position_m) + shift] for pose in poses])


def settle_on_shaft(
    azimuths_rad: tuple[float, ...], form: Form, off_rad: float = 0.0
) -> tuple[Adjusted, list[StationPose]]:
    """Adjust stations that are stated right but for a heading error, and return with it where they truly are."""
    rng = np.random.default_rng(1)
    poses = [pose_at(azimuth, str(k)) for k, azimuth in enumerate(azimuths_rad)]
    planes = scan_planes(
        [
            (facing(rng, azimuth, 12_000, form, 0.004) - pose.position_m) @ pose.rotation
            for azimuth, pose in zip(azimuths_rad, poses, strict=True)
        ]
    )
    stated = moved(poses, np.tile([0.0, 0.0, off_rad, 0.0, 0.0, 0.0], len(poses)))
    statements = tuple(StatedPose(pose, stated_information(SIGMAS), np.ones(6, bool)) for pose in stated)
    shaft = shaft_points(planes, stated, HINT)
    network = Network(tuple(planes), statements, None, shaft)
    return adjust(network, stated, Gates(1.2, 0.0)), poses


def rotations(adjusted: Adjusted, truth: list[StationPose]) -> NDArray[np.float64]:
    """Errors (n, 3) of the rotations, radians."""
    return np.array([rotation_vector_from(a, b) for a, b in zip(adjusted.poses, truth, strict=True)])


def test_gradient_is_the_numeric_derivative_of_the_cost_with_axis_and_radii_eliminated() -> None:
    shaft, poses = seen_from((0.2, 1.5), 400)
    rng = np.random.default_rng(5)
    scale = np.tile(np.r_[np.full(3, 1.0 / AWAY_M), np.ones(3)], 2)
    # out of place by a millimetre at the shaft, so that there is a gradient
    poses = moved(poses, 0.001 * scale * rng.normal(size=12))
    steps = 1e-5 * np.diag(scale)
    numeric = [
        (eliminated_cost(shaft, moved(poses, step)) - eliminated_cost(shaft, moved(poses, -step))) / 2e-5
        for step in steps
    ]
    analytic = -shaft_equations(shaft, poses).vector * scale
    # residuals of a millimetre weigh 0.4 % less under a form of 10 mm
    assert analytic == pytest.approx(numeric, abs=0.01 * np.max(np.abs(numeric)))


@pytest.mark.parametrize(
    ("turn", "shift"),
    [
        ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((0.0, 1.0, 0.0), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    ],
    ids=["tilt east", "tilt north", "yaw", "shift east", "shift north", "shift up"],
)
def test_a_rigid_motion_of_all_stations_is_not_seen(
    turn: tuple[float, ...], shift: tuple[float, ...]
) -> None:
    shaft, poses = seen_from((0.2, 1.5, 3.9), 2000)
    matrix = shaft_equations(shaft, poses).matrix
    motion = common_motion(poses, np.array(turn), np.array(shift))
    # what the same motions would say if each station had made its own way
    apart = sum(motion[k : k + 6] @ matrix[k : k + 6, k : k + 6] @ motion[k : k + 6] for k in (0, 6, 12))
    # the sections of a leaning shaft are slightly oval, its taper is straight only between knots
    assert abs(motion @ matrix @ motion) < 2e-3 * apart


def test_the_yaw_of_one_station_about_the_shaft_is_not_seen() -> None:
    shaft, poses = seen_from((0.2, 1.5, 3.9), 2000)
    matrix = shaft_equations(shaft, poses).matrix
    axis_m = np.array([0.35, -0.25, 0.0])  # of the leaning shaft at mid height
    yaw = np.zeros(18)
    turn = np.array([0.0, 0.0, 1.0])
    yaw[:6] = np.r_[turn, np.cross(turn, poses[0].position_m - axis_m)]
    # the same angle about the scanner moves the shaft by 230 m instead
    assert yaw @ matrix @ yaw < 1e-4 * matrix[2, 2]


def test_a_station_alone_learns_nothing_from_the_shaft() -> None:
    shaft, poses = seen_from((0.2,), 2000)
    equations = shaft_equations(shaft, poses)
    assert not np.any(equations.matrix)
    assert not np.any(equations.vector)
    assert equations.n_points.tolist() == [0]


def test_two_stations_on_opposite_sides_share_no_plane_and_are_tied_in_heading_all_the_same() -> None:
    off = 500.0 * ARCSEC_RAD
    adjusted, truth = settle_on_shaft(OPPOSITE, round_form, off)
    assert sum(len(found.residuals_m) for found in adjusted.matches.values()) == 0
    # both turned the same way move the shaft to opposite sides: that is seen; by the GNSS of 15 mm at 230 m
    # the common heading is known to 10"
    assert abs(rotations(adjusted, truth)[:, 2].mean()) < 30.0 * ARCSEC_RAD
    covariance = np.linalg.inv(adjusted.data_information + adjusted.prior_information)
    together, against = np.zeros(12), np.zeros(12)
    together[[2, 8]], against[[2, 8]] = 0.5, (0.5, -0.5)
    stated = SIGMAS.heading_rad / np.sqrt(2.0)
    assert np.sqrt(together @ covariance @ together) < 0.05 * stated
    # turned against each other they move it to the same side: the shaft may well stand there
    assert np.sqrt(against @ covariance @ against) == pytest.approx(stated, rel=0.02)


@pytest.mark.parametrize("n", [2, 4])
def test_a_shaft_out_of_round_moves_no_level_by_a_fifth_of_what_is_stated(n: int) -> None:
    azimuths = tuple((0.2 + np.arange(n) * 2.0 * np.pi / n).tolist())
    oval, truth = settle_on_shaft(azimuths, twisting_oval)
    levels = rotations(oval, truth)[:, :2]
    assert np.max(np.abs(levels)) < 0.2 * SIGMAS.level_rad
