"""Where only a part of the points is looked at, it comes from the whole shaft, and sigma says how many they were."""

import numpy as np
import pytest

from tasks.geometry.failure import FitFailure
from tasks.level_check import _rows_evenly
from tasks.preprocessing import Shaft, isolate_shaft
from tasks.shaft_slices import ShaftCloud, slice_cloud
from tasks.surface.cells import SurfacePoints
from tasks.surface.fit import _sample
from tests.unit.preprocessing.square_scenes import SQUARE, SQUARE_LEAN, square_cloud
from tests.unit.test_faces_lean import STEADY, of_faces, seen_by_six
from tests.unit.test_shaft_slices import MODEL, ROBUST, SCHEME, SHAFT_M, uneven_cloud


def test_levels_are_checked_by_points_from_foot_to_top_of_every_station(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("tasks.level_check.MOST_POINTS", 100)
    station = np.random.default_rng(1).integers(0, 3, 3_000).astype(np.uint16)
    station[:20] = 3
    taken = _rows_evenly(station, 5)
    assert [len(rows) for rows in taken] == [100, 100, 100, 20, 0]
    for number, rows in enumerate(taken[:3]):
        own = np.flatnonzero(station == number)
        assert np.array_equal(rows, own[np.linspace(0, len(own) - 1, 100).astype(int)])
        assert np.isin(rows, own).all()


def test_a_surface_begins_with_points_from_foot_to_top(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tasks.surface.fit.SAMPLE", 500)
    points_m = np.column_stack([np.zeros((10_000, 2)), np.linspace(2.0, 102.0, 10_000)])
    sample = _sample(SurfacePoints(points_m, np.arange(10_000).astype(np.uint16) % 7, 7))
    counts = np.histogram(sample.points_m[:, 2], 10, (2.0, 102.0))[0]
    assert counts.tolist() == pytest.approx([50] * 10, abs=1)
    assert set(sample.station_index) == set(range(7))


def test_planes_of_a_sample_have_the_sigma_of_so_many_points(monkeypatch: pytest.MonkeyPatch) -> None:
    found = isolate_shaft(square_cloud(np.random.default_rng(30), 8_000), SQUARE)
    assert isinstance(found, Shaft)
    cloud = seen_by_six(31)
    order = np.argsort(cloud.points_m[:, 2])
    rising = type(cloud)(cloud.points_m[order], cloud.station_index[order])
    whole = of_faces(rising, found.model, STEADY)
    monkeypatch.setattr("tasks.faces_lean.MOST_POINTS", 4_000)
    quarter = of_faces(rising, found.model, STEADY)
    ratio = np.trace(quarter.point_covariance) / np.trace(whole.point_covariance)
    # a part of the shaft alone, its foot, would leave 64 times as much
    assert ratio == pytest.approx(4.0, rel=0.15)
    off = quarter.lean - SQUARE_LEAN
    assert float(off @ np.linalg.solve(quarter.covariance, off)) < 13.8


def test_slices_that_follow_the_points_see_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    points_m = uneven_cloud(1)
    cloud = ShaftCloud(points_m[np.argsort(points_m[:, 2])], MODEL)
    at_once = slice_cloud(cloud, SCHEME, ROBUST, SHAFT_M)
    monkeypatch.setattr("tasks.shaft_slices.CHUNK", 777)
    in_pieces = slice_cloud(cloud, SCHEME, ROBUST, SHAFT_M)
    assert len(at_once) > 5
    assert [(cut.z_m, cut.thickness_m) for cut in in_pieces] == [
        (cut.z_m, cut.thickness_m) for cut in at_once
    ]


def test_a_fit_of_no_points_says_so() -> None:
    assert isinstance(isolate_shaft(np.empty((0, 3)), SQUARE), FitFailure)
