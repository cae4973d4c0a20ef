from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.map_cells import CellMeans, map_grid, robust_means
from tasks.map_shapes import DesignedShape
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftFace, ShaftModel
from tasks.surface_map import MapQuestion, map_surface
from tests.unit.mapped_shafts import (
    Asked,
    Scene,
    axis_of,
    bulge,
    cloud_of,
    column,
    map_of,
    placed,
    surface_axis,
)
from tests.unit.networks import MODEL, SHAFT_Z_M

BULGED = Scene(wall=bulge)
EXACT = Scene(points=40_000, sigma_m=0.0)
DESIGN = DesignedShape(MODEL.radius_z_m, MODEL.radius_m, (0.0, 0.0), None)


def means_of(values: NDArray[np.float64], cell: NDArray[np.intp], n_cells: int) -> CellMeans:
    """Robust means of values (n,) in pieces (n,)."""
    counts = np.bincount(cell, minlength=n_cells)
    return robust_means(lambda rows: values[rows], cell.astype(np.uint16), counts)


def test_a_bulge_is_where_it_is_and_as_high_as_it_is() -> None:
    cloud = cloud_of(BULGED)
    found = column(map_of(cloud, BULGED, axis=surface_axis(cloud, BULGED)), "deviation_m")
    inside = np.zeros(found.shape, bool)
    inside[16:18, 10:13] = True
    # 28 points of 5 mm a piece: 1 mm, and 6 pieces
    assert found[inside].mean() == pytest.approx(0.020, abs=0.0015)
    assert found[inside].min() > 0.015
    assert np.abs(found[~inside]).max() < 0.006


def test_the_stated_sigma_of_a_piece_is_its_scatter() -> None:
    scene = Scene(points=150_000)
    cells = map_of(cloud_of(scene), scene)
    ratio = column(cells, "deviation_m") / column(cells, "deviation_sigma_m")
    # 1440 pieces tell a standard deviation to 2 %; about 100 points a piece tell theirs to 8 %
    assert np.std(ratio) == pytest.approx(1.0, abs=0.07)
    assert np.median(column(cells, "deviation_sigma_m")) == pytest.approx(5e-4, rel=0.05)


