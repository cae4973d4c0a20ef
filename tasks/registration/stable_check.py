"""Do the stable surroundings of the reference epoch hold this epoch: seen at all, and where GNSS puts them."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from tasks.registration.adjustment import STABLE
from tasks.registration.pairs import MIN_MATCHES
from tasks.registration.stable import StableSurroundings, pose_by_motion
from tasks.registration.statement_test import Settled, corrections

LEAST_MATCHES: Final = 10 * MIN_MATCHES
SUSPECT_CHI2: Final = 22.5
"""Chi-square of three degrees of freedom that chance reaches in one of 20,000 epochs."""


def stable_warnings(settled: Settled, stable: StableSurroundings) -> Iterator[str]:
    """Say if the surroundings are not seen, or if GNSS of the two epochs contradict each other as a whole."""
    n_matches = sum(
        len(found.residuals_m) for (_, other, _), found in settled.adjusted.matches.items() if other == STABLE
    )
    if n_matches < LEAST_MATCHES:
        yield (
            f"{n_matches} planes of the stable surroundings are seen again, needed {LEAST_MATCHES}: the epoch rests on GNSS "
            "alone; check [registration] stable and position_m"
        )
        return
    stated = settled.network.stated
    by_motion = np.concatenate([pose_by_motion(one.pose) for one in stated])
    information = np.concatenate([one.information for one in stated])
    normal = by_motion.T @ (by_motion * information[:, None])
    off = corrections(settled.adjusted, stated).ravel()
    motion = np.linalg.solve(normal, by_motion.T @ (information * off))
    spread = np.linalg.inv(normal)[3:, 3:] + stable.covariance[3:, 3:]
    shift = motion[3:]
    if float(shift @ np.linalg.solve(spread, shift)) > SUSPECT_CHI2:
        yield (
            f"GNSS puts the epoch {np.linalg.norm(shift):.2f} m away from the stable surroundings of the reference epoch; "
            "check position_m of both epochs, and whether the surroundings have moved"
        )
