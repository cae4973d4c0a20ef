"""How well the foot of the axis is known: the base position at z = 0."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.lean import Lean
from tasks.methods import method_of
from tasks.placing import PlacedCloud
from tasks.registration import Registration
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.slicing import SCHEMES
from tasks.uncertainty import base_leverage, leverage
from tests.unit.mapped_shafts import Scene, cloud_of, placed
from tests.unit.networks import MODEL, SHAFT_Z_M

SCENE = Scene(points=5_000, sigma_m=0.015)
STEADY = replace(placed(SCENE), covariance=1e-16 * np.eye(48))
SHARED = np.kron(np.ones((8, 8)), np.diag([0.0, 0.0, 0.0, 4e-4, 4e-4, 0.0]))


def lean(cloud: PlacedCloud, scheme: str, method: str, registration: Registration = STEADY) -> Lean:
    shaft = IsolatedShaft(cloud, MODEL, registration, SHAFT_Z_M)
    found = lean_of_scheme(shaft, SCHEMES[scheme], method_of(SCHEMES[scheme], method))
    assert isinstance(found, Lean), found
    return found


def base_m(found: Lean) -> np.ndarray:
    return np.asarray(found.axis.point_m[:2] - found.lean * found.axis.point_m[2])


def test_levers_are_those_of_a_weighted_straight_line() -> None:
    z_m, weights = np.array([3.0, 8.0, 20.0, 55.0]), np.array([1.0, 0.2, 0.7, 0.4])
    terms = np.column_stack([np.ones(4), z_m])
    by_hand = np.linalg.solve((terms * weights[:, None]).T @ terms, (terms * weights[:, None]).T)
    assert base_leverage(z_m, weights) == pytest.approx(by_hand[0], rel=1e-12)
    assert leverage(z_m, weights) == pytest.approx(by_hand[1], rel=1e-12)


@pytest.mark.parametrize(("scheme", "method"), [("S", "surface"), ("B", "robust")])
def test_the_stated_sigma_of_the_base_is_its_scatter(scheme: str, method: str) -> None:
    found = [lean(cloud_of(SCENE, seed), scheme, method) for seed in range(10)]
    truth = np.array([MODEL.base_east_m, MODEL.base_north_m])
    scatter = np.sqrt(np.mean([np.square(base_m(one) - truth) for one in found]))
    stated = np.sqrt(np.mean([np.trace(one.base_covariance) / 2.0 for one in found]))
    # 20 components tell a scatter to 16 %
    assert scatter / stated == pytest.approx(1.0, abs=0.4)


@pytest.mark.parametrize(("scheme", "method"), [("S", "surface"), ("B", "robust")])
def test_a_shift_that_all_stations_share_shifts_the_base_and_leaves_the_lean(
    scheme: str, method: str
) -> None:
    cloud = cloud_of(SCENE)
    together = replace(STEADY, covariance=SHARED + STEADY.covariance)
    alone, shifted = lean(cloud, scheme, method), lean(cloud, scheme, method, together)
    more = np.trace(shifted.base_covariance) / 2.0 - np.trace(alone.base_covariance) / 2.0
    assert np.sqrt(more) == pytest.approx(0.020, rel=0.02)
    assert np.trace(shifted.propagated) == pytest.approx(np.trace(alone.propagated), rel=0.02)
