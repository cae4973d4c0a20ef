"""Campaigns with known truth, drawn without rays: stations around a shaft, what each sees of it, and its errors."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from benchmarks.accuracy.sliced_shaft import BASE_RADIUS_M, HEIGHT_M, LEAN, TAPER
from benchmarks.accuracy.wall import Form, Wall, draw_wall
from tasks.conventions import ARCSEC_RAD
from tasks.geometry.rotations import rotation_from_vector
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel
from tasks.registration import InstrumentSigmas, Registration, StationPose, registered_cloud
from tasks.scheme_lean import IsolatedShaft

DISTANCE_M: Final = 250.0
RANGE_SIGMA_M: Final = 0.006
ANGLE_SIGMA_RAD: Final = 5.0 * ARCSEC_RAD

START_OFF_M: Final = 0.005
START_OFF_RAD: Final = 20.0 * ARCSEC_RAD
"""What the rough model of the shaft is off."""

NOTHING: Final = InstrumentSigmas((1e-7, 1e-7), 1e-10, 1e-10)
POSES: Final = InstrumentSigmas((0.010, 0.010), 15.0 * ARCSEC_RAD, 10.0 * ARCSEC_RAD)


@dataclass(frozen=True, slots=True)
class Campaign:
    """How campaigns are drawn: pose errors with sigmas ``drawn``, while the poses are given with ``stated``."""

    title: str
    drawn: InstrumentSigmas = NOTHING
    stated: InstrumentSigmas = NOTHING
    stations: int = 8
    points: int = 15_000
    rough_m: float = 0.0
    correlation_m: float = 3.0
    oval_m: float = 0.0
    range_offset_m: float = 0.0


def _with_level(sigma_arcsec: float) -> InstrumentSigmas:
    # positions are never known to a micrometre: if they were, the taper of the shaft would give the levels away
    return replace(POSES, level_rad=sigma_arcsec * ARCSEC_RAD)


CAMPAIGNS: Final[Mapping[str, Campaign]] = {
    "noise": Campaign("noise alone"),
    "poses": Campaign('10 mm, 15", 10" drawn and stated', POSES, POSES),
    "levels": Campaign('levels 20" drawn and stated', _with_level(20.0), _with_level(20.0)),
    "unstated": Campaign('levels 20" drawn, 2.9" stated', _with_level(20.0), _with_level(2.9)),
    "rough": Campaign("walls rough by 3 mm over 3 m", rough_m=0.003),
    "rough1": Campaign("walls rough by 3 mm over 1 m", rough_m=0.003, correlation_m=1.0),
    "oval": Campaign("oval by 10 mm", oval_m=0.010),
    "ranges": Campaign("poses, ranges off by 2 mm a station", POSES, POSES, range_offset_m=0.002),
    "poses4": Campaign("poses, 4 stations", POSES, POSES, stations=4),
    "poses3": Campaign("poses, 3 stations", POSES, POSES, stations=3),
    "rough4": Campaign("rough walls, 4 stations", rough_m=0.003, stations=4),
    "rough3": Campaign("rough walls, 3 stations", rough_m=0.003, stations=3),
    "unstated4": Campaign("unstated levels, 4 stations", _with_level(20.0), _with_level(2.9), stations=4),
    "unstated3": Campaign("unstated levels, 3 stations", _with_level(20.0), _with_level(2.9), stations=3),
}


def draw_campaign(campaign: Campaign, rng: np.random.Generator) -> IsolatedShaft:
    """Draw one campaign, registered and isolated."""
    # the wall comes first: the draws are those of the published figures
    wall = wall_of(campaign, rng)
    return draw_epoch(campaign, wall, float(rng.random()), rng)


def wall_of(campaign: Campaign, rng: np.random.Generator) -> Wall:
    """Draw the wall of a campaign."""
    return draw_wall(Form(campaign.rough_m, campaign.correlation_m, campaign.oval_m), rng)


def draw_epoch(campaign: Campaign, wall: Wall, turned: float, rng: np.random.Generator) -> IsolatedShaft:
    """Draw one epoch of a given wall; ``turned`` turns the stations by a part of the angle between them."""
    azimuth = 2.0 * np.pi * (np.arange(campaign.stations) + turned) / campaign.stations
    places = DISTANCE_M * np.column_stack([np.cos(azimuth), np.sin(azimuth)])
    positions = np.column_stack([places, np.full(campaign.stations, 1.7)])
    clouds = [_seen(position, campaign, wall, rng) for position in positions]
    moved = [
        _misplaced(cloud, position, campaign.drawn, rng)
        for cloud, position in zip(clouds, positions, strict=True)
    ]
    index = np.repeat(np.arange(campaign.stations, dtype=np.uint16), [len(cloud) for cloud in clouds])
    cloud = PlacedCloud(np.concatenate(moved), index)
    return IsolatedShaft(cloud, _rough_model(), _registration(positions, campaign.stated), (0.0, HEIGHT_M))


def _seen(
    position_m: NDArray[np.float64], campaign: Campaign, wall: Wall, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Points (n, 3) on the side of the shaft that faces a station, as dense as an even grid of beams leaves them."""
    n = campaign.points
    z = rng.uniform(0.0, HEIGHT_M, n)
    # even in the offset from the line of sight: the density on the skin falls with the cosine of the incidence
    angle = np.arctan2(position_m[1], position_m[0]) + np.arcsin(rng.uniform(-0.985, 0.985, n))
    radius = BASE_RADIUS_M + TAPER * z + wall.off_m(angle, z)
    points = np.column_stack([LEAN[0] * z + radius * np.cos(angle), LEAN[1] * z + radius * np.sin(angle), z])
    sight = points - position_m
    distance = np.linalg.norm(sight, axis=1, keepdims=True)
    beam = sight / distance
    across = np.cross(rng.normal(size=(n, 3)), beam) * (ANGLE_SIGMA_RAD * distance)
    along = rng.normal(0.0, RANGE_SIGMA_M, (n, 1)) + rng.normal(0.0, campaign.range_offset_m)
    return np.asarray(points + beam * along + across)


