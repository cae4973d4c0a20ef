from dataclasses import replace

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.conventions import azimuth_deg
from tasks.coverage import CHUNK, SECTORS, Coverage, band_edges_m, count_coverage, coverage_cells
from tasks.preprocessing import ShaftModel
from tests.unit.networks import MODEL, SHAFT_Z_M, coverage_from, seen_from

PLUMB = ShaftModel(0.0, 0.0, 0.0, 0.0, (0.0, 20.0), (3.0, 3.0), (0.0, 0.0), (0.0, 0.0), 0.01)
NOBODY = np.zeros(0, dtype=np.uint16)


def one_point(east: float, north: float, z: float, model: ShaftModel = PLUMB) -> Coverage:
    station = np.zeros(1, dtype=np.uint16)
    return count_coverage(np.array([[east, north, z]]), station, model, (0.0, 12.0), 1)


def place_of(coverage: Coverage) -> tuple[int, int]:
    ((band, sector),) = np.argwhere(coverage.points)
    return int(band), int(sector)


def test_bands_are_five_metres_high_and_the_last_one_ends_with_the_shaft() -> None:
    assert band_edges_m((0.0, 12.0)).tolist() == [0.0, 5.0, 10.0, 12.0]
    assert len(band_edges_m((2.0, 102.0))) == 21
    assert band_edges_m((1.0, 3.0)).tolist() == [1.0, 3.0]


@pytest.mark.parametrize("rest_m", [0.0, 1e-12, 0.01, 0.99])
def test_a_small_rest_is_no_band_of_its_own(rest_m: float) -> None:
    assert band_edges_m((0.1, 15.1 + rest_m)).tolist() == [0.1, 5.1, 10.1, 15.1 + rest_m]


def test_points_of_a_small_rest_count_in_the_last_band() -> None:
    points_m = np.array([[3.0, 0.5, 10.5]])
    coverage = count_coverage(points_m, np.zeros(1, dtype=np.uint16), PLUMB, (0.0, 10.5), 1)
    assert place_of(coverage)[0] == 1


@pytest.mark.parametrize(
    ("east", "north", "sector"),
    [(0.1, 3.0, 0), (3.0, -0.1, 9), (0.1, -3.0, 17), (-0.1, -3.0, 18), (-3.0, 0.1, 27), (-0.1, 3.0, 35)],
)
def test_sectors_run_clockwise_from_north(east: float, north: float, sector: int) -> None:
    assert place_of(one_point(east, north, 6.0)) == (1, sector)


@pytest.mark.parametrize(("z", "band"), [(0.0, 0), (4.999, 0), (5.0, 1), (10.0, 2), (12.0, 2)])
def test_a_point_between_two_bands_belongs_to_the_upper_one_and_at_the_top_to_the_last(
    z: float, band: int
) -> None:
    assert place_of(one_point(3.0, 0.5, z))[0] == band


def test_points_above_and_below_the_shaft_do_not_count() -> None:
    assert one_point(3.0, 0.5, 12.001).points.sum() == 0
    assert one_point(3.0, 0.5, -0.001).points.sum() == 0


def test_sectors_are_about_the_axis_where_it_leans_to() -> None:
    leaning = replace(PLUMB, lean_east=1.0)
    assert place_of(one_point(10.0 + 3.0, 0.1, 10.0, leaning))[1] == 8
    assert place_of(one_point(10.0 - 3.0, 0.1, 10.0, leaning))[1] == 27


