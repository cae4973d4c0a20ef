from dataclasses import replace

import pytest

from storage.records import CoverageCell, RemovalRow, columns_of
from tasks.conventions import ARCSEC_RAD
from tasks.epoch_quality import Outlook, rate_quality
from tasks.epoch_tables import Home
from tasks.exchange import plain, rebuild
from tasks.next_station import NextStation
from tasks.placing import PlacedCloud
from tasks.preprocessing import NOT_NEEDED
from tasks.quality_rows import coverage_rows, pair_rows, told_of_thinning, with_outlook
from tasks.registration import PairDiagnosis, registered_cloud
from tests.storage.campaign import epoch_row
from tests.unit.networks import MODEL, SHAFT_Z_M, registration, seen_from, sigmas

HOME = Home("chimney-01", "2025-03")
PAIR = PairDiagnosis("ST01", "ST02", 0.4, 900, 0.006, None, 0.005, 0.003, 12.0 * ARCSEC_RAD)
NO_LOOP = PairDiagnosis("ST02", "ST01", 0.3, 12, None, None, None, None, None)


def test_every_pair_is_a_row_with_its_angle_in_arc_seconds() -> None:
    known = replace(registration([0.0, 90.0], sigmas()), pairs=(PAIR, NO_LOOP))
    first, second = pair_rows(HOME, known)
    assert (first.structure, first.epoch, first.station, first.other) == (
        "chimney-01",
        "2025-03",
        "ST01",
        "ST02",
    )
    assert (first.overlap, first.n_matches, first.rmse_m, first.rmse_background_m) == (0.4, 900, 0.006, 0.005)
    assert first.closure_arcsec == pytest.approx(12.0, rel=1e-12)
    assert (second.rmse_m, second.rmse_shaft_m, second.closure_m, second.closure_arcsec) == (None,) * 4


def test_a_registration_that_compared_no_pair_has_no_row() -> None:
    assert pair_rows(HOME, registered_cloud("registered", sigmas())) == []


def test_a_row_of_coverage_says_what_its_cell_says() -> None:
    cell = CoverageCell(2.0, 7.0, 350.0, 360.0, 12, 2, "ST07", -0.002)
    (row,) = coverage_rows(HOME, [cell])
    assert (row.structure, row.epoch) == ("chimney-01", "2025-03")
    assert [getattr(row, field.name) for field in columns_of(CoverageCell)] == [
        2.0,
        7.0,
        350.0,
        360.0,
        12,
        2,
        "ST07",
        -0.002,
    ]


def test_an_epoch_tells_its_coverage_and_the_next_station() -> None:
    row = with_outlook(epoch_row("e0"), Outlook(270.0, NextStation(90.0, 3.0, 2.0), None))
    assert (row.coverage_deg, row.next_station_azimuth_deg) == (270.0, 90.0)
    assert (row.stations_sigma_arcsec, row.next_station_sigma_arcsec) == (3.0, 2.0)


def test_without_a_suggestion_only_the_coverage_is_told() -> None:
    row = with_outlook(epoch_row("e0"), Outlook(270.0, None, "no"))
    assert (row.coverage_deg, row.next_station_azimuth_deg, row.stations_sigma_arcsec) == (270.0, None, None)


def test_without_a_shaft_nothing_is_told() -> None:
    assert with_outlook(epoch_row("e0"), None) == epoch_row("e0")


def test_quality_of_an_epoch_names_stations_and_suggests_the_unseen_side() -> None:
    west = (240.0, 270.0, 300.0)
    cloud = PlacedCloud(*seen_from(west, n=3_000))
    quality = rate_quality(cloud, MODEL, registration(west, sigmas()), sigmas(), SHAFT_Z_M)
    assert {cell.station for cell in quality.cells} == {"ST01", "ST02", "ST03", None}
    assert quality.outlook.covered_deg < 300.0
    assert quality.outlook.next_station is not None
    assert quality.outlook.next_station.azimuth_deg == pytest.approx(90.0, abs=30.0)


def test_quality_of_a_registered_cloud_says_why_it_suggests_nothing() -> None:
    points_m, station_index = seen_from([0.0], n=1_000)
    known = registered_cloud("registered", sigmas())
    quality = rate_quality(PlacedCloud(points_m, station_index), MODEL, known, sigmas(), SHAFT_Z_M)
    assert quality.outlook.next_station is None
    assert "outside the shaft" in str(quality.outlook.why_none)


@pytest.mark.parametrize(
    "outlook", [Outlook(270.0, NextStation(90.0, 3.0, 2.0), None), Outlook(1 / 3, None, "x")]
)
def test_an_outlook_travels_unchanged(outlook: Outlook) -> None:
    assert rebuild(Outlook, plain(outlook)) == outlook


def removal(reason: str, n_points: int) -> RemovalRow:
    return RemovalRow(structure="chimney-01", epoch="2025-03", step=0, reason=reason, n_points=n_points)


def test_an_even_sample_of_the_shaft_is_told_and_the_whole_shaft_is_not() -> None:
    rows = [removal("duplicate", 5), removal(NOT_NEEDED, 9_000), removal("kept", 1_000)]
    assert told_of_thinning(rows, 1_000) == [
        "of some 10,000 points on the shaft an even sample of 1,000 is used ([preprocessing] most_points = 1000)"
    ]
    assert told_of_thinning([removal(NOT_NEEDED, 0), removal("kept", 1_000)], 1_000) == []