def _misplaced(
    points_m: NDArray[np.float64],
    position_m: NDArray[np.float64],
    drawn: InstrumentSigmas,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    turn = rotation_from_vector(rng.normal(0.0, [drawn.level_rad, drawn.level_rad, drawn.heading_rad]))
    horizontal, vertical = drawn.position_m
    shift = rng.normal(0.0, [horizontal, horizontal, vertical])
    return np.asarray((points_m - position_m) @ turn.T + position_m + shift)


def _registration(positions_m: NDArray[np.float64], stated: InstrumentSigmas) -> Registration:
    each = [registered_cloud(f"ST{number + 1:02d}", stated) for number in range(len(positions_m))]
    return replace(
        each[0],
        poses=tuple(
            StationPose(one.poses[0].station, np.eye(3), position)
            for one, position in zip(each, positions_m, strict=True)
        ),
        covariance=block_diag(*(one.covariance for one in each)),
        diagnoses=tuple(one.diagnoses[0] for one in each),
    )


def _rough_model() -> ShaftModel:
    knots = np.linspace(0.0, HEIGHT_M, 11)
    straight = (0.0,) * len(knots)
    return ShaftModel(
        base_east_m=START_OFF_M,
        base_north_m=-START_OFF_M,
        lean_east=float(LEAN[0]) + START_OFF_RAD,
        lean_north=float(LEAN[1]) - START_OFF_RAD,
        radius_z_m=tuple(float(z) for z in knots),
        radius_m=tuple(float(radius) for radius in BASE_RADIUS_M + TAPER * knots),
        bend_east_m=straight,
        bend_north_m=straight,
        noise_sigma_m=RANGE_SIGMA_M,
    )
