"""What changed between two axes: lean, base, bending, radius profile and all centres, each tested by itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.records import SliceRow, TiltRow
from tasks.change import (
    FREE,
    SIGNIFICANT_P,
    SUM_OF_BOTH,
    AxisError,
    CentreChange,
    Centres,
    ParameterChange,
    chi_square_test,
    compare_centres,
    detectable_factor,
)
from tasks.change_basis import LEAST_ALIKE, AxisRecord, Basis, Kinship, basis_of
from tasks.geometry.axis_parameters import AXIS_NAMES

SAGITTA: Final = 1.5
"""Sagitta over the coefficient of the second Legendre polynomial."""

TOLD_NOISE: Final = 1.5

HEIGHTS: Final = np.linspace(-1.0, 1.0, 41)
"""Where the radius profile is looked at, from foot to top of the shaft."""


@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """One quantity that was tested; the fields are those of ``ChangeTestRow``."""

    quantity: str
    basis: str = FREE
    difference: NDArray[np.float64] | None = None
    covariance: NDArray[np.float64] | None = None
    size_m: float | None = None
    sigma_m: float | None = None
    smallest_detectable_m: float | None = None
    statistic: float | None = None
    freedom: int | None = None
    p_value: float | None = None
    significant: bool | None = None
    z_low_m: float | None = None
    z_high_m: float | None = None
    reason: str | None = None


def changed_quantities(before: AxisRecord, after: AxisRecord, kinship: Kinship) -> list[Quantity]:
    """Test every quantity that both axes have; the lean is always among them."""
    if before.parameters is None or after.parameters is None:
        return [_lean_of_rows(before.tilt, after.tilt)]
    basis = basis_of(before, after, kinship)
    if isinstance(basis, str):
        return [_untested(before.tilt, after.tilt, basis)]
    change, why = basis.change, "; ".join(basis.reasons) or None
    found = [_vector("lean", change, after.tilt.height_m, why), _base(basis)]
    if AXIS_NAMES[4] in change.names:
        found.append(_vector("bend", change, SAGITTA, None))
    radius = _radius(basis.free)
    return [*found, *([] if radius is None else [radius]), *_all_centres(before, after, basis, kinship)]


def _all_centres(before: AxisRecord, after: AxisRecord, basis: Basis, kinship: Kinship) -> list[Quantity]:
    """The test of all centres; none where they are of other sides of the wall, and nothing where they are too few."""
    if kinship.alike < LEAST_ALIKE:
        return [
            Quantity(
                "centres",
                reason="the epochs saw other sides of the wall, so their centres cannot be compared",
            )
        ]
    found = compare_centres(_centres(before.slices), _centres(after.slices), _axis_error(basis))
    return [] if found is None else [_congruency(found)]


def _untested(before: TiltRow, after: TiltRow, reason: str) -> Quantity:
    d = np.array([after.lean_east - before.lean_east, after.lean_north - before.lean_north])
    return Quantity("lean", difference=d, size_m=after.height_m * float(np.linalg.norm(d)), reason=reason)


def _base(basis: Basis) -> Quantity:
    """The shift of the straight axis at the foot of what was measured: at z = 0 it may be an extrapolation."""
    change, foot_m = basis.change, basis.ends_m[0]
    places = [change.names.index(name) for name in AXIS_NAMES[:4]]
    down = np.array([[1.0, 0.0, foot_m, 0.0], [0.0, 1.0, 0.0, foot_m]])
    covariance = down @ change.covariance[np.ix_(places, places)] @ down.T
    reason = f"at z = {foot_m:g} m"
    return _tested("base", down @ change.difference[places], covariance, 1.0, change.basis, reason)


def _lean_of_rows(before: TiltRow, after: TiltRow) -> Quantity:
    """The lean alone, its covariance the sum of both: nothing that is common to the epochs is known."""
    d = np.array([after.lean_east - before.lean_east, after.lean_north - before.lean_north])
    first, second = (_lean_covariance(row) for row in (before, after))
    if first is None or second is None:
        return _untested(before, after, "an uncertainty is unknown")
    return _tested("lean", d, first + second, after.height_m, SUM_OF_BOTH)


def _lean_covariance(row: TiltRow) -> NDArray[np.float64] | None:
    if row.lean_cov_ee is None or row.lean_cov_en is None or row.lean_cov_nn is None:
        return None
    return np.array([[row.lean_cov_ee, row.lean_cov_en], [row.lean_cov_en, row.lean_cov_nn]])


def _vector(prefix: str, change: ParameterChange, scale: float, reason: str | None) -> Quantity:
    d, covariance = change.of(f"{prefix}_")
    return _tested({"bend": "bending"}.get(prefix, prefix), d, covariance, scale, change.basis, reason)


def _tested(
    quantity: str,
    d: NDArray[np.float64],
    covariance: NDArray[np.float64],
    scale: float,
    basis: str = FREE,
    reason: str | None = None,
) -> Quantity:
    """Test a vector whose length times ``scale`` is in metres."""
    test = chi_square_test(d, covariance)
    if test is None:
        return Quantity(
            quantity,
            basis,
            d,
            covariance,
            size_m=scale * float(np.linalg.norm(d)),
            reason="the covariance of the change is singular",
        )
    return Quantity(
        quantity=quantity,
        basis=basis,
        difference=d,
        covariance=covariance,
        size_m=scale * test.size,
        sigma_m=scale * test.sigma,
        smallest_detectable_m=scale * test.smallest_detectable,
        statistic=test.statistic,
        freedom=test.freedom,
        p_value=test.p_value,
        significant=test.significant,
        reason=reason,
    )


def _radius(free: ParameterChange) -> Quantity | None:
    """The radius profile; its size is the largest change of the radius along the shaft."""
    d, covariance = free.of("radius_")
    test = None if not len(d) else chi_square_test(d, covariance)
    if test is None:
        return None
    terms = np.polynomial.legendre.legvander(HEIGHTS, len(d) - 1)
    along = terms @ d
    sigmas = np.sqrt(np.einsum("hk,kl,hl->h", terms, covariance, terms))
    place = int(np.argmax(np.abs(along)))
    return Quantity(
        quantity="radius",
        size_m=float(abs(along[place])),
        sigma_m=float(sigmas[place]),
        smallest_detectable_m=detectable_factor(test.freedom) * float(sigmas.max()),
        statistic=test.statistic,
        freedom=test.freedom,
        p_value=test.p_value,
        significant=test.significant,
    )


def _axis_error(basis: Basis) -> AxisError:
    """Covariance of the difference of the axes, bending and all, as far as both epochs state it."""
    places = [basis.free.names.index(name) for name in AXIS_NAMES if name in basis.free.names]
    return AxisError(basis.free.covariance[np.ix_(places, places)], basis.ends_m)


def _centres(slices: Sequence[SliceRow]) -> Centres:
    good = [
        (
            row.z_m,
            row.center_east_m,
            row.center_north_m,
            row.center_cov_ee,
            row.center_cov_en,
            row.center_cov_nn,
        )
        for row in slices
        if row.state == "ok"
    ]
    values = np.array([row for row in good if None not in row], dtype=np.float64).reshape(-1, 6)
    z_m, east, north, ee, en, nn = values.T
    return Centres(z_m, np.column_stack([east, north]), np.stack([ee, en, en, nn], axis=1).reshape(-1, 2, 2))


def _congruency(found: CentreChange) -> Quantity:
    return Quantity(
        quantity="centres",
        size_m=found.largest_m,
        statistic=found.statistic,
        freedom=found.freedom,
        p_value=found.p_value,
        significant=found.significant,
        z_low_m=found.z_low_m,
        z_high_m=found.z_high_m,
        reason=_where(found),
    )


def _where(found: CentreChange) -> str:
    """In words what the centres say; the noise is told where it is much more than stated."""
    noise = (
        "" if found.noise_factor < TOLD_NOISE else f"; they scatter {found.noise_factor:.1f} times as stated"
    )
    if found.place_p_value is not None:
        between = f"{found.z_low_m:.1f} m and {found.z_high_m:.1f} m"
        moved_mm = 1e3 * (found.moved_m or 0.0)
        return f"the shape changed: between {between} by {moved_mm:.1f} mm beside what is smooth{noise}"
    if found.shape_p_value is not None and found.shape_p_value < SIGNIFICANT_P:
        return f"they differ smoothly beyond shift and lean, more than they scatter; how much it bent: see bending{noise}"
    if found.significant:
        return f"the shaft moved as a whole, its shape did not change ({found.n} centres){noise}"
    return (
        f"{found.n} centres show no change of shape, and none beyond what levels and positions allow{noise}"
    )
