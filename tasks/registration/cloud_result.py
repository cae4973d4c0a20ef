"""What the registration of one cloud onto another gives, and the rules by which it is believed."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from tasks.registration.cloud_directions import Observability
from tasks.registration.cloud_motion import RigidMotion

MIN_OVERLAP: Final = 0.3
"""Least share of either cloud that must match: the usual border between pairs that registration is expected to manage
and those of low overlap (Zeng et al. 2017, 3DMatch; Huang et al. 2021, Predator)."""

MIN_AGREEMENT: Final = 0.5
"""Least share that matches of what comes near the other surface."""

MAX_NOISES: Final = 4.0
"""Largest residuals where clouds touch, in units of their noise: chance alone makes about nine."""

MAX_WON_BACK: Final = 0.4
"""Largest part of the evidence for a placement that another one may make up for with evidence of its own.

Set between what was seen: 0.3 for pairs that are right, 0.7 and more where floor or symmetry fit elsewhere, 2 for a
wrong minimum."""

MAX_TWO_SIDED: Final = 1.0
"""Largest difference of A onto B and B onto A, in units of the residuals."""

State = Literal["ok", "not trustworthy"]


@dataclass(frozen=True, slots=True)
class Rival:
    """The best other placement: how far it puts the moving points (rms), and which part of the evidence it makes up."""

    T_fixed_moving: RigidMotion
    distance: float
    won_back: float


@dataclass(frozen=True, slots=True)
class PairRegistration:
    """A cloud placed on another; lengths in the unit of the clouds, angles in radians.

    ``covariance`` (6, 6) is of a rotation about ``centre``, the moving cloud's centroid in the fixed frame, followed by
    a shift, both along the fixed axes; it holds if the placement is the right one, which ``state`` judges. Unobservable
    directions are in it as uncertain as the cloud is large; all is infinite where nothing could be fitted.
    ``overlap_moving`` and ``overlap_fixed`` are the shares of each surface that match the other. ``rms`` is of the
    point-to-plane residuals of matches, ``sigma`` their robust scale (no less than a tenth of the noise),
    ``touching_sigma`` that of everything near the other surface, ``noise`` what the clouds' own roughness would
    make of it and ``spacing`` the larger of their distances between points. ``agreement`` is the share that matches of
    what comes near the other surface, ``two_sided`` the rms distance between the fits of A onto B and of B onto A.
    """

    T_fixed_moving: RigidMotion
    centre: NDArray[np.float64]
    covariance: NDArray[np.float64]
    overlap_moving: float
    overlap_fixed: float
    rms: float | None
    sigma: float | None
    touching_sigma: float | None
    noise: float
    spacing: float
    agreement: float
    two_sided: float | None
    observability: Observability | None
    rival: Rival | None
    state: State
    reasons: tuple[str, ...]
    n_iterations: int

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Rotation (3, 3) of ``T_fixed_moving``."""
        return self.T_fixed_moving.rotation

    @property
    def translation(self) -> NDArray[np.float64]:
        """Translation (3,) of ``T_fixed_moving``."""
        return self.T_fixed_moving.translation


def doubts(result: PairRegistration) -> tuple[str, ...]:
    """Reasons why a placement is not to be trusted, the figures of ``result`` being known; empty where there is none."""
    shares = (("moving", result.overlap_moving), ("fixed", result.overlap_fixed))
    found = [
        f"{100 * share:.0f} % of the {name} surface matches the other, needed {100 * MIN_OVERLAP:.0f} %"
        for name, share in shares
        if share < MIN_OVERLAP
    ]
    if result.agreement < MIN_AGREEMENT:
        found.append(
            f"{100 * result.agreement:.0f} % of what comes near the other surface lies on it, "
            f"needed {100 * MIN_AGREEMENT:.0f} %"
        )
    return (*found, *_doubts_of_residuals(result), *_doubts_of_uniqueness(result))


def _doubts_of_residuals(result: PairRegistration) -> list[str]:
    found = []
    if result.touching_sigma is not None and result.touching_sigma > MAX_NOISES * result.noise:
        found.append(
            f"residuals where the clouds touch are {result.touching_sigma / result.noise:.1f} times their noise, "
            f"allowed {MAX_NOISES:.0f}"
        )
    if result.sigma is None or result.two_sided is None:
        found.append("one of the clouds alone does not find its place on the other")
    elif result.two_sided > MAX_TWO_SIDED * result.sigma:
        found.append(
            f"moving onto fixed and fixed onto moving end {result.two_sided:.3g} apart, "
            f"residuals are {result.sigma:.3g}"
        )
    return found


def _doubts_of_uniqueness(result: PairRegistration) -> list[str]:
    found = []
    if result.observability is not None and result.observability.unobservable:
        found.append(f"not observable: {'; '.join(result.observability.unobservable)}")
    if result.rival is not None and result.rival.won_back > MAX_WON_BACK:
        found.append(
            f"another placement, {result.rival.distance:.3g} away, makes up for "
            f"{100 * result.rival.won_back:.0f} % of the evidence for this one, allowed {100 * MAX_WON_BACK:.0f} %"
        )
    return found
