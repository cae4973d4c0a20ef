"""What a run says of its stations: pairs, coverage and where one more station would help."""

from pathlib import Path

import pytest

from storage.views import coverage_rows, epoch_rows, pair_rows, station_rows
from storage.workspace import Workspace
from tests.flows.campaigns import STRUCTURE, computed_stages, run, small_campaign
from tests.flows.stored_campaign import Stored

EPOCH = "2025-01"

pytestmark = pytest.mark.usefixtures("prefect_api")


@pytest.fixture(scope="module")
def processed(tmp_path_factory: pytest.TempPathFactory, prefect_api: str) -> Stored:
    """A campaign of three stations, measured under one scheme."""
    folder = tmp_path_factory.mktemp("campaign")
    file = small_campaign(folder)
    outcome = run(file, folder / "ws", schemes=["B"])
    assert "coverage" in computed_stages(outcome)
    return Stored(file, Workspace(Path(outcome.workspace)))


def test_every_piece_of_the_shaft_is_a_row(processed: Stored) -> None:
    rows = coverage_rows(processed.workspace, STRUCTURE, EPOCH)
    (epoch,) = epoch_rows(processed.workspace, STRUCTURE)
    assert len(rows) % 36 == 0
    assert sum(row.n_points for row in rows) == epoch.n_points_used
    assert {row.station for row in rows} <= {"ST01", "ST02", "ST03", None}


def test_coverage_of_an_epoch_is_that_of_its_rows(processed: Stored) -> None:
    rows = coverage_rows(processed.workspace, STRUCTURE, EPOCH)
    (epoch,) = epoch_rows(processed.workspace, STRUCTURE)
    heights_m = [(row.z_high_m - row.z_low_m) * (row.n_points > 0) for row in rows]
    shaft_m = max(row.z_high_m for row in rows) - min(row.z_low_m for row in rows)
    assert epoch.coverage_deg == pytest.approx(10.0 * sum(heights_m) / shaft_m, rel=1e-12)


def test_one_more_station_beside_three_would_help(processed: Stored) -> None:
    (epoch,) = epoch_rows(processed.workspace, STRUCTURE)
    assert epoch.stations_sigma_arcsec is not None
    assert epoch.next_station_sigma_arcsec is not None
    assert 0.0 < epoch.next_station_sigma_arcsec < epoch.stations_sigma_arcsec


def test_pairs_name_stations_of_the_epoch(processed: Stored) -> None:
    names = {row.station for row in station_rows(processed.workspace, STRUCTURE, EPOCH)}
    for row in pair_rows(processed.workspace, STRUCTURE, EPOCH):
        assert {row.station, row.other} <= names
        assert row.station != row.other