def test_strays_do_not_move_a_piece() -> None:
    def with_strays(z_m: NDArray[np.float64], azimuth_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(np.arange(len(z_m)) % 20 == 0, 0.3, 0.0) + 0.0 * azimuth_deg

    scene = Scene(wall=with_strays)
    found = column(map_of(cloud_of(scene), scene), "deviation_m")
    # means would be 15 mm off
    assert np.abs(found).max() < 0.006


def test_the_map_moves_along_with_a_shaft_that_moves_as_a_whole() -> None:
    scene = Scene(wall=bulge, points=20_000)
    cloud = cloud_of(scene)
    moved = PlacedCloud(cloud.points_m + np.array([0.4, -0.7, 0.0]), cloud.station_index)
    model = replace(MODEL, base_east_m=MODEL.base_east_m + 0.4, base_north_m=MODEL.base_north_m - 0.7)
    here = column(map_of(cloud, scene), "deviation_m")
    there = column(map_of(moved, scene, Asked(model=model)), "deviation_m")
    assert there == pytest.approx(here, abs=1e-12, nan_ok=True)


def test_turning_the_shaft_by_a_sector_turns_the_map_by_a_sector() -> None:
    scene = Scene(wall=bulge, points=20_000)
    cloud = cloud_of(scene)
    turn = np.radians(10.0)
    clockwise = np.array(
        [[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    east, north = clockwise[:2, :2].T @ [MODEL.base_east_m, MODEL.base_north_m]
    lean_east, lean_north = clockwise[:2, :2].T @ [MODEL.lean_east, MODEL.lean_north]
    model = replace(MODEL, base_east_m=east, base_north_m=north, lean_east=lean_east, lean_north=lean_north)
    turned = PlacedCloud(cloud.points_m @ clockwise, cloud.station_index)
    here = column(map_of(cloud, scene), "deviation_m")
    there = column(map_of(turned, scene, Asked(model=model)), "deviation_m")
    # a point on the very edge of two sectors may go either way
    assert np.mean(np.abs(there - np.roll(here, 1, axis=1)) < 1e-9) > 0.999


def test_what_nobody_saw_has_no_deviation_but_a_row_and_a_radius() -> None:
    scene = Scene(azimuths_deg=(0.0,), half_view_deg=60.0)
    cells = map_of(cloud_of(scene), scene, Asked(design=DESIGN))
    unseen = [cell for cell in cells if 60.0 < cell.azimuth_deg < 300.0]
    assert len(cells) == 40 * 36
    assert len(unseen) == 40 * 24
    assert {(c.n_points, c.deviation_m, c.deviation_sigma_m, c.placing_sigma_m) for c in unseen} == {
        (0, None, None, None)
    }
    assert {(c.design_deviation_m, c.design_sigma_m) for c in unseen} == {(None, None)}
    assert [c.radius_m for c in unseen] == pytest.approx(MODEL.radius_at([c.z_m for c in unseen]), abs=0.002)


def test_a_band_without_points_has_the_radius_between_its_neighbours() -> None:
    cloud = cloud_of(EXACT)
    away = (cloud.points_m[:, 2] > 42.0) & (cloud.points_m[:, 2] < 47.0)
    cells = map_of(PlacedCloud(cloud.points_m[~away], cloud.station_index[~away]), EXACT)
    empty = [cell for cell in cells if cell.z_low_m == 42.0]
    assert {cell.n_points for cell in empty} == {0}
    assert empty[0].radius_m == pytest.approx(float(MODEL.radius_at(43.25)), abs=1e-6)


def test_a_leaning_shaft_is_off_a_plumb_design_by_its_lean() -> None:
    cells = map_of(cloud_of(EXACT), EXACT, Asked(design=DESIGN))
    for cell in cells:
        azimuth, rise = np.radians(cell.azimuth_deg), cell.z_m - SHAFT_Z_M[0]
        radius_m = float(MODEL.radius_at(cell.z_m))
        east = radius_m * np.sin(azimuth) + rise * MODEL.lean_east
        north = radius_m * np.cos(azimuth) + rise * MODEL.lean_north
        # up to 0.9 m; the middle of the points is not that of the piece
        assert cell.design_deviation_m == pytest.approx(
            np.hypot(east, north) - radius_m, abs=2e-3 + 4e-4 * rise
        )
        assert cell.deviation_m == pytest.approx(0.0, abs=1e-9)


def test_a_shaft_as_designed_is_not_off_its_design() -> None:
    base = (MODEL.base_east_m, MODEL.base_north_m)
    asked = Asked(
        design=replace(
            DESIGN, lean=(MODEL.lean_east, MODEL.lean_north), base_xy_m=base, radius_m=(4.59, 3.59, 2.69)
        )
    )
    found = column(map_of(cloud_of(EXACT), EXACT, asked), "design_deviation_m")
    assert found == pytest.approx(0.010, abs=1e-9)


def test_a_design_that_stands_elsewhere_shows_the_shift() -> None:
    base = (MODEL.base_east_m - 0.050, MODEL.base_north_m)
    lean = (MODEL.lean_east, MODEL.lean_north)
    found = map_of(cloud_of(EXACT), EXACT, Asked(design=replace(DESIGN, lean=lean, base_xy_m=base)))
    for cell in found:
        assert cell.design_deviation_m == pytest.approx(
            0.050 * np.sin(np.radians(cell.azimuth_deg)), abs=0.005
        )


def test_a_pose_error_that_all_stations_share_moves_the_design_and_not_the_map() -> None:
    scene = Scene(points=20_000)
    known = placed(scene)
    together = np.kron(np.ones((8, 8)), np.diag([0.0, 0.0, 0.0, 1e-4, 1e-4, 0.0]))
    base = (MODEL.base_east_m, MODEL.base_north_m)
    design = replace(DESIGN, base_xy_m=base)
    question = MapQuestion(SHAFT_Z_M, "horizontal", design)
    cells = map_surface(cloud_of(scene), MODEL, axis_of(MODEL), replace(known, covariance=together), question)
    assert isinstance(cells, tuple)
    assert np.nanmax(column(cells, "placing_sigma_m")) < 1e-9
    points = column(cells, "deviation_sigma_m")
    placing = np.sqrt(column(cells, "design_sigma_m") ** 2 - points**2)
    assert placing == pytest.approx(0.010, rel=1e-6)


def test_the_stated_placing_sigma_is_the_scatter_over_pose_errors() -> None:
    """Shift the points of every station by a draw of its position error, and map them around the axis that follows."""
    scene = Scene(points=16_000, azimuths_deg=(0.0, 90.0, 180.0, 270.0))
    cloud = cloud_of(scene)
    rng = np.random.default_rng(5)
    covariance = np.kron(np.eye(4), np.diag([0.0, 0.0, 0.0, 1e-4, 1e-4, 0.0]))
    known = replace(placed(scene), covariance=covariance)
    found = []
    for _ in range(4):
        points = cloud.points_m.copy()
        points[:, :2] += 0.010 * rng.normal(size=(4, 2))[cloud.station_index]
        moved = PlacedCloud(points, cloud.station_index)
        question = MapQuestion(SHAFT_Z_M, "horizontal", None)
        cells = map_surface(moved, MODEL, surface_axis(moved, scene), known, question)
        assert isinstance(cells, tuple)
        found.append(column(cells, "deviation_m"))
    placing_m, noise_m = column(cells, "placing_sigma_m"), column(cells, "deviation_sigma_m")
    ratio = np.sqrt(np.nanmean(np.square(found)) / np.nanmean(placing_m**2 + noise_m**2))
    # eight errors a draw less the two that the axis takes along: 24 independent ones tell a scatter to 14 %
    assert ratio == pytest.approx(1.0, abs=0.35)
    assert np.nanmean(placing_m) > 1.5 * np.nanmean(noise_m)


def test_sections_round_across_a_strong_lean_are_not_oval() -> None:
    model = ShaftModel(0.0, 0.0, 0.10, 0.0, (2.0, 102.0), (4.0, 4.0), (0.0, 0.0), (0.0, 0.0), 0.01)
    z, turn = (g.ravel() for g in np.meshgrid(np.linspace(2.0, 102.0, 400), np.linspace(0.0, 2 * np.pi, 180)))
    direction = np.array([0.10, 0.0, 1.0]) / np.hypot(0.10, 1.0)
    first, second = np.array([direction[2], 0.0, -direction[0]]), np.array([0.0, 1.0, 0.0])
    points = np.outer(z / direction[2], direction)
    points = points + 4.0 * (np.outer(np.cos(turn), first) + np.outer(np.sin(turn), second))
    cloud = PlacedCloud(points, np.zeros(len(points), dtype=np.uint16))
    scene = Scene(azimuths_deg=(0.0,))
    across = column(map_of(cloud, scene, Asked(model=model, sections="perpendicular")), "deviation_m")
    horizontal = column(map_of(cloud, scene, Asked(model=model)), "deviation_m")
    assert np.nanmax(np.abs(across)) < 1e-9
    # a (1 / cos 5.71 deg - 1) = 20 mm, about its median
    assert np.nanmax(horizontal) - np.nanmin(horizontal) == pytest.approx(0.020, abs=0.001)


def test_a_square_tower_is_measured_from_its_faces() -> None:
    faces = tuple(ShaftFace(np.radians(a), (4.0, 4.0), None) for a in (0.0, 90.0, 180.0, 270.0))
    model = ShaftModel(0.0, 0.0, 0.0, 0.0, (2.0, 102.0), (4.0, 4.0), (0.0, 0.0), (0.0, 0.0), 0.01, faces)
    rng = np.random.default_rng(2)
    n = 30_000
    along, z, side = rng.uniform(-4.0, 4.0, n), rng.uniform(2.0, 102.0, n), rng.integers(0, 4, n)
    out = np.where((side == 1) & (z > 42.0) & (z < 44.5), 4.02, 4.0)
    azimuth = np.radians(90.0 * side)
    east = out * np.sin(azimuth) + along * np.cos(azimuth)
    north = out * np.cos(azimuth) - along * np.sin(azimuth)
    cloud = PlacedCloud(np.column_stack([east, north, z]), np.zeros(n, dtype=np.uint16))
    design = DesignedShape((0.0, 102.0), (3.99, 3.99), (0.0, 0.0), None)
    cells = map_of(cloud, Scene(azimuths_deg=(0.0,)), Asked(model=model, design=design))
    found = column(cells, "deviation_m")
    assert found[16, 5:13] == pytest.approx(0.020, abs=1e-9)
    assert np.nanmax(np.abs(np.delete(found, 16, axis=0))) < 1e-9
    assert column(cells, "design_deviation_m")[:16] == pytest.approx(0.010, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize(
    ("shaft_z_m", "n_bands"), [((2.0, 102.0), 40), ((0.0, 300.0), 40), ((0.0, 60.0), 24), ((1.0, 9.0), 10)]
)
def test_bands_are_about_two_and_a_half_metres_high(shaft_z_m: tuple[float, float], n_bands: int) -> None:
    assert map_grid(shaft_z_m).n_bands == n_bands


def test_heights_that_do_not_rise_are_refused() -> None:
    with pytest.raises(ShapeError, match="heights that rise"):
        map_grid((5.0, 5.0))


def test_a_design_that_ends_within_the_shaft_is_refused() -> None:
    short = replace(DESIGN, z_m=(2.0, 50.0, 101.0))
    with pytest.raises(ShapeError, match="needs radii from 2 to 102 m; got 2 to 101 m"):
        map_of(cloud_of(EXACT), EXACT, Asked(design=short))


def test_a_shaft_without_points_has_no_map() -> None:
    nothing = PlacedCloud(np.array([[3.0, 0.0, 200.0]]), np.zeros(1, dtype=np.uint16))
    question = MapQuestion(SHAFT_Z_M, "horizontal", None)
    found = map_surface(nothing, MODEL, axis_of(MODEL), placed(EXACT), question)
    assert found == FitFailure("needs points between 2 and 102 m, got none")


def test_few_points_take_the_scatter_of_the_others() -> None:
    rng = np.random.default_rng(3)
    values = np.concatenate([0.01 * rng.normal(size=4000), [0.5, 0.001, -0.002]])
    cell = np.concatenate([np.arange(4000) % 4, [4, 4, 4]])
    means = means_of(values, cell, 6)
    assert means.mean[4] == pytest.approx(0.0, abs=0.002)
    assert means.sigma is not None
    assert means.sigma[4] == pytest.approx(0.01 / np.sqrt(3), rel=0.1)


def test_where_all_pieces_have_few_points_they_tell_the_scatter_together() -> None:
    rng = np.random.default_rng(4)
    places = rng.normal(size=1000)
    means = means_of(np.repeat(places, 3) + 0.01 * rng.normal(size=3000), np.repeat(np.arange(1000), 3), 1000)
    assert means.sigma is not None
    assert means.sigma == pytest.approx(0.01 / np.sqrt(3), rel=0.1)
    assert np.std(means.mean - places) == pytest.approx(0.01 / np.sqrt(3), rel=0.1)


def test_where_no_piece_has_enough_points_nobody_knows_how_good_they_are() -> None:
    means = means_of(np.array([0.0, 1.0, 4.0]), np.array([0, 0, 1]), 2)
    assert means.mean.tolist() == [0.5, 4.0]
    assert means.sigma is None
