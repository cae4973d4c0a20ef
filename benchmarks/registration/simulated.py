"""Simulated epochs with their truth, kept as .npz files where a cache is asked for."""

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.monte_carlo import prior_of, sigmas_of
from benchmarks.registration.known import KnownEpoch, KnownStation
from tasks.code_version import code_version
from tasks.registration import StationPose, StationScan
from tasks.simulation import SimulatedCampaignRequest, SimulatedStation, Surface, draw_epochs, scan_epochs

EVERYTHING: Final = tuple(Surface)
NO_BACKGROUND: Final = (Surface.SHAFT, Surface.PLATFORM, Surface.LADDER, Surface.STRAY)


@dataclass(frozen=True, slots=True)
class _Stored:
    """One station as the cache holds it: ``surface`` (n,) codes, ``stated`` (4,) position and heading."""

    points_m: NDArray[np.float64]
    surface: NDArray[np.uint8]
    rotation: NDArray[np.float64]
    position_m: NDArray[np.float64]
    stated: NDArray[np.float64]


def simulated_epoch(
    request: SimulatedCampaignRequest, cache: Path | None = None, surfaces: Sequence[Surface] = EVERYTHING
) -> KnownEpoch:
    """The first epoch of a simulated campaign, with the points that lie on ``surfaces``."""
    (epoch,) = draw_epochs(request)
    stored = _simulate(request) if cache is None else _cached(request, cache)
    kept = np.array([int(surface) for surface in surfaces], dtype=np.uint8)
    stations = tuple(_known(f"ST{i + 1:02d}", station, kept) for i, station in enumerate(stored))
    truth = np.array([epoch.truth.lean.east, epoch.truth.lean.north])
    return KnownEpoch(f"seed {request.seed}", stations, truth, sigmas_of(request.scanner), prior_of(request))


def _known(name: str, stored: _Stored, kept: NDArray[np.uint8]) -> KnownStation:
    points_m = stored.points_m
    if len(kept) < len(EVERYTHING):
        points_m = points_m[np.isin(stored.surface, kept)]
    scan = StationScan(name, points_m, stored.stated[:3], float(stored.stated[3]))
    return KnownStation(scan, StationPose(name, stored.rotation, stored.position_m))


def _simulate(request: SimulatedCampaignRequest) -> Iterator[_Stored]:
    _, stations = next(iter(scan_epochs(request)))
    return map(_stored_of, stations)


def _stored_of(station: SimulatedStation) -> _Stored:
    setup = station.setup
    return _Stored(
        station.scan.points_m,
        station.scan.surface.astype(np.uint8),
        setup.rotation_site_scanner,
        setup.position_m,
        np.append(setup.stated_position_m, setup.stated_heading_rad),
    )


def _cached(request: SimulatedCampaignRequest, cache: Path) -> Iterator[_Stored]:
    """Read the stations one after the other; simulate and write them first where they are not there."""
    # a changed simulation or another request must not find old scans
    key = hashlib.sha256(f"{request!r}\n{code_version(scan_epochs)}".encode()).hexdigest()[:16]
    folder = cache / f"seed-{request.seed}-{request.stations}x{request.points}-{key}"
    if not folder.exists():
        partial = folder.with_suffix(".partial")
        partial.mkdir(parents=True, exist_ok=True)
        for i, station in enumerate(_simulate(request)):
            np.savez(
                partial / f"{i:02d}.npz",
                points_m=station.points_m,
                surface=station.surface,
                rotation=station.rotation,
                position_m=station.position_m,
                stated=station.stated,
            )
        partial.rename(folder)
    for file in sorted(folder.glob("*.npz")):
        with np.load(file) as held:
            yield _Stored(
                held["points_m"], held["surface"], held["rotation"], held["position_m"], held["stated"]
            )
