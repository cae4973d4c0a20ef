"""The clouds of stations are found by what is on record, laid in the site frame, and missed with a reason."""

import json

import numpy as np
import pytest

from storage.views import epoch_rows
from storage.views.station_clouds import StationCloud, station_clouds
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE
from tests.storage.stored_scans import keep_scans, publish_scans


def clouds(ws: Workspace, most: int = 100) -> list[StationCloud]:
    publish_scans(ws)
    return station_clouds(ws, epoch_rows(ws, STRUCTURE)[0], most)


def test_clouds_lie_where_the_last_registration_put_them(ws: Workspace) -> None:
    keep_scans(ws)
    first, second, _ = clouds(ws)
    expected = np.column_stack([100.0 + np.arange(100.0), np.full(100, 50.0), np.full(100, 1.5)])
    for found in (first, second):
        assert found.points_m is not None
        np.testing.assert_allclose(found.points_m, expected)


def test_a_cloud_is_thinned_evenly(ws: Workspace) -> None:
    keep_scans(ws)
    found = clouds(ws, most=10)[0].points_m
    assert found is not None
    np.testing.assert_allclose(np.diff(found[:, 0]), 10.0)


def test_a_station_that_was_not_used_has_no_cloud_but_the_reason(ws: Workspace) -> None:
    keep_scans(ws)
    third = clouds(ws)[2]
    assert (third.station, third.points_m, third.reason) == ("ST03", None, "not used: cut short")


def test_a_swept_scan_is_told_and_the_others_stay(ws: Workspace) -> None:
    keep_scans(ws)
    (ws.records / "ingest-1").unlink()
    first, second, _ = clouds(ws)
    assert (first.points_m, first.reason) == (None, "its scan was swept from this workspace")
    assert second.points_m is not None


def test_without_any_record_every_station_says_why(ws: Workspace) -> None:
    assert [cloud.reason for cloud in clouds(ws)[:2]] == ["its scan or its pose is not on record here"] * 2


@pytest.mark.parametrize("text", ["", "{", json.dumps({"result": 3})])
def test_a_torn_record_counts_as_swept(ws: Workspace, text: str) -> None:
    keep_scans(ws)
    (ws.records / "ingest-2").write_text(text)
    assert clouds(ws)[1].reason == "its scan was swept from this workspace"
