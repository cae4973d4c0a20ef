"""Do the poses scatter as their covariance says: parameter by parameter, and what a network shares apart."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD
from tasks.conventions import PARAMETERS_PER_STATION as SIX


@dataclass(frozen=True, slots=True)
class _Parameter:
    columns: tuple[int, ...]
    unit: str
    per_unit: float


PARAMETERS: Final[Mapping[str, _Parameter]] = {
    "level": _Parameter((0, 1), '"', ARCSEC_RAD),
    "heading": _Parameter((2,), '"', ARCSEC_RAD),
    "east, north": _Parameter((3, 4), "mm", 1e-3),
    "up": _Parameter((5,), "mm", 1e-3),
}


@dataclass(frozen=True, slots=True)
class Checked:
    """Errors (k,) of one parameter and their stated sigmas (k,), radians or metres.

    ``part`` says of what: "each" station, what is "common" to the network (its mean), "relative" to that mean.
    """

    parameter: str
    part: str
    errors: NDArray[np.float64]
    sigmas: NDArray[np.float64]


def check(errors: NDArray[np.float64], covariance: NDArray[np.float64]) -> Iterator[Checked]:
    """Split errors (n, 6) and their covariance (6 n, 6 n) of one epoch."""
    n = len(errors)
    mean = np.full((1, n), 1.0 / n)
    parts = {"each": np.eye(n), "common": mean, "relative": np.eye(n) - mean}
    for name, parameter in PARAMETERS.items():
        for part, take in parts.items():
            for column in parameter.columns:
                block = covariance[column::SIX, column::SIX]
                sigmas = np.sqrt(np.diag(take @ block @ take.T))
                yield Checked(name, part, take @ errors[:, column], sigmas)


def whole(errors: NDArray[np.float64], covariance: NDArray[np.float64]) -> float:
    """Mean square of all errors (n, 6) of an epoch in units of their joint covariance: 1 where it is true."""
    flat = errors.ravel()
    return float(flat @ np.linalg.solve(covariance, flat)) / len(flat)


def print_table(checked: Sequence[Checked], wholes: Sequence[float]) -> None:
    """One row a parameter and part; 1 is true, above it the sigma is too small."""
    rows: dict[tuple[str, str], list[Checked]] = defaultdict(list)
    for one in checked:
        rows[one.parameter, one.part].append(one)
    print("parameter    part       scatter rms  stated rms  rms of error/sigma      n")
    for (name, part), several in rows.items():
        errors = np.concatenate([one.errors for one in several])
        sigmas = np.concatenate([one.sigmas for one in several])
        unit, per_unit = PARAMETERS[name].unit, PARAMETERS[name].per_unit
        scatter, stated = (np.sqrt(np.mean(values**2)) / per_unit for values in (errors, sigmas))
        ratio = np.sqrt(np.mean((errors / sigmas) ** 2))
        print(
            f"{name:12s} {part:9s} {scatter:9.2f} {unit:2s} {stated:8.2f} {unit:2s} {ratio:15.2f} {len(errors):10d}"
        )
    print(
        f"all parameters of an epoch jointly: {np.sqrt(np.mean(wholes)):.2f} (1 where the covariance is true)"
    )
