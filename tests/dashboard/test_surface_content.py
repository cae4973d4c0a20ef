"""Rows of the map, laid out as the skin of the shaft."""

from dataclasses import replace

import numpy as np
import pytest

from dashboard.content.surface import RANGES_MM, range_mm, skin_change, skin_map, station_marks
from storage.records import SurfaceMapRow
from storage.views import SurfaceChangeRow
from tests.storage.campaign import epoch_time, station_row, surface_map_row, tilt_row


def map_rows(n_bands: int = 3, n_sectors: int = 36) -> list[SurfaceMapRow]:
    """Deviations that tell their band and sector; one piece has no points."""
    rows = []
    for band in range(n_bands):
        for sector in range(n_sectors):
            missing = (band, sector) == (1, 7)
            row = surface_map_row("e0", 10.0 * sector + 5.0, None if missing else 1e-3 * band + 1e-5 * sector)
            low = 2.0 + 2.5 * band
            rows.append(
                replace(row, z_low_m=low, z_high_m=low + 2.5, z_m=low + 1.25, radius_m=4.0 - 0.1 * band)
            )
    return rows


def change_rows(**changed: object) -> list[SurfaceChangeRow]:
    return [
        replace(
            SurfaceChangeRow(
                "s", "e1", epoch_time(1), "e0", row.z_low_m, row.z_high_m, row.z_m, row.azimuth_deg,
                row.deviation_m, 0.0015, None if row.deviation_m is None else row.deviation_m > 0.0015, 0.0, None, None,
            ),
            **changed,
        )
        for row in map_rows()
    ]  # fmt: skip


def test_every_row_is_at_its_band_and_sector() -> None:
    rows = map_rows()
    skin = skin_map(rows)
    assert skin is not None
    assert skin.deviation_m.shape == (3, 36)
    for row in rows:
        band, sector = round((row.z_low_m - 2.0) / 2.5), round((row.azimuth_deg - 5.0) / 10.0)
        if row.deviation_m is None:
            assert np.isnan(skin.deviation_m[band, sector])
            assert np.isnan(skin.sigma_m[band, sector])
            assert skin.n_points[band, sector] == 0
        else:
            assert skin.deviation_m[band, sector] == row.deviation_m
            assert skin.sigma_m[band, sector] == np.hypot(row.deviation_sigma_m, row.placing_sigma_m)
    np.testing.assert_allclose(skin.radius_m, [4.0, 3.9, 3.8])
    np.testing.assert_allclose(skin.grid.z_edges_m, [2.0, 4.5, 7.0, 9.5])
    np.testing.assert_allclose(skin.grid.azimuth_edges_deg, np.arange(0.0, 361.0, 10.0))


def test_a_change_counts_what_is_beyond_its_level_of_detection() -> None:
    change = skin_change(change_rows())
    assert change is not None
    assert change.reference_epoch == "e0"
    assert (change.n_significant, change.n_compared) == (36, 107)


def test_no_rows_are_no_map() -> None:
    assert skin_map([]) is None
    assert skin_change([]) is None


@pytest.mark.parametrize("size_mm", [0.2, 1.0, 4.0, 11.0, 900.0])
def test_the_range_of_colours_holds_nearly_all_and_is_one_for_all_epochs(size_mm: float) -> None:
    rng = np.random.default_rng(5)
    tables = [1e-3 * size_mm * rng.uniform(-1.0, 1.0, (20, 36)), np.full((2, 36), np.nan)]
    limit = range_mm(*tables)
    assert limit in RANGES_MM
    assert np.mean(np.abs(1e3 * tables[0]) <= limit) >= 0.98
    assert range_mm(*reversed(tables)) == limit


def test_nothing_to_colour_still_has_a_range() -> None:
    assert range_mm(np.full((2, 36), np.nan)) == RANGES_MM[0]


def test_stations_are_marked_where_they_stand_seen_from_the_axis() -> None:
    north = replace(station_row("e0", "N"), position_east_m=0.01, position_north_m=99.98)
    west = replace(station_row("e0", "W"), position_east_m=-49.99, position_north_m=-0.02)
    lost = replace(station_row("e0", "X"), state="failed")
    unplaced = replace(station_row("e0", "Y"), position_east_m=None)
    marks = station_marks([west, lost, north, unplaced], tilt_row("e0"))
    assert [mark.station for mark in marks] == ["N", "W"]
    assert [mark.azimuth_deg for mark in marks] == pytest.approx([0.0, 270.0])
    assert [mark.distance_m for mark in marks] == pytest.approx([100.0, 50.0])
    assert station_marks([north], None) == []
