"""What a campaign file asks of the stages: axes turned to east, north, up, the origin off, and what is not known None."""

from pathlib import Path

import pytest

from tasks.plan import plan_prior, plan_scans, plan_shaft_hint, plan_stable
from tasks.stated_pose import refuse_far_pose, stated_pose
from tests.unit.settings.campaign_text import WHOLE, edited, load

GRID = edited("origin_m = [0.0, 0.0, 0.0]", "origin_m = [500.0, 100.0, 10.0]")
NEU = edited('axes = "ENU"', 'axes = "NEU"', edited("base_xy_m = [0.0, 0.0]", "base_xy_m = [3.0, 7.0]", GRID))
HALL = (
    '[registration]\nstable = [{ name = "hall", low_m = [590.0, 70.0, 9.0], high_m = [610.0, 90.0, 18.0] }]\n'
)
POSITION_2, HEADING_2 = "position_m = [-12.9, 231.4, 1.61]\n", "heading_deg = 180.0\n"
IN_FILE = edited(HEADING_2, 'pose = "file"\npart = "Scan 2"\n', edited(POSITION_2, "", GRID))


def test_the_hint_for_registration_is_the_prior_of_the_structure_in_the_site_frame(tmp_path: Path) -> None:
    campaign = load(tmp_path, NEU)
    hint = plan_shaft_hint(campaign)
    assert hint.base_xy_m == plan_prior(campaign).base_xy_m == (7.0, 3.0)
    assert (hint.shaft_z_m, hint.radius_m) == ((2.0, 102.0), (4.6, 2.7))


def test_stable_boxes_are_in_the_site_frame(tmp_path: Path) -> None:
    (box,) = plan_stable(load(tmp_path, NEU + HALL))
    assert (box.name, box.low_m, box.high_m) == ("hall", (-30.0, 90.0, -1.0), (-10.0, 110.0, 8.0))


@pytest.mark.parametrize("dropped", [POSITION_2, HEADING_2])
def test_what_a_station_does_not_state_stays_unknown(tmp_path: Path, dropped: str) -> None:
    campaign = load(tmp_path, edited(dropped, ""))
    planned = plan_scans(campaign, campaign.epochs[0])[1]
    assert not planned.is_registered
    assert (planned.position_m is None, planned.heading_rad is None) == (
        dropped == POSITION_2,
        dropped == HEADING_2,
    )


def test_a_registered_cloud_is_asked_for_in_the_frame_of_its_file(tmp_path: Path) -> None:
    campaign = load(tmp_path, edited('"local"', '"EPSG:32650"', NEU))
    (planned,) = plan_scans(campaign, campaign.epochs[1])
    assert planned.is_registered
    request = planned.request
    assert (request.origin_m, request.swap_axes, request.horizontal) == (
        (500.0, 100.0, 10.0),
        True,
        "EPSG:32650",
    )


def test_the_pose_of_a_file_is_stated_in_the_site_frame(tmp_path: Path) -> None:
    campaign = load(tmp_path, IN_FILE)
    planned = plan_scans(campaign, campaign.epochs[0])[1]
    assert planned.has_pose_in_file
    assert planned.request.part == "Scan 2"
    pose = stated_pose(campaign, planned, {"position_m": [731.0, 92.0, 11.5], "heading_deg": 90.0})
    assert pose.position_m == (231.0, -8.0, 1.5)
    assert pose.heading_rad == pytest.approx(1.5707963267948966, abs=1e-15)


def test_the_pose_of_the_campaign_does_not_ask_the_file(tmp_path: Path) -> None:
    campaign = load(tmp_path, WHOLE)
    planned = plan_scans(campaign, campaign.epochs[0])[1]
    facts = {"position_m": [1e6, 0.0, 0.0], "heading_deg": 12.0}
    assert stated_pose(campaign, planned, facts).position_m == (-12.9, 231.4, 1.61)
    assert refuse_far_pose(campaign, planned, facts) is None


@pytest.mark.parametrize(("east_m", "is_far"), [(10_499.0, False), (10_501.0, True)])
def test_a_pose_that_no_scanner_can_have_is_refused(tmp_path: Path, east_m: float, is_far: bool) -> None:
    campaign = load(tmp_path, IN_FILE)
    planned = plan_scans(campaign, campaign.epochs[0])[1]
    refusal = refuse_far_pose(campaign, planned, {"position_m": [east_m, 100.0, 10.0], "heading_deg": 0.0})
    assert (refusal is not None) == is_far
