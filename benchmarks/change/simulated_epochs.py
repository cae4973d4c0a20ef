"""Epochs of a shaft on the level of slices: noise of points, level and position errors of stations, a wall that stays.

Every trial draws the points' residuals and the poses' errors anew, fits every slice as a linear circle, and hands centres
and stations' sums to the very code that a run uses (``tasks.lean``): axis, propagation, jackknife, joint parameters.
"""

from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit, failed_section
from tasks.change import SeenSurface
from tasks.change_basis import AxisRecord
from tasks.conventions import ARCSEC_RAD
from tasks.epoch_tables import Home, SchemeOutcome, slice_rows
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean, StationEvidence, lean_of_sections
from tasks.methods import Method, method_of
from tasks.preprocessing import ShaftModel
from tasks.slicing import SCHEMES
from tasks.tilt_rows import RowHome, tilt_row
from tasks.uncertainty import Skin, sum_by_station

HEIGHT_M = 102.0
WAY = ("A", "robust")
YEAR_S = 365.25 * 86400.0
FIRST_S = 1.7e9
WAVES = 12


@dataclass(frozen=True, slots=True)
class Survey:
    """How an epoch is measured.

    ``azimuths_deg`` are those of the stations at ``distance_m``; each has ``points`` points in every one of ``slices``
    slices, of ``noise_m``, and errors of level and position as stated. ``arc_deg`` is what a station sees.
    Slices above ``top_m`` give no centre; levels are drawn with ``drawn_level_arcsec`` where that is not what is stated.
    """

    azimuths_deg: tuple[float, ...]
    level_arcsec: float = 2.9
    position_m: float = 0.015
    heading_arcsec: float = 10.0
    noise_m: float = 0.01
    points: int = 24
    slices: int = 97
    distance_m: float = 250.0
    arc_deg: float = 150.0
    top_m: float = 100.0
    drawn_level_arcsec: float | None = None


@dataclass(frozen=True, slots=True)
class State:
    """Where the shaft is: lean vector, shift of the base, sagitta east and north, growth of the radius, metres."""

    lean: tuple[float, float] = (0.007, -0.0057)
    base_m: tuple[float, float] = (0.0, 0.0)
    bend_m: tuple[float, float] = (0.0, 0.0)
    wider_m: float = 0.0


