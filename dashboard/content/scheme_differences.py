"""How far each scheme is from another one along the lean, over the epochs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from statistics import median
from typing import Final

from dashboard.content.schemes import order_of
from storage.records import SchemeComparisonRow, TiltRow

WILD: Final = 20.0
"""So many times the usual standard deviation is not drawn."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A scheme and method minus another in an epoch, along the lean at the height H, metres.

    ``sigma_m`` has what both share taken out; None where that was not counted.
    """

    epoch: str
    time: datetime
    scheme: str
    method: str
    value_m: float
    sigma_m: float | None
    significant: bool | None

    @property
    def label(self) -> str:
        """Scheme and method as they are written everywhere."""
        return f"{self.scheme}/{self.method}"


def differences(
    tilts: Sequence[TiltRow], comparison: Sequence[SchemeComparisonRow], against: str
) -> dict[str, list[Difference]]:
    """Differences of every scheme and method, by label, the earliest epoch first.

    Parameters
    ----------
    against : str
        Label of the one that is taken away. Only for what the catalog compares with are the covariances known.
    """
    base = {row.epoch: row for row in tilts if f"{row.scheme}/{row.method}" == against}
    beside = {
        (row.epoch, row.scheme, row.method): row
        for row in comparison
        if row.against == against and row.scheme is not None
    }
    found: dict[str, list[Difference]] = {}
    for row in sorted(tilts, key=lambda row: (order_of((row.scheme, row.method)), row.epoch_time)):
        label = f"{row.scheme}/{row.method}"
        if row.epoch in base and label != against:
            compared = beside.get((row.epoch, row.scheme, row.method))
            found.setdefault(label, []).append(_difference(row, base[row.epoch], compared))
    return found


def drawable(
    found: Mapping[str, Sequence[Difference]],
) -> tuple[dict[str, Sequence[Difference]], dict[str, float]]:
    """Part off the schemes that are so much less certain than the others that their bars would hide these.

    Returns
    -------
    tuple
        Those to draw, and of those left out the smallest standard deviation [m].
    """
    least = {
        label: min(sigmas)
        for label, series in found.items()
        if (sigmas := [d.sigma_m for d in series if d.sigma_m is not None])
    }
    usual = median(least.values()) if least else 0.0
    wild = {label: sigma for label, sigma in least.items() if sigma > WILD * usual}
    return {label: series for label, series in found.items() if label not in wild}, wild


def _difference(row: TiltRow, base: TiltRow, compared: SchemeComparisonRow | None) -> Difference:
    lean = math.hypot(base.lean_east, base.lean_north)
    east, north = (base.lean_east / lean, base.lean_north / lean) if lean > 0.0 else (0.0, 1.0)
    along = (row.lean_east - base.lean_east) * east + (row.lean_north - base.lean_north) * north
    return Difference(
        row.epoch,
        row.epoch_time,
        row.scheme,
        row.method,
        along * row.height_m,
        _sigma_m(compared, east, north),
        None if compared is None else compared.significant,
    )


def _sigma_m(row: SchemeComparisonRow | None, east: float, north: float) -> float | None:
    if row is None or row.d_cov_ee is None or row.d_cov_en is None or row.d_cov_nn is None:
        return None
    variance = row.d_cov_ee * east**2 + 2.0 * row.d_cov_en * east * north + row.d_cov_nn * north**2
    return row.height_m * math.sqrt(max(variance, 0.0))
