"""Where one more station would help most: the covariance of the lean vector predicted with it, at every azimuth.

The prediction is for circles with free radii at each height and a straight axis, every point of the same weight. It has
two parts: what the points leave uncertain (their noise, and the form of the shaft, which is not round and shows alike to
all stations that see the same place), and what the levels and headings of the stations do.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.conventions import ARCSEC_RAD, PARAMETERS_PER_STATION
from tasks.coverage import SECTOR_DEG, SECTORS, Coverage
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import mad_sigma
from tasks.preprocessing import ShaftModel
from tasks.registration import InstrumentSigmas, Registration
from tasks.uncertainty import combine, propagate_directional_poses

WEAKEST: Final = 1e-6
"""Least ratio of the two eigenvalues of the lean's information: below it one direction of lean is not seen at all."""


@dataclass(frozen=True, slots=True)
class NextStation:
    """The azimuth, from the axis clockwise from grid north, at which one more station helps most.

    The sigmas are those of one component of the lean vector, root mean square of both: with the present stations and
    with the one more.
    """

    azimuth_deg: float
    sigma_now_arcsec: float
    sigma_then_arcsec: float

    @property
    def gain(self) -> float:
        """Share by which the sigma falls."""
        return 1.0 - self.sigma_then_arcsec / self.sigma_now_arcsec


@dataclass(frozen=True, slots=True)
class Network:
    """What the prediction rests on.

    ``z_m`` (b,) are the heights of the bands above the feet of the scanners and ``counts`` (b, SECTORS, n) the points;
    ``pose_covariance`` is (6 n, 6 n) in the order of ``tasks.conventions``. ``noise_m`` is the noise of a point and
    ``form_m`` what the shaft is off a circle, over a band and a sector.
    """

    z_m: NDArray[np.float64]
    counts: NDArray[np.float64]
    pose_covariance: NDArray[np.float64]
    lean: NDArray[np.float64]
    noise_m: float
    form_m: float


def suggest_station(
    coverage: Coverage, model: ShaftModel, registration: Registration, sigmas: InstrumentSigmas
) -> NextStation | FitFailure:
    """Find the azimuth at which one more station lowers the uncertainty of the lean vector most.

    The new station is as far from the axis as the others in the median, sees the half of the shaft that faces it with
    their median number of points, and is set up with the stated sigmas; its heading is adjusted as well as theirs.
    What may stand in its way is not known, and neither is whether there is ground to stand on.

    Parameters
    ----------
    coverage : Coverage
        Points by band, sector and station, the stations in the order of the registration.
    model : ShaftModel
        Axis, radius and noise of the shaft.
    registration : Registration
        Poses and their covariance.
    sigmas : InstrumentSigmas
        What the maker states.
    """
    if not model.is_round:
        return FitFailure("needed a round shaft: the prediction is not made for plane faces")
    if not coverage.counts.any():
        return FitFailure("needed points on the shaft, there are none in its height range")
    network = network_of(coverage, model, registration)
    now = lean_covariance(network)
    if isinstance(now, FitFailure):
        return now
    distance_m = _median_distance_m(coverage, model, registration)
    radius_m = float(np.mean(model.radius_m))
    if distance_m <= radius_m:
        return FitFailure(
            f"needed stations outside the shaft, theirs is a median of {distance_m:.1f} m from the axis; a cloud that "
            "comes registered does not say where its scanners stood"
        )
    azimuths_deg = SECTOR_DEG * np.arange(SECTORS)
    new_pose = _new_pose_covariance(registration, sigmas)
    traces = [
        _trace(lean_covariance(with_station(network, azimuth, radius_m / distance_m, new_pose)))
        for azimuth in azimuths_deg
    ]
    best = int(np.argmin(traces))
    return NextStation(float(azimuths_deg[best]), _sigma_arcsec(_trace(now)), _sigma_arcsec(traces[best]))


def network_of(coverage: Coverage, model: ShaftModel, registration: Registration) -> Network:
    """Put together what the prediction needs, with the noise of the points and the form of the shaft as they were seen."""
    z_m = (coverage.z_edges_m[1:] + coverage.z_edges_m[:-1]) / 2.0
    foot_m = float(np.median([pose.position_m[2] for pose in registration.poses]))
    return Network(
        z_m=z_m - foot_m,
        counts=coverage.counts.astype(np.float64),
        pose_covariance=registration.covariance,
        lean=np.array([model.lean_east, model.lean_north]),
        noise_m=model.noise_sigma_m,
        form_m=form_sigma_m(coverage, model.noise_sigma_m),
    )


def form_sigma_m(coverage: Coverage, noise_m: float) -> float:
    """How much the shaft is off its round model over a band and a sector, beyond the noise of the points, metres.

    From the scatter of the cells' means, so that it holds what the poses leave between the stations, too: rather too
    large than too small.
    """
    points = coverage.points
    seen = points > 0
    if not seen.any():
        raise ShapeError("form_sigma_m needs a coverage with points; it has none")
    scatter_m = mad_sigma(coverage.off_sum_m[seen] / points[seen])
    noise_of_means_m2 = float(np.median(noise_m**2 / points[seen]))
    return float(np.sqrt(max(scatter_m**2 - noise_of_means_m2, 0.0)))


