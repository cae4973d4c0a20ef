"""Two epochs of one wall, point by point: does what the wall does to both leans cancel as far as it is said to.

    .venv/bin/python -m benchmarks.change same_wall [--trials 100] [--campaigns rough,oval] [--ways S/surface,A/robust]

Stations stand where they stood (turned 0) or half-way between (turned 0.5); nothing moved.
"""

import argparse
from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.known_campaign import CAMPAIGNS, draw_epoch, wall_of
from benchmarks.accuracy.markdown import print_table
from benchmarks.accuracy.trials import rng_of, run_trials
from tasks.change import SeenSurface, chi_square_test, likeness, parameter_change
from tasks.conventions import ARCSEC_RAD
from tasks.coverage import count_coverage
from tasks.geometry.axis_parameters import AxisParameters
from tasks.geometry.failure import FitFailure
from tasks.methods import method_of
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.slicing import SCHEMES

SECTOR_RAD = np.radians(10.0)


def main(arguments: Sequence[str]) -> None:
    """Print one row for every wall, turn of the stations, scheme and method."""
    parser = argparse.ArgumentParser(prog="benchmarks.change same_wall", description=__doc__)
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--campaigns", default="rough,rough1,oval")
    parser.add_argument("--ways", default="S/surface,A/robust")
    asked = parser.parse_args(arguments)
    rows = []
    for name in asked.campaigns.split(","):
        for turned in (0.0, 0.5):
            trial = partial(_trial, name, turned, tuple(asked.ways.split(",")), asked.seed)
            found = run_trials(trial, asked.trials, asked.processes)
            rows += [
                [
                    CAMPAIGNS[name].title,
                    f"{turned:g}",
                    way,
                    *_cells([one[way] for one in found if way in one]),
                ]
                for way in asked.ways.split(",")
            ]
    head = [
        "walls",
        "stations turned by",
        "by",
        "alike",
        'rms of d (")',
        'stated (")',
        "without cancelling",
        "p < 5 %",
    ]
    print_table(head, rows)


Compared = tuple[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]
"""Likeness, difference (2,), its covariance, the sum of both covariances, p value."""


def _cells(found: Sequence[Compared]) -> list[str]:
    alike, d, covariance, plain, p_values = (np.array(column) for column in zip(*found, strict=True))
    rms = np.sqrt(np.mean(d**2)) / ARCSEC_RAD
    stated, without = (
        np.sqrt(np.trace(c, axis1=1, axis2=2).mean() / 2.0) / ARCSEC_RAD for c in (covariance, plain)
    )
    share = float(np.mean(p_values < 0.05))
    error = np.sqrt(share * (1.0 - share) / len(p_values))
    return [
        f"{alike.mean():.2f}",
        f"{rms:.2f}",
        f"{stated:.2f}",
        f"{without:.2f}",
        f"{share:.3f} ± {error:.3f}",
    ]


def _trial(name: str, turned: float, ways: Sequence[str], seed: int, number: int) -> dict[str, Compared]:
    campaign, rng = CAMPAIGNS[name], rng_of(seed, number)
    wall = wall_of(campaign, rng)
    first = float(rng.random())
    epochs = [draw_epoch(campaign, wall, first + turn, rng) for turn in (0.0, turned)]
    alike = likeness(*(_seen(epoch) for epoch in epochs))
    told = {}
    for way in ways:
        found = [_parameters(epoch, way) for epoch in epochs]
        if found[0] is not None and found[1] is not None:
            told[way] = _compared(found[0], found[1], alike)
    return told


def _compared(before: AxisParameters, after: AxisParameters, alike: float) -> Compared:
    d, covariance = parameter_change(before, after, alike, "before").of("lean_")
    _, plain = parameter_change(before, after, 0.0, "before").of("lean_")
    test = chi_square_test(d, covariance)
    return alike, d, covariance, plain, 1.0 if test is None else test.p_value


def _parameters(epoch: IsolatedShaft, way: str) -> AxisParameters | None:
    scheme, method = way.split("/")
    lean = lean_of_scheme(epoch, SCHEMES[scheme], method_of(SCHEMES[scheme], method))
    return None if isinstance(lean, FitFailure) else lean.parameters


def _seen(epoch: IsolatedShaft) -> SeenSurface:
    n_stations = len(epoch.registration.poses)
    coverage = count_coverage(
        epoch.cloud.points_m, epoch.cloud.station_index, epoch.model, epoch.shaft_z_m, n_stations
    )
    middle = (coverage.z_edges_m[:-1] + coverage.z_edges_m[1:]) / 2.0
    z_m, azimuth = np.meshgrid(middle, (np.arange(36) + 0.5) * SECTOR_RAD, indexing="ij")
    return SeenSurface(z_m.ravel(), azimuth.ravel(), coverage.points.ravel().astype(np.float64))
