"""A surface told band by band: the centre of each band beside the axis, its radius, how far it is out of round."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit, failed_section
from tasks.surface.bending import with_bending
from tasks.surface.cells import SECTORS, Cells
from tasks.surface.fit import CELLS_PER_INTERVAL, Adjusted
from tasks.surface.form import kept_in
from tasks.surface.profile import Profile

LOOSEST_RADII: Final = 0.25
"""A centre less certain than this part of the radius is no centre."""

LOOSEST_CONDITION: Final = 1e10

TURNS: Final = np.exp(2j * np.pi * np.arange(360) / 360)


def bands_of(adjusted: Adjusted, variant: str) -> tuple[SectionFit, ...]:
    """One row a band, bands without points too; ``variant`` is the name of the surface model.

    A band is as tall as an interval of the radius. Its centre is that of the surface plus what the band's own points are
    off it, less what the poses of their stations explain of that: the surface was fitted with the poses adjusted, and
    stations that see different heights would bend the bands where it is straight. Its covariance is from the points and
    what those of a block have in common.
    """
    bent = with_bending(adjusted)
    by_poses = bent.cells.residual_m - bent.normal.without_poses(bent.cells.residual_m)
    return tuple(_bands(replace(bent, cells=bent.cells.moved(by_poses)), variant))


def _bands(adjusted: Adjusted, variant: str) -> Iterator[SectionFit]:
    grid, cells = adjusted.grid, adjusted.cells
    thickness_m = grid.step_m * CELLS_PER_INTERVAL
    band = cells.height // CELLS_PER_INTERVAL
    for index in range(grid.n_heights // CELLS_PER_INTERVAL):
        rows = np.flatnonzero(band == index)
        middle_m = grid.low_m + (index + 0.5) * thickness_m
        yield _band(index, rows, adjusted, variant, (middle_m, thickness_m))


def _band(
    index: int,
    rows: NDArray[np.intp],
    adjusted: Adjusted,
    variant: str,
    place_m: tuple[float, float],
) -> SectionFit:
    cells, profile = adjusted.cells, adjusted.profile
    z_m, thickness_m = place_m
    n_points = int(cells.n_points[rows].sum())
    coverage = 360.0 / SECTORS * len(np.unique(cells.sector[rows]))
    radius_m = float(profile.radius_at(np.array([z_m]))[0])
    beside = _beside_surface(adjusted, rows, LOOSEST_RADII * radius_m)
    if beside is None:
        return failed_section(
            index, z_m, thickness_m, n_points, f"arc too short for a centre: {coverage:g} deg have points"
        )
    east, north, wider = beside.shift_m
    covariance = beside.covariance_m2
    axis = profile.axis_at(np.array([z_m]))[0] + profile.origin_m
    n_used = int(cells.n_used[rows].sum())
    shape = _out_of_round(_asked_for(adjusted), z_m)
    return SectionFit(
        slice_index=index,
        z_m=z_m,
        thickness_m=thickness_m,
        n_points=n_points,
        n_points_fit=n_used,
        center_east_m=float(axis[0] + east),
        center_north_m=float(axis[1] + north),
        radius_m=radius_m + float(wider),
        sigma_center_m=float(np.sqrt(np.trace(covariance[:2, :2]) / 2.0)),
        center_cov_ee=float(covariance[0, 0]),
        center_cov_en=float(covariance[0, 1]),
        center_cov_nn=float(covariance[1, 1]),
        rmse_m=float(np.sqrt(cells.square_m2[rows].sum() / n_used)),
        arc_coverage_deg=coverage,
        state="ok",
        reason=None,
        contour=variant,
        noise_m=_noise_m(cells, rows),
        roundness_m=shape.roundness_m,
        ovality_m=shape.ovality_m,
        ovality_azimuth_deg=shape.ovality_azimuth_deg,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Beside:
    """What a band is off the surface: east, north, wider (3,), metres, and the covariance (3, 3)."""

    shift_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64]


def _beside_surface(adjusted: Adjusted, rows: NDArray[np.intp], loosest_m: float) -> _Beside | None:
    """Fit a circle to the residuals of a band; None where they fix no centre."""
    weight, direction = adjusted.normal.weight[rows], adjusted.cells.direction[rows]
    terms = np.column_stack([direction.real, direction.imag, np.ones(len(rows))])
    matrix = (terms * weight[:, None]).T @ terms
    if len(rows) < 3 or np.linalg.cond(matrix) > LOOSEST_CONDITION:
        return None
    covariance = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    if float(np.sqrt(np.linalg.eigvalsh(covariance[:2, :2])[-1])) > loosest_m:
        return None
    shift = covariance @ (terms * weight[:, None]).T @ adjusted.cells.residual_m[rows]
    return _Beside(np.asarray(shift), covariance)


def _noise_m(cells: Cells, rows: NDArray[np.intp]) -> float:
    """Noise of the average point that counts, metres."""
    return float(np.sqrt(cells.n_used[rows].sum() * cells.mean_weight / cells.weight[rows].sum()))


@dataclass(frozen=True, slots=True)
class _OutOfRound:
    """Form of a section; None for a round one."""

    roundness_m: float | None = None
    ovality_m: float | None = None
    ovality_azimuth_deg: float | None = None


def _asked_for(adjusted: Adjusted) -> Profile:
    """The surface without the harmonics that the data do not ask for."""
    profile, choice = adjusted.profile, adjusted.choice
    if choice is None:
        return profile
    small = replace(choice.asked_for, axis_order=profile.form.axis_order)
    return Profile(small, profile.values_m[kept_in(small, profile.form)], profile.origin_m)


def _out_of_round(profile: Profile, z_m: float) -> _OutOfRound:
    if not profile.form.orders:
        return _OutOfRound()
    lobes = profile.harmonics_at(np.array([z_m]))[0]
    powers = np.array(profile.form.orders)
    outline = (lobes[None, :] * TURNS[:, None] ** powers).real.sum(axis=1)
    # a cos 2t + b sin 2t is largest at t = angle(a + i b) / 2, counterclockwise from east
    largest_deg = np.degrees(np.angle(np.conj(lobes[0]))) / 2.0
    return _OutOfRound(
        roundness_m=float(np.ptp(outline)),
        ovality_m=float(abs(lobes[0])),
        ovality_azimuth_deg=float((90.0 - largest_deg) % 180.0 % 180.0),
    )
