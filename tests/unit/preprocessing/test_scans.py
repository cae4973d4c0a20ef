"""A shaft taken out of scans piece by piece is that of the whole cloud; of too many points an even sample stays."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tasks.geometry.failure import FitFailure
from tasks.preprocessing import (
    KEPT,
    REASONS,
    ScannedShaft,
    ShaftOptions,
    StructurePrior,
    isolate_scans,
    isolate_shaft,
)
from tests.unit.preprocessing.scenes import ARCSEC, CHIMNEY, LEAN, ladder_cloud, shaft_cloud, stray_cloud
from tests.unit.preprocessing.square_scenes import SQUARE, square_cloud

OPTIONS = ShaftOptions()
THINNED = REASONS.index("more than needed (an even sample stays)")


@dataclass(frozen=True)
class Pieces:
    """A scan in memory that is read in pieces."""

    points_m: np.ndarray

    def __len__(self) -> int:
        return len(self.points_m)

    def chunks(self, size: int) -> Iterator[np.ndarray]:
        return (self.points_m[start : start + size] for start in range(0, len(self), size))

    def sample(self, most: int) -> np.ndarray:
        return self.points_m[:: max(1, -(-len(self) // most))]


def three_scans(n: int = 20_000) -> list[Pieces]:
    rng = np.random.default_rng(1)
    clouds = [np.vstack([shaft_cloud(rng, n), ladder_cloud(rng), stray_cloud(rng, 3_000)]) for _ in range(3)]
    return [Pieces(cloud) for cloud in clouds]


def shaft_of(scans: list[Pieces], options: ShaftOptions = OPTIONS) -> ScannedShaft:
    shaft = isolate_scans(scans, CHIMNEY, options)
    assert not isinstance(shaft, FitFailure), shaft
    return shaft


def counts_of(shaft: ScannedShaft) -> list[int]:
    return [removal.n_points for removal in shaft.removed]


@pytest.mark.parametrize("kind", ["chimney", "square"])
def test_it_is_the_shaft_of_the_whole_cloud_from_the_bottom_up(kind: str) -> None:
    if kind == "chimney":
        scans, prior = three_scans(), CHIMNEY
    else:
        rng = np.random.default_rng(2)
        scans, prior = [Pieces(square_cloud(rng, 8_000)) for _ in range(2)], SQUARE
    cloud_m = np.vstack([scan.points_m for scan in scans])
    whole = isolate_shaft(cloud_m, prior, OPTIONS)
    shaft = isolate_scans(scans, prior, OPTIONS)
    assert not isinstance(whole, FitFailure)
    assert not isinstance(shaft, FitFailure)
    rising = whole.keep[np.argsort(cloud_m[whole.keep, 2], kind="stable")]
    scan_index = np.repeat(np.arange(len(scans)), [len(scan) for scan in scans])
    assert np.array_equal(shaft.points_m, cloud_m[rising])
    assert np.array_equal(shaft.scan_index, scan_index[rising])
    assert shaft.removed == whole.removed
    assert shaft.model == whole.model
    assert shaft.n_points_in == len(cloud_m)


def test_how_scans_are_cut_into_pieces_is_of_no_account(monkeypatch: pytest.MonkeyPatch) -> None:
    options = replace(OPTIONS, most_points=15_000)
    once = shaft_of(three_scans(), options)
    monkeypatch.setattr("tasks.preprocessing.scans.CHUNK_POINTS", 777)
    monkeypatch.setattr("tasks.preprocessing.scans.BLOCK_POINTS", 1_000)
    again = shaft_of(three_scans(), options)
    assert np.array_equal(once.points_m, again.points_m)
    assert np.array_equal(once.scan_index, again.scan_index)
    assert once.removed == again.removed


def test_of_too_many_points_an_even_sample_stays_and_all_are_accounted_for() -> None:
    scans = three_scans()
    plain, thin = shaft_of(scans), shaft_of(scans, replace(OPTIONS, most_points=16_000))
    on_surface = sum(counts_of(plain)[THINNED:])
    assert on_surface > 50_000
    # a quarter of each scan, and of each part of the height, within what chance gives
    assert len(thin.points_m) == pytest.approx(on_surface / 4, rel=0.02)
    shares = np.bincount(thin.scan_index) / np.bincount(plain.scan_index)
    assert shares == pytest.approx(np.full(3, 0.25), rel=0.02)
    by_height = [np.histogram(shaft.points_m[:, 2], 10, (2.0, 62.0))[0] for shaft in (plain, thin)]
    assert by_height[1] == pytest.approx(by_height[0] / 4, rel=0.15)
    assert sum(counts_of(thin)) == sum(len(scan) for scan in scans) == thin.n_points_in
    assert counts_of(thin)[THINNED] == on_surface - counts_of(thin)[KEPT] - sum(counts_of(thin)[5:KEPT])


def test_the_lean_of_an_even_sample_is_that_of_all_points_within_its_noise() -> None:
    thin = shaft_of(three_scans(), replace(OPTIONS, most_points=16_000)).model
    # 15,000 points of 8 mm over 60 m leave 1" of noise
    assert np.array([thin.lean_east, thin.lean_north]) * ARCSEC == pytest.approx(LEAN * ARCSEC, abs=4.0)


def test_a_search_in_a_sample_finds_the_same_shaft(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = shaft_of(three_scans())
    monkeypatch.setattr("tasks.preprocessing.scans.SEARCH_POINTS", 30_000)
    sampled = shaft_of(three_scans())
    assert sampled.model.lean_east == pytest.approx(plain.model.lean_east, abs=4.0 / ARCSEC)
    assert len(sampled.points_m) == pytest.approx(len(plain.points_m), rel=1e-3)


def test_a_small_structure_in_a_large_cloud_is_looked_for_among_the_points_near_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rng = np.random.default_rng(6)
    around = [rng.uniform(-400.0, 400.0, (150_000, 3)) for _ in range(3)]
    scans = [
        Pieces(np.vstack([scan.points_m, far])[rng.permutation(len(scan) + len(far))])
        for scan, far in zip(three_scans(4_000), around, strict=True)
    ]
    monkeypatch.setattr("tasks.preprocessing.scans.SEARCH_POINTS", 2_000)
    monkeypatch.setattr("tasks.preprocessing.scans.FEW_NEAR", 0)
    assert isinstance(isolate_scans(scans, CHIMNEY, OPTIONS), FitFailure)
    monkeypatch.setattr("tasks.preprocessing.scans.FEW_NEAR", 250)
    shaft = shaft_of(scans)
    whole = isolate_shaft(np.vstack([scan.points_m for scan in scans]), CHIMNEY, OPTIONS)
    assert not isinstance(whole, FitFailure)
    assert len(shaft.points_m) == pytest.approx(len(whole.keep), rel=0.01)


def test_a_failed_search_says_what_the_cloud_looks_like() -> None:
    feet = [Pieces(scan.points_m / 0.3048) for scan in three_scans()]
    failure = isolate_scans(feet, CHIMNEY, OPTIONS)
    assert isinstance(failure, FitFailure)
    assert "looks like feet" in failure.reason
    empty = isolate_scans([Pieces(np.empty((0, 3)))], CHIMNEY, OPTIONS)
    assert isinstance(empty, FitFailure)
    assert "empty" in empty.reason


def test_a_scan_without_a_point_of_the_shaft_has_no_part() -> None:
    rng = np.random.default_rng(5)
    far = Pieces(rng.uniform(50.0, 60.0, (4_000, 3)))
    shaft = shaft_of([far, *three_scans(), far])
    assert set(shaft.scan_index) == {1, 2, 3}


def test_prior_of_another_place_finds_nothing() -> None:
    away = StructurePrior("chimney", (2.0, 62.0), (500.0, 0.0), (3.0, 2.0))
    assert isinstance(isolate_scans(three_scans(), away, OPTIONS), FitFailure)
