"""Axis and radius as parameters with a joint covariance: from slices and from the whole surface."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.geometry.axis_parameters import AXIS_NAMES, AxisParameters
from tasks.lean import Lean
from tasks.methods import method_of
from tasks.placing import PlacedCloud
from tasks.registration import Registration
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.slicing import SCHEMES
from tests.unit.mapped_shafts import Scene, cloud_of, placed
from tests.unit.networks import MODEL, SHAFT_Z_M

WAYS = [("S", "surface"), ("B", "robust")]
SCENES = {"S": Scene(points=2_500, sigma_m=0.015), "B": Scene(points=12_000, sigma_m=0.015)}
STEADY = replace(placed(SCENES["S"]), covariance=1e-16 * np.eye(48))
FRAME = np.kron(np.ones((8, 8)), np.diag([1e-10, 1e-10, 0.0, 4e-4, 4e-4, 0.0]))


def lean(cloud: PlacedCloud, way: tuple[str, str], registration: Registration = STEADY) -> Lean:
    shaft = IsolatedShaft(cloud, MODEL, registration, SHAFT_Z_M)
    found = lean_of_scheme(shaft, SCHEMES[way[0]], method_of(SCHEMES[way[0]], way[1]))
    assert isinstance(found, Lean), found
    return found


def parameters(found: Lean) -> AxisParameters:
    assert found.parameters is not None
    return found.parameters


@pytest.mark.parametrize("way", WAYS)
def test_the_lean_among_the_parameters_is_the_one_that_is_stated(way: tuple[str, str]) -> None:
    found = lean(cloud_of(SCENES[way[0]], 1), way, placed(SCENES[way[0]]))
    told = parameters(found)
    places = told.places(("lean_east", "lean_north"))
    assert told.names[:4] == AXIS_NAMES[:4]
    assert told.values[places] == pytest.approx(found.lean, abs=1e-12)
    assert told.covariance[np.ix_(places, places)] == pytest.approx(found.covariance, rel=1e-6, abs=1e-18)
    base = found.axis.point_m[:2] - found.axis.point_m[2] * found.lean
    assert told.values[:2] == pytest.approx(base, abs=1e-9)


@pytest.mark.parametrize("way", WAYS)
def test_stated_sigmas_of_all_parameters_are_their_scatter(way: tuple[str, str]) -> None:
    found = [parameters(lean(cloud_of(SCENES[way[0]], seed), way)) for seed in range(10)]
    values = np.array([one.values for one in found])
    stated = np.sqrt(np.mean([np.diag(one.covariance) for one in found], axis=0))
    ratio = values.std(axis=0, ddof=1) / stated
    # 10 values tell a scatter to 24 %; of ten or so parameters the worst is further off
    assert np.sqrt(np.mean(ratio**2)) == pytest.approx(1.0, abs=0.25)
    assert ratio.min() > 0.4
    assert ratio.max() < 1.7


def test_radius_of_the_parameters_is_that_of_the_shaft() -> None:
    told = parameters(lean(cloud_of(SCENES["S"], 2), ("S", "surface")))
    radius = told.values[told.places(tuple(name for name in told.names if name.startswith("radius")))]
    z_m = np.linspace(10.0, 95.0, 9)
    share = (2.0 * z_m - sum(SHAFT_Z_M)) / (SHAFT_Z_M[1] - SHAFT_Z_M[0])
    found = np.polynomial.legendre.legval(share, radius)
    # the shaft's cone has a kink at 50 m, which a polynomial of the fourth order rounds off
    assert found == pytest.approx(MODEL.radius_at(z_m), abs=0.05)


@pytest.mark.parametrize("way", WAYS)
def test_frame_of_the_reference_epoch_is_told_apart(way: tuple[str, str]) -> None:
    tied = replace(
        placed(SCENES[way[0]]), covariance=placed(SCENES[way[0]]).covariance + FRAME, frame_covariance=FRAME
    )
    told = parameters(lean(cloud_of(SCENES[way[0]], 3), way, tied))
    # a level of 1e-5 rad and a shift of 20 mm that all stations share
    lean_places, base_places = (
        told.places(("lean_east", "lean_north")),
        told.places(("base_east", "base_north")),
    )
    assert np.sqrt(np.diag(told.frame_covariance)[lean_places]) == pytest.approx([1e-5, 1e-5], rel=0.05)
    assert np.sqrt(np.diag(told.frame_covariance)[base_places]) == pytest.approx([0.02, 0.02], rel=0.05)
    assert (np.diag(told.covariance) >= np.diag(told.frame_covariance)).all()
    assert not parameters(lean(cloud_of(SCENES[way[0]], 3), way)).frame_covariance.any()