class Site:
    """A survey's geometry, which is the same in every trial: points, stations, sums, and a wall of a given form."""

    def __init__(self, survey: Survey, wall_m: float = 0.0, seed: int = 1) -> None:
        self.survey = survey
        self.every_m = np.linspace(4.0, 100.0, survey.slices)
        self.z_m = self.every_m[self.every_m <= survey.top_m]
        self.radius_m = np.interp(self.z_m, [2.0, 102.0], [4.6, 2.7])
        azimuths = np.radians(survey.azimuths_deg)
        self.positions_m = np.column_stack(
            [
                survey.distance_m * np.sin(azimuths),
                survey.distance_m * np.cos(azimuths),
                np.full(len(azimuths), 1.6),
            ]
        )
        half = np.radians(survey.arc_deg) / 2.0
        around = np.linspace(-half, half, survey.points)
        self.azimuth = (azimuths[:, None] + around).ravel()
        self.station = np.repeat(np.arange(len(azimuths)), survey.points)
        self.outward = np.column_stack(
            [np.sin(self.azimuth), np.cos(self.azimuth), np.zeros(len(self.azimuth))]
        )
        self.sums = np.stack([self._sums_of(k) for k in range(len(self.z_m))])
        self.terms = np.column_stack([self.outward[:, :2], np.ones(len(self.azimuth))])
        self.solve = np.linalg.pinv(self.terms)
        variance = np.array([survey.level_arcsec, survey.level_arcsec, survey.heading_arcsec]) * ARCSEC_RAD
        one = np.concatenate([variance, np.full(3, survey.position_m)]) ** 2
        self.pose_covariance = np.kron(np.eye(len(azimuths)), np.diag(one))
        self.wall = _wall(wall_m, self.z_m, self.azimuth, seed)
        self.sections: tuple[SectionFit, ...] = ()

    def _points(self, k: int) -> NDArray[np.float64]:
        return np.column_stack(
            [self.radius_m[k] * self.outward[:, :2], np.full(len(self.azimuth), self.z_m[k])]
        )

    def _sums_of(self, k: int) -> NDArray[np.float64]:
        skin = Skin(self._points(k), self.outward, np.zeros(len(self.azimuth)), self.station)
        return sum_by_station(skin, len(self.positions_m))

    def seen(self) -> SeenSurface:
        """What the stations see of the wall, by pieces of 10 m and 10 degrees."""
        bands, sectors = np.arange(5.0, 102.0, 10.0), np.radians(np.arange(5.0, 360.0, 10.0))
        counts = np.bincount((np.degrees(self.azimuth) % 360.0 // 10.0).astype(int), minlength=36)
        present = (np.abs(bands[:, None] - self.z_m).min(axis=1) < 5.0).astype(float)
        z_m, azimuth = np.meshgrid(bands, sectors, indexing="ij")
        return SeenSurface(z_m.ravel(), azimuth.ravel(), np.outer(present, counts).ravel())

    def draw(self, rng: np.random.Generator, state: State) -> Lean:
        """Measure the shaft once."""
        errors = rng.normal(size=len(self.pose_covariance)) * np.sqrt(np.diag(self.pose_covariance))
        if self.survey.drawn_level_arcsec is not None:
            errors.reshape(-1, 6)[:, :2] *= self.survey.drawn_level_arcsec / self.survey.level_arcsec
        residual = (
            self._displaced(errors) + self.wall + self.survey.noise_m * rng.normal(size=self.wall.shape)
        )
        moved = residual @ self.solve.T
        left = residual - moved @ self.terms.T
        truth = _axis(state, self.z_m)
        sums = self.sums.copy()
        for station in range(len(self.positions_m)):
            own = self.station == station
            sums[:, station, :, 3] = left[:, own] @ self.terms[own]
        sections = [
            self._section(k, truth[k] + moved[k, :2], state.wider_m + moved[k, 2]) for k in range(len(truth))
        ]
        unseen = [
            failed_section(len(sections) + k, float(z), 0.2, 0, "no points")
            for k, z in enumerate(self.every_m[len(self.z_m) :])
        ]
        sections += unseen
        sums = np.concatenate([sums, np.zeros((len(unseen), *sums.shape[1:]))])
        evidence = StationEvidence(sums, self.positions_m, self.pose_covariance)
        found = lean_of_sections(sections, self.method, evidence, self.model)
        if isinstance(found, FitFailure):
            raise TypeError(found.reason)
        self.sections = tuple(sections)
        return found

    @property
    def method(self) -> Method:
        """The method that the slices are measured with."""
        return method_of(SCHEMES[WAY[0]], WAY[1])

    @property
    def model(self) -> ShaftModel:
        """The rough shaft."""
        return ShaftModel(0.0, 0.0, 0.007, -0.0057, (2.0, 102.0), (4.6, 2.7), (0.0,) * 2, (0.0,) * 2, 0.01)

    def _displaced(self, errors: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the pose errors move every point (slices, points) outward, metres."""
        pose = errors.reshape(-1, 6)[self.station]
        moved = np.empty((len(self.z_m), len(self.azimuth)))
        for k in range(len(self.z_m)):
            arm = self._points(k) - self.positions_m[self.station]
            moved[k] = np.sum((np.cross(pose[:, :3], arm) + pose[:, 3:]) * self.outward, axis=1)
        return moved

    def _section(self, index: int, centre: NDArray[np.float64], wider_m: float) -> SectionFit:
        variance = self.survey.noise_m**2 * np.linalg.inv(self.terms.T @ self.terms)[:2, :2]
        return SectionFit(
            slice_index=index,
            z_m=float(self.z_m[index]),
            thickness_m=0.2,
            n_points=len(self.azimuth),
            n_points_fit=len(self.azimuth),
            center_east_m=float(centre[0]),
            center_north_m=float(centre[1]),
            radius_m=float(self.radius_m[index] + wider_m),
            sigma_center_m=float(np.sqrt(np.trace(variance) / 2.0)),
            center_cov_ee=float(variance[0, 0]),
            center_cov_en=float(variance[0, 1]),
            center_cov_nn=float(variance[1, 1]),
            rmse_m=self.survey.noise_m,
            arc_coverage_deg=360.0,
            state="ok",
            reason=None,
        )


def axis_record(site: Site, lean: Lean, number: int = 0) -> AxisRecord:
    """What a workspace would hold of an axis that was just drawn, ``number`` years after the first."""
    when = datetime.fromtimestamp(FIRST_S + number * YEAR_S, UTC).isoformat()
    home = Home("shaft", f"e{number:02d}")
    row = tilt_row(RowHome("shaft", home.epoch, when, *WAY), lean, HEIGHT_M, None)
    outcome = SchemeOutcome(SCHEMES[WAY[0]], site.method, site.sections, lean, None)
    return AxisRecord(row, lean.parameters, slice_rows(home, outcome))


def _axis(state: State, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Axis (k, 2) at heights; the sagitta is that of a parabola over the shaft."""
    share = (z_m - 52.0) / 48.0
    parabola = (share**2 - 1.0 / 3.0)[:, None] * np.array(state.bend_m)
    return np.asarray(np.array(state.base_m) + z_m[:, None] * np.array(state.lean) + parabola)


def _wall(
    rms_m: float, z_m: NDArray[np.float64], azimuth: NDArray[np.float64], seed: int
) -> NDArray[np.float64]:
    """What the wall is off a round one at every point (slices, points): waves that stay from epoch to epoch."""
    if rms_m == 0.0:
        return np.zeros((len(z_m), len(azimuth)))
    rng = np.random.default_rng(seed)
    made = np.zeros((len(z_m), len(azimuth)))
    for _ in range(WAVES):
        around, up = rng.integers(2, 9), rng.uniform(0.02, 0.2)
        phase = rng.uniform(0.0, 2.0 * np.pi, 2)
        made += np.cos(around * azimuth + phase[0]) * np.cos(up * z_m + phase[1])[:, None]
    return np.asarray(made * rms_m / np.sqrt(np.mean(made**2)))