def test_counts_are_those_of_a_loop_over_the_points() -> None:
    bent = replace(
        MODEL, bend_east_m=(0.4, -0.6, 0.5), bend_north_m=(-0.1, 0.2, 0.0), radius_z_m=(8.0, 50.0, 90.0)
    )
    points_m, station_index = seen_from([10.0, 250.0], n=1_000)
    found = count_coverage(points_m, station_index, bent, SHAFT_Z_M, 2)
    counts = np.zeros((20, SECTORS, 2), dtype=int)
    off_m = np.zeros((20, SECTORS))
    for point, station in zip(points_m, station_index, strict=True):
        away = point[:2] - bent.axis_at(point[2])
        place = int((point[2] - 2.0) // 5.0), int(azimuth_deg(*away) // 10.0)
        counts[*place, station] += 1
        off_m[place] += np.hypot(*away) - bent.radius_at(point[2])
    assert np.array_equal(found.counts, counts)
    # sums of thousands of metres, in another order
    assert found.off_sum_m == pytest.approx(off_m, abs=1e-9)


def test_points_of_several_chunks_count_as_those_of_one() -> None:
    points_m, station_index = seen_from([0.0, 120.0], n=CHUNK // 2 + 5_000)
    whole = count_coverage(points_m, station_index, MODEL, SHAFT_Z_M, 2)
    halves = [count_coverage(points_m[i::2], station_index[i::2], MODEL, SHAFT_Z_M, 2) for i in (0, 1)]
    assert np.array_equal(whole.counts, halves[0].counts + halves[1].counts)
    assert whole.counts.sum() == len(points_m)


def test_stations_on_all_sides_cover_the_whole_circumference() -> None:
    assert coverage_from([0.0, 120.0, 240.0]).covered_deg == 360.0


def test_one_station_covers_half_of_the_circumference() -> None:
    # sectors at the limb are seen at a grazing angle and get few points
    assert coverage_from([45.0]).covered_deg == pytest.approx(180.0, abs=12.0)


def test_bands_count_by_their_height() -> None:
    lower = np.column_stack([*3.0 * np.array([np.sin(AROUND), np.cos(AROUND)]), np.full(SECTORS, 2.0)])
    coverage = count_coverage(lower, np.zeros(SECTORS, dtype=np.uint16), PLUMB, (0.0, 8.0), 1)
    assert coverage.covered_deg == pytest.approx(360.0 * 5.0 / 8.0, rel=1e-12)


AROUND = np.radians(10.0 * np.arange(SECTORS) + 5.0)


def test_the_station_with_the_most_points_of_a_piece_is_named() -> None:
    points_m = np.array([[3.0, 0.1, 1.0], [3.0, 0.2, 1.5], [3.0, 0.1, 2.0], [-3.0, 0.1, 1.0]])
    coverage = count_coverage(points_m, np.array([1, 0, 1, 0], dtype=np.uint16), PLUMB, (0.0, 5.0), 3)
    cells = coverage_cells(coverage, ["a", "b", "c"])
    assert len(cells) == SECTORS
    assert [
        (cell.azimuth_low_deg, cell.n_points, cell.n_stations, cell.station)
        for cell in cells
        if cell.n_points
    ] == [
        (80.0, 3, 2, "b"),
        (270.0, 1, 1, "a"),
    ]


def test_where_nobody_saw_anything_there_is_no_station_and_no_distance() -> None:
    cell = coverage_cells(count_coverage(np.zeros((0, 3)), NOBODY, PLUMB, (0.0, 5.0), 1), ["a"])[0]
    assert (cell.n_points, cell.n_stations, cell.station, cell.off_surface_m) == (0, 0, None, None)


def test_a_dent_shows_as_a_distance_inward() -> None:
    cells = coverage_cells(one_point(2.96, 0.0, 1.0), ["a"])
    assert [cell.off_surface_m for cell in cells if cell.n_points] == [pytest.approx(-0.04, abs=1e-12)]


@pytest.mark.parametrize(
    ("n_points", "n_indices", "n_stations", "match"),
    [
        (3, 2, 1, r"needs points \(n, 3\) and a station each; got \(3, 3\) and \(2,\)"),
        (3, 3, 0, "needs station indices below 0; got 0"),
    ],
)
def test_shapes_that_disagree_are_refused(n_points: int, n_indices: int, n_stations: int, match: str) -> None:
    with pytest.raises(ShapeError, match=match):
        count_coverage(
            np.zeros((n_points, 3)), np.zeros(n_indices, dtype=np.uint16), PLUMB, (0.0, 5.0), n_stations
        )


def test_heights_that_do_not_rise_are_refused() -> None:
    with pytest.raises(ShapeError, match="heights that rise"):
        band_edges_m((5.0, 5.0))


def test_as_many_ids_as_stations_are_needed() -> None:
    with pytest.raises(ShapeError, match="coverage of 1 stations; got 2 ids"):
        coverage_cells(one_point(3.0, 0.1, 1.0), ["a", "b"])
