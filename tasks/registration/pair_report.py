"""How every two stations of an adjusted epoch agree, and how well loops of three close."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations, permutations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.geometry.robust import mad_sigma
from tasks.registration.adjustment import Adjusted, Pair
from tasks.registration.pairs import MIN_MATCHES, pair_equations
from tasks.registration.station import PairDiagnosis, ShaftHint

HELD_SHARE: Final = 0.1
"""Of the weight of the statements: with none, a pair that shares only the shaft drifts where it sees nothing, and its loops
tell of that; with all, GNSS hides what they tell."""

BESIDE_SHAFT_M: Final = 2.0
"""Points that near to the rough shaft count as of the shaft: it leans, and its radius is a rough one."""


@dataclass(frozen=True, slots=True)
class _Closure:
    shift_m: float
    turn_rad: float


def diagnose_pairs(adjusted: Adjusted, hint: ShaftHint | None) -> tuple[PairDiagnosis, ...]:
    """One diagnosis an ordered pair of stations; without a hint nothing counts as shaft."""
    closures = _worst_closures(adjusted, hint)
    return tuple(
        _diagnose(pair, adjusted, hint, closures) for pair in permutations(range(len(adjusted.poses)), 2)
    )


def _diagnose(
    pair: Pair, adjusted: Adjusted, hint: ShaftHint | None, closures: Mapping[Pair, _Closure]
) -> PairDiagnosis:
    i, j = pair
    both = [adjusted.matches[i, j, layer] for layer in range(2)]
    residuals = np.concatenate([found.residuals_m for found in both])
    on_shaft = _on_shaft(np.concatenate([found.source.points_m for found in both]), hint)
    closure = closures.get((min(i, j), max(i, j)))
    return PairDiagnosis(
        station=adjusted.poses[i].station,
        other=adjusted.poses[j].station,
        overlap=len(residuals) / max(sum(found.n_queries for found in both), 1),
        n_matches=len(residuals),
        rmse_m=_scale(residuals),
        rmse_shaft_m=_scale(residuals[on_shaft]),
        rmse_background_m=_scale(residuals[~on_shaft]),
        closure_m=closure.shift_m if closure else None,
        closure_rad=closure.turn_rad if closure else None,
    )


def _scale(residuals_m: NDArray[np.float64]) -> float | None:
    return None if len(residuals_m) < MIN_MATCHES else mad_sigma(residuals_m)


def _on_shaft(points_m: NDArray[np.float64], hint: ShaftHint | None) -> NDArray[np.bool_]:
    if hint is None:
        return np.zeros(len(points_m), bool)
    away = np.hypot(*(points_m[:, :2] - np.asarray(hint.base_xy_m)).T)
    low, high = hint.shaft_z_m
    inside = (points_m[:, 2] >= low) & (points_m[:, 2] <= high)
    return np.asarray(inside & (away < max(hint.radius_m) + BESIDE_SHAFT_M))


def _worst_closures(adjusted: Adjusted, hint: ShaftHint | None) -> dict[Pair, _Closure]:
    """Worst loop of three through each unordered pair (i < j)."""
    at_m = np.zeros(3) if hint is None else np.array([*hint.base_xy_m, sum(hint.shaft_z_m) / 2.0])
    motions = {pair: _alone(pair, adjusted, at_m) for pair in combinations(range(len(adjusted.poses)), 2)}
    worst: dict[Pair, _Closure] = {}
    for i, j, k in combinations(range(len(adjusted.poses)), 3):
        first, second, third = motions[i, j], motions[j, k], motions[i, k]
        if first is None or second is None or third is None:
            continue
        loop = first + second - third
        closure = _Closure(float(np.linalg.norm(loop[3:])), float(np.linalg.norm(loop[:3])))
        for pair in ((i, j), (j, k), (i, k)):
            if pair not in worst or closure.shift_m > worst[pair].shift_m:
                worst[pair] = closure
    return worst


def _alone(pair: Pair, adjusted: Adjusted, at_m: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Motion (6,) of the first station against the second that the pair alone asks for: rotation, shift at a point.

    What the pair cannot see stays where the joint adjustment has it, by a tenth of the weight of the statements.
    """
    i, j = pair
    poses = adjusted.poses
    matrix, vector, n_matches = np.zeros((SIX, SIX)), np.zeros(SIX), 0
    for layer in range(2):
        there, back = adjusted.matches[i, j, layer], adjusted.matches[j, i, layer]
        forth = pair_equations(there, poses[i], poses[j])
        other = pair_equations(back, poses[j], poses[i])
        # of the way back the first station is the target
        matrix += forth.matrix[:SIX, :SIX] + other.matrix[SIX:, SIX:]
        vector += forth.vector[:SIX] + other.vector[SIX:]
        n_matches += len(there.residuals_m) + len(back.residuals_m)
    if n_matches < 2 * MIN_MATCHES:
        return None
    rows = slice(SIX * i, SIX * i + SIX)
    held = HELD_SHARE * adjusted.prior_information[rows, rows]
    motion = np.linalg.solve(matrix + held, vector)
    motion[3:] += np.cross(motion[:3], at_m - poses[i].position_m)
    return np.asarray(motion)
