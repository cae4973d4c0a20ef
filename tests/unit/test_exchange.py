from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.evaluation import ReferenceLean, Standard
from tasks.exchange import plain, rebuild
from tasks.limits import MissingLimit, table_named, table_of_points
from tasks.methods import Method
from tasks.preprocessing import StructurePrior
from tasks.registration import InstrumentSigmas, registered_cloud
from tasks.registration.station import Registration
from tasks.slicing import SCHEMES, SlicingScheme


@dataclass(frozen=True)
class Nested:
    values: NDArray[np.float64]
    pair: tuple[float, float]
    maybe: float | None
    inner: tuple[ReferenceLean, ...]


@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=SCHEMES)
def test_every_scheme_travels_unchanged(scheme: SlicingScheme) -> None:
    assert rebuild(SlicingScheme, plain(scheme)) == scheme


@pytest.mark.parametrize(
    "value",
    [
        Method("paper", "kasa", "irls", 0.01),
        StructurePrior("chimney", (2.0, 102.01), (0.1, -0.1), (4.6, 2.7)),
        InstrumentSigmas((0.015, 0.0225), 0.0026, 1.4e-5),
        Standard(
            102.0,
            table_of_points(((100.0, 0.06), (120.0, 0.065))),
            ("F", "paper"),
            (ReferenceLean("ts", 0.1, 0.2, 1e-5),),
            (table_named("aci117-general"), MissingLimit("own", "no version yet")),
        ),
        Standard(102.0, table_named("bre-digest-475"), ("total station",), ()),
        Standard(102.0, MissingLimit("own", "no version yet"), ("total station",), ()),
    ],
    ids=lambda value: type(value).__name__,
)
def test_parameters_travel_unchanged(value: object) -> None:
    assert rebuild(type(value), plain(value)) == value


def test_arrays_travel_to_the_last_bit() -> None:
    values = np.random.default_rng(1).normal(size=(3, 2)) / 3.0
    back = rebuild(Nested, plain(Nested(values, (0.1, 1 / 3), None, (ReferenceLean("x", 1e-9, -0.1, 5e-5),))))
    assert np.array_equal(back.values, values)
    assert back.pair == (0.1, 1 / 3)
    assert back.inner[0].lean_east == 1e-9


def test_a_registration_travels_with_its_covariance() -> None:
    registration = registered_cloud("a", InstrumentSigmas((0.015, 0.0225), 0.0026, 1.4e-5))
    back = rebuild(Registration, plain(registration))
    assert np.array_equal(back.covariance, registration.covariance)
    assert back.diagnoses == registration.diagnoses


def test_a_missing_field_is_refused() -> None:
    with pytest.raises(
        TypeError, match=r"Method needs \['axis', 'contour', 'name', 'thickness_m'\], got \['name'\]"
    ):
        rebuild(Method, {"name": "paper"})


@dataclass(frozen=True)
class Foreign:
    place: Path


def test_a_field_of_an_unknown_kind_is_refused_on_the_way_back() -> None:
    with pytest.raises(TypeError, match=r"Path.* does not travel between stages"):
        rebuild(Foreign, {"place": "here"})


def test_what_is_not_known_does_not_travel() -> None:
    with pytest.raises(TypeError, match=r"a .*Path does not travel between stages"):
        plain(Path())
