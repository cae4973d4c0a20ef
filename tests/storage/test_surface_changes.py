"""The view ``surface_changes``: the same piece of two epochs, and from where on a difference is one."""

import math
from dataclasses import replace

import pytest

from storage.catalog import rebuild_catalog
from storage.publish import publish_epoch
from storage.records import SurfaceMapRow
from storage.surface_change import SurfaceChangeRow
from storage.views import surface_change_rows
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, epoch_time, surface_map_row


def changes_between(ws: Workspace, before: SurfaceMapRow, after: SurfaceMapRow) -> list[SurfaceChangeRow]:
    for number, row in enumerate((before, after)):
        tables = {**epoch_tables(f"e{number}", number), "surface_map": [row]}
        publish_epoch(ws, STRUCTURE, f"e{number}", tables)
    rebuild_catalog(ws)
    return surface_change_rows(ws, STRUCTURE, "e1")


def test_a_change_counts_from_the_reference_epoch(ws: Workspace) -> None:
    before = replace(surface_map_row("e0", 5.0, 0.004), radius_m=4.600)
    after = replace(surface_map_row("e1", 5.0, -0.002), radius_m=4.603)
    (row,) = changes_between(ws, before, after)
    assert (row.epoch, row.reference_epoch, row.epoch_time) == ("e1", "e0", epoch_time(1))
    assert (row.z_m, row.azimuth_deg) == (3.25, 5.0)
    assert row.change_m == pytest.approx(-0.006, abs=1e-15)
    assert row.radius_change_m == pytest.approx(0.003, abs=1e-12)


def test_the_level_of_detection_is_that_of_points_and_poses(ws: Workspace) -> None:
    before = replace(surface_map_row("e0", 5.0, 0.0), deviation_sigma_m=0.0003, placing_sigma_m=0.0012)
    after = replace(surface_map_row("e1", 5.0, 0.0), deviation_sigma_m=0.0004, placing_sigma_m=0.0005)
    (row,) = changes_between(ws, before, after)
    # 1.96 (root of 3^2 + 4^2, and of 12^2 + 5^2) tenths of a millimetre
    assert row.lod95_m == pytest.approx(1.96 * (0.0005 + 0.0013), rel=1e-12)


@pytest.mark.parametrize(("change_m", "significant"), [(0.0035, False), (0.0036, True), (-0.0036, True)])
def test_a_change_is_significant_beyond_the_level_of_detection(
    ws: Workspace, change_m: float, significant: bool
) -> None:
    sigmas = {"deviation_sigma_m": 0.0009, "placing_sigma_m": 0.0009 * (math.sqrt(2.0) - 1.0)}
    before = replace(surface_map_row("e0", 5.0, 0.0), **sigmas)
    (row,) = changes_between(ws, before, replace(surface_map_row("e1", 5.0, change_m), **sigmas))
    assert row.lod95_m == pytest.approx(1.96 * 0.0018, rel=1e-12)
    assert row.significant is significant


def test_a_piece_that_one_epoch_did_not_see_has_no_change(ws: Workspace) -> None:
    (row,) = changes_between(ws, surface_map_row("e0", 5.0, 0.001), surface_map_row("e1", 5.0))
    assert (row.change_m, row.lod95_m, row.significant) == (None, None, None)


def test_pieces_of_other_bands_are_not_compared(ws: Workspace) -> None:
    after = replace(surface_map_row("e1", 5.0, 0.001), z_high_m=4.6, z_m=3.3)
    assert changes_between(ws, surface_map_row("e0", 5.0, 0.001), after) == []


def test_the_change_against_the_design_has_its_own_level(ws: Workspace) -> None:
    before = replace(surface_map_row("e0", 5.0, 0.0), design_deviation_m=0.010, design_sigma_m=0.003)
    after = replace(surface_map_row("e1", 5.0, 0.0), design_deviation_m=0.030, design_sigma_m=0.004)
    (row,) = changes_between(ws, before, after)
    assert row.design_change_m == pytest.approx(0.020, rel=1e-12)
    assert row.design_lod95_m == pytest.approx(1.96 * 0.005, rel=1e-12)
