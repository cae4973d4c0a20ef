"""The bytes that the browser gets are the points, to the last digit that 4 bytes hold."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from dashboard.content.cloud import (
    DEVIATION_UNIT_M,
    HEADER,
    MAGIC,
    UNKNOWN,
    StraightLine,
    cloud_bytes,
    deviation_m,
    mixed_rows,
)
from dashboard.content.scene import scene_of
from dashboard.content.surface import SkinGrid, SkinMap
from storage.views.shaft_points import ShaftPoints
from tests.storage.campaign import STRUCTURE, slice_row, station_row, tilt_row
from tests.storage.stored_points import wall

AXIS = StraightLine(np.array([0.01, -0.02]), np.array([0.007, -0.0057]))


def shaft(n: int = 5000, far_m: float = 0.0) -> ShaftPoints:
    points_m, index = wall(n)
    points_m[:, :2] += far_m
    return ShaftPoints(STRUCTURE, "e0", points_m, index, ("ST01", "ST02"))


def skin(values: NDArray[np.float64] | None = None) -> SkinMap:
    """A map from 2 to 102 m; by default a ramp over height and a wave around."""
    edges = np.linspace(2.0, 102.0, 41)
    azimuth = np.arange(5.0, 360.0, 10.0)
    grid = SkinGrid(edges[:-1], edges[1:], azimuth)
    if values is None:
        values = 1e-4 * grid.z_m[:, None] + 0.002 * np.cos(np.radians(azimuth))
    return SkinMap(grid, values, np.zeros_like(values), np.ones(values.shape, np.int64), np.full(40, 4.0))


def decoded(
    content: bytes,
) -> tuple[int, int, NDArray[np.float64], NDArray[np.float32], NDArray[np.int16], NDArray[np.uint8]]:
    magic, version, n, whole, *origin = HEADER.unpack_from(content)
    assert (magic, version) == (MAGIC, 1)
    assert len(content) == HEADER.size + 15 * n
    places = np.frombuffer(content, "<f4", 3 * n, HEADER.size).reshape(n, 3)
    deviation = np.frombuffer(content, "<i2", n, HEADER.size + 12 * n)
    station = np.frombuffer(content, np.uint8, n, HEADER.size + 14 * n)
    return n, whole, np.array(origin), places, deviation, station


@pytest.mark.parametrize("far_m", [0.0, 4.4e6])
def test_points_come_back_to_a_hundredth_of_a_millimetre(far_m: float) -> None:
    points = shaft(far_m=far_m)
    axis = StraightLine(AXIS.base_m + far_m, AXIS.lean)
    origin = np.append(axis.at(np.array(2.0)), 2.0)
    n, whole, stated, places, _deviation, station = decoded(cloud_bytes(points, 10**6, axis, origin, None))
    rows = mixed_rows(len(points), 10**6)
    assert (n, whole) == (5000, 5000)
    np.testing.assert_array_equal(stated, origin)
    np.testing.assert_allclose(places + origin, points.points_m[rows], rtol=0, atol=1e-5)
    np.testing.assert_array_equal(station, points.station_index[rows])


@pytest.mark.parametrize("most", [1, 7, 4999, 5000, 10**6])
def test_a_sample_is_even_and_as_large_as_asked(most: int) -> None:
    rows = np.sort(mixed_rows(5000, most))
    assert len(rows) == min(most, 5000)
    steps = np.diff(rows)
    assert len(steps) == 0 or steps.max() - steps.min() <= 1
    np.testing.assert_array_equal(mixed_rows(5000, most), mixed_rows(5000, most))


def test_a_first_part_of_the_points_is_spread_over_all_heights() -> None:
    first = shaft().points_m[mixed_rows(5000, 5000)[:500], 2]
    assert np.histogram(first, 5, (1.0, 102.0))[0].min() > 60


def test_without_a_map_no_deviation_is_known() -> None:
    deviation = decoded(cloud_bytes(shaft(), 100, AXIS, np.zeros(3), None))[4]
    assert (deviation == UNKNOWN).all()


def test_a_deviation_is_that_of_the_map_between_its_pieces() -> None:
    points = shaft()
    found = deviation_m(points.points_m, AXIS, skin())
    out = points.points_m[:, :2] - AXIS.at(points.points_m[:, 2])
    azimuth = np.arctan2(out[:, 0], out[:, 1])
    inside = points.points_m[:, 2] >= 2.0
    at = np.clip(points.points_m[:, 2], 3.25, 100.75)
    # what a wave bends within a sector
    np.testing.assert_allclose(found[inside], (1e-4 * at + 0.002 * np.cos(azimuth))[inside], atol=1e-5)
    assert np.isnan(found[~inside]).all()
    assert (~inside).any()


def test_at_the_middle_of_a_piece_a_deviation_is_that_of_the_piece() -> None:
    values = np.random.default_rng(2).normal(0.0, 0.003, (40, 36))
    whole = skin(values)
    z_m, azimuth = np.repeat(whole.grid.z_m, 36), np.radians(np.tile(whole.grid.azimuth_deg, 40))
    places = np.column_stack([AXIS.at(z_m) + 4.0 * np.column_stack([np.sin(azimuth), np.cos(azimuth)]), z_m])
    np.testing.assert_allclose(deviation_m(places, AXIS, whole), values.ravel(), atol=1e-12)


def test_pieces_without_points_have_no_part_and_no_deviation() -> None:
    values = np.full((40, 36), 0.005)
    values[10:12, 4:9] = np.nan
    whole = skin(values)
    points = shaft(20_000)
    found = deviation_m(points.points_m, AXIS, whole)
    assert np.allclose(found[np.isfinite(found)], 0.005)
    out = points.points_m[:, :2] - AXIS.at(points.points_m[:, 2])
    azimuth = np.degrees(np.arctan2(out[:, 0], out[:, 1])) % 360.0
    z_m = points.points_m[:, 2]
    unseen = (z_m >= 27.0) & (z_m < 32.0) & (azimuth >= 40.0) & (azimuth < 90.0) | (z_m < 2.0)
    np.testing.assert_array_equal(np.isnan(found), unseen)


def test_deviations_are_stored_in_tenths_of_a_millimetre_and_never_as_unknown() -> None:
    values = np.full((40, 36), -9.9)
    deviation = decoded(cloud_bytes(shaft(), 100, AXIS, np.zeros(3), skin(values)))[4]
    assert set(deviation.tolist()) <= {UNKNOWN, UNKNOWN + 1}
    values = np.full((40, 36), 0.00234)
    deviation = decoded(cloud_bytes(shaft(), 100, AXIS, np.zeros(3), skin(values)))[4]
    assert set(deviation[deviation != UNKNOWN].tolist()) == {round(0.0023 / DEVIATION_UNIT_M)}


def test_a_scene_stands_about_the_foot_of_the_axis() -> None:
    points, tilt = shaft(), tilt_row("e0")
    slices = [slice_row("e0", index) for index in range(5)]
    scene = scene_of(points, tilt, slices, [station_row("e0", "ST02"), station_row("e0", "ST09")])
    low = points.points_m[0, 2]
    np.testing.assert_allclose(scene.origin_m, [0.01 + 0.007 * low, -0.02 - 0.0057 * low, low])
    assert scene.top_m == points.points_m[-1, 2] - low
    assert [ring.up_m + low for ring in scene.rings] == pytest.approx([row.z_m for row in slices])
    assert [(pin.station, pin.place) for pin in scene.stations] == [("ST02", 1), ("ST09", None)]
    assert scene.stations[0].east_m == pytest.approx(231.4 - scene.origin_m[0])


def test_without_an_axis_a_scene_is_upright_in_the_middle_of_its_foot() -> None:
    scene = scene_of(shaft(20_000), None, [], [])
    assert not scene.has_axis
    assert (scene.axis.lean == 0.0).all()
    np.testing.assert_allclose(scene.origin_m[:2], [0.05, -0.05], atol=0.2)


def test_slices_of_flat_faces_and_without_a_centre_have_no_ring() -> None:
    slices = [
        replace(slice_row("e0", 0), contour="polygon"),
        replace(slice_row("e0", 1), center_east_m=None),
        slice_row("e0", 2),
    ]
    assert [ring.index for ring in scene_of(shaft(), tilt_row("e0"), slices, []).rings] == [2]
