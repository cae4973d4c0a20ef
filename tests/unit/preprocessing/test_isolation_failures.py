"""What cannot be isolated says why."""

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError, ShapeError
from tasks.geometry.failure import FitFailure
from tasks.preprocessing import KINDS, ShaftOptions, StructurePrior, isolate_shaft
from tests.unit.preprocessing.scenes import CHIMNEY, isolated, shaft_cloud, stray_cloud


def reason_of(cloud: NDArray[np.float64], prior: StructurePrior = CHIMNEY) -> str:
    answer = isolate_shaft(cloud, prior)
    assert isinstance(answer, FitFailure)
    return answer.reason


@pytest.fixture(scope="module")
def cloud() -> NDArray[np.float64]:
    return shaft_cloud(np.random.default_rng(1), 12_000)


def test_an_empty_cloud_is_called_empty() -> None:
    assert "cloud is empty" in reason_of(np.empty((0, 3)))


def test_a_cloud_below_the_shaft_is_told_its_heights(cloud: NDArray[np.float64]) -> None:
    assert "no points in the height range (2.0, 62.0) m" in reason_of(cloud - (0.0, 0.0, 100.0))


def test_a_wrong_position_is_told_where_was_searched(cloud: NDArray[np.float64]) -> None:
    assert "base_xy_m (40.0, 0.0)" in reason_of(
        cloud, StructurePrior("chimney", (2.0, 62.0), (40.0, 0.0), (3.0, 2.0))
    )


def test_a_short_piece_of_shaft_is_too_few_bands(cloud: NDArray[np.float64]) -> None:
    assert "height bands" in reason_of(cloud[cloud[:, 2] < 8.0])


@pytest.mark.parametrize(("unit", "in_m"), [("feet", 0.3048), ("millimetres", 0.001)])
def test_other_units_are_recognised(cloud: NDArray[np.float64], unit: str, in_m: float) -> None:
    assert f"looks like {unit}" in reason_of(cloud / in_m)


def test_stray_points_alone_are_no_shaft() -> None:
    assert "round" in reason_of(stray_cloud(np.random.default_rng(2), 20_000))


def test_a_wall_is_no_shaft() -> None:
    rng = np.random.default_rng(3)
    wall = np.column_stack(
        [rng.uniform(-6, 6, 20_000), rng.normal(2.5, 0.01, 20_000), rng.uniform(0, 66, 20_000)]
    )
    assert "round" in reason_of(wall)


def test_a_square_tower_taken_for_a_chimney_is_not_round() -> None:
    rng = np.random.default_rng(4)
    along, side = rng.uniform(-2.5, 2.5, 20_000), rng.integers(0, 4, 20_000)
    away = np.where(side < 2, 2.5, -2.5) + rng.normal(0.0, 0.01, 20_000)
    xy = np.where((side % 2 == 0)[:, None], np.column_stack([along, away]), np.column_stack([away, along]))
    assert "round or oval" in reason_of(np.column_stack([xy, rng.uniform(0.0, 66.0, 20_000)]))


def test_an_unknown_kind_is_answered_with_the_known_ones(cloud: NDArray[np.float64]) -> None:
    with pytest.raises(InputError, match="known: chimney"):
        isolate_shaft(cloud, StructurePrior("pagoda", (2.0, 62.0), (0.0, 0.0), (3.0, 2.0)))


@pytest.mark.parametrize("name", sorted(name for name, kind in KINDS.items() if not kind.n_faces))
def test_every_round_kind_isolates_a_shaft_at_its_place(cloud: NDArray[np.float64], name: str) -> None:
    assert len(isolated(cloud, StructurePrior(name, (2.0, 62.0), (0.1, 0.1), (3.0, 2.0))).keep) > 10_000


def test_points_that_are_not_triples_are_misuse() -> None:
    with pytest.raises(ShapeError, match=r"needs points \(n, 3\)"):
        isolate_shaft(np.zeros((5, 2)), CHIMNEY)


def test_a_prior_upside_down_is_misuse() -> None:
    with pytest.raises(ShapeError, match="lower height first"):
        StructurePrior("chimney", (60.0, 2.0), (0.0, 0.0), (3.0, 2.0))


def test_a_prior_without_radius_is_misuse() -> None:
    with pytest.raises(ShapeError, match="positive radii"):
        StructurePrior("chimney", (2.0, 60.0), (0.0, 0.0), (3.0, 0.0))


def test_a_voxel_of_nothing_is_misuse() -> None:
    with pytest.raises(ShapeError, match="positive voxel_m"):
        ShaftOptions(voxel_m=0.0)