def lean_covariance(network: Network) -> NDArray[np.float64] | FitFailure:
    """Predict the covariance (2, 2) of the lean vector from points, form and poses.

    The share of a station in the lean is exact for rotations about a point at the scanners' height; that shifts of a
    station that sees some heights only do not cancel is left out.

    References
    ----------
    science.md, sections 3 and 4.
    """
    z, counts = network.z_m, network.counts
    direction = _sector_directions()
    points = counts.sum(axis=2)
    per_band = np.maximum(points.sum(axis=1), 1.0)
    # the free radius of a band takes the mean direction of its points out
    free = direction - ((points @ direction) / per_band[:, None])[:, None, :]
    by_station = np.einsum("bsk,bsi,sj->bkij", counts, free, direction)
    centre = by_station.sum(axis=1)
    all_bands = centre.sum(axis=0)
    if not _is_seen(all_bands):
        return FitFailure("the points cover too little of the circumference for a centre")
    weighted = np.einsum("b,bij->ij", z, centre)
    arm = z[:, None, None] * np.eye(2) - weighted @ np.linalg.inv(all_bands)
    information = np.einsum("b,bij,bjk->ik", z, arm, centre)
    if not _is_seen(information):
        return FitFailure("the points cover too few heights for a lean")
    cofactor = np.linalg.inv(information)
    shares = cofactor @ np.einsum("b,bij,bkjl->kil", z, arm, by_station)
    poses = propagate_directional_poses(network.pose_covariance, shares, network.lean)
    pull = cofactor @ np.einsum("bij,bsj->bsi", arm, free)[..., None]
    variance = points * network.noise_m**2 + points**2 * network.form_m**2
    return combine(np.einsum("bs,bsi,bsj->ij", variance, pull[..., 0], pull[..., 0]), poses)


def with_station(
    network: Network, azimuth_deg: float, sine_of_limb: float, pose_covariance: NDArray[np.float64]
) -> Network:
    """Add a station at an azimuth to the network.

    Parameters
    ----------
    network : Network
        The present stations.
    azimuth_deg : float
        Of the station as seen from the axis, clockwise from grid north.
    sine_of_limb : float
        Radius of the shaft by the distance: what is less than that towards the station cannot be seen.
    pose_covariance : (6, 6) array
        Of the new station, independent of the others.
    """
    azimuth = np.radians(azimuth_deg)
    towards = _sector_directions() @ [np.sin(azimuth), np.cos(azimuth)]
    # a square of the scanner's grid meets the less surface, the more that turns away
    facing = np.maximum(towards - sine_of_limb, 0.0)
    per_station = network.counts.sum(axis=(0, 1))
    n_points = float(np.median(per_station[per_station > 0]))
    bands = network.counts.sum(axis=(1, 2))
    added = n_points * np.outer(bands / bands.sum(), facing / facing.sum())
    n = len(network.pose_covariance)
    grown = np.zeros((n + PARAMETERS_PER_STATION,) * 2)
    grown[:n, :n] = network.pose_covariance
    grown[n:, n:] = pose_covariance
    counts = np.concatenate([network.counts, added[:, :, None]], axis=2)
    return Network(network.z_m, counts, grown, network.lean, network.noise_m, network.form_m)


def _sector_directions() -> NDArray[np.float64]:
    """East and north (SECTORS, 2) of the middles of the sectors."""
    middle = np.radians(SECTOR_DEG * (np.arange(SECTORS) + 0.5))
    return np.stack([np.sin(middle), np.cos(middle)], axis=1)


def _new_pose_covariance(registration: Registration, sigmas: InstrumentSigmas) -> NDArray[np.float64]:
    """Covariance (6, 6) of a station set up with the stated sigmas and adjusted with the others."""
    adjusted = float(np.median([diagnosis.sigma_heading_rad for diagnosis in registration.diagnoses]))
    horizontal_m, vertical_m = sigmas.position_m
    level, heading = sigmas.level_rad, min(adjusted, sigmas.heading_rad)
    return np.diag(np.square([level, level, heading, horizontal_m, horizontal_m, vertical_m]))


def _median_distance_m(coverage: Coverage, model: ShaftModel, registration: Registration) -> float:
    positions_m = np.array([pose.position_m for pose in registration.poses])
    off_m = positions_m[:, :2] - model.axis_at(positions_m[:, 2])
    seeing = coverage.counts.sum(axis=(0, 1)) > 0
    return float(np.median(np.hypot(*off_m[seeing].T)))


def _is_seen(information: NDArray[np.float64]) -> bool:
    small, large = np.linalg.eigvalsh((information + information.T) / 2.0)
    return bool(small > WEAKEST * large > 0.0)


def _trace(covariance: NDArray[np.float64] | FitFailure) -> float:
    # a station cannot take away what the others see, but what it adds may tell nothing
    return np.inf if isinstance(covariance, FitFailure) else float(np.trace(covariance))


def _sigma_arcsec(trace: float) -> float:
    return float(np.sqrt(trace / 2.0) / ARCSEC_RAD)
