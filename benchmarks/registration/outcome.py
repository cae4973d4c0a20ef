"""One method on one epoch: what became of it."""

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from benchmarks.registration.judging import PoseErrors, lean_of, pose_errors, replaced, shaft_after
from benchmarks.registration.known import KnownEpoch
from benchmarks.registration.methods import METHODS, place_truly
from storage.errors import TiltwatchError
from tasks.conventions import ARCSEC_RAD
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.registration import Registration


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a method made of an epoch; ``seconds`` are of the registration alone.

    ``failure`` says why there is no registration or no shaft. ``error`` (2,) is found minus true lean.
    """

    epoch: str
    stations: int
    method: str
    seconds: float
    registration: Registration | None = None
    poses: PoseErrors | None = None
    lean: Lean | None = None
    error: NDArray[np.float64] | None = None
    failure: str | None = None

    @property
    def chi2(self) -> float | None:
        """Found minus true under the stated covariance: 2 on average."""
        if self.lean is None or self.error is None:
            return None
        return float(self.error @ np.linalg.solve(self.lean.covariance, self.error))

    @property
    def sigma_arcsec(self) -> float | None:
        """Stated standard deviation of one component of the lean vector."""
        if self.lean is None:
            return None
        return float(np.sqrt(np.trace(self.lean.covariance) / 2.0)) / ARCSEC_RAD

    @property
    def notes(self) -> tuple[str, ...]:
        """What the registration says of stations that are not in order."""
        if self.registration is None:
            return ()
        suspects = (f"{d.station} {d.state}: {d.reason}" for d in self.registration.diagnoses if d.reason)
        refused = (f"{station.station} refused: {station.reason}" for station in self.registration.refused)
        return (*suspects, *refused)


def evaluate(epoch: KnownEpoch, method: str) -> Outcome:
    """Register by the method, measure the lean, and compare both with the truth."""
    started = perf_counter()
    try:
        registration = METHODS[method](epoch)
    except TiltwatchError as error:
        # a refusal of the whole epoch is an answer too
        registration = FitFailure(str(error))
    seconds = perf_counter() - started
    about = (epoch.label, len(epoch.stations), method, seconds)
    if isinstance(registration, FitFailure):
        return Outcome(*about, failure=registration.reason)
    poses = pose_errors(epoch, registration)
    shaft = shaft_after(epoch, registration)
    lean = shaft if isinstance(shaft, FitFailure) else lean_of(epoch, registration, shaft)
    if isinstance(lean, FitFailure):
        return Outcome(*about, registration, poses, failure=lean.reason)
    return Outcome(*about, registration, poses, lean, lean.lean - epoch.true_lean)


def with_true_shaft(epoch: KnownEpoch, outcome: Outcome) -> Outcome:
    """Where the shaft could not be isolated, measure the points that true poses isolate; the failure stays on record."""
    placed = outcome.registration
    if placed is None or outcome.lean is not None or len(placed.poses) < len(epoch.stations):
        return outcome
    true = place_truly(epoch)
    shaft = shaft_after(epoch, true)
    if isinstance(shaft, FitFailure):
        return outcome
    lean = lean_of(epoch, placed, replaced(shaft, true, placed))
    if isinstance(lean, FitFailure):
        return outcome
    return replace(outcome, lean=lean, error=lean.lean - epoch.true_lean)


def moved(outcome: Outcome, floor: Outcome) -> NDArray[np.float64] | None:
    """Lean (2,) of one less that of the other, on the same epoch."""
    if outcome.lean is None or floor.lean is None:
        return None
    return np.asarray(outcome.lean.lean - floor.lean.lean)
