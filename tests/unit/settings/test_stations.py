"""Stations whose pose is not known or stands in their scan file, files with several scans, and stable surroundings."""

from pathlib import Path

import pytest

from storage.errors import InputError
from tests.unit.settings.campaign_text import WHOLE, edited, load

POSITION_2 = "position_m = [-12.9, 231.4, 1.61]\n"
HEADING_2 = "heading_deg = 180.0\n"
STATION_2 = r"epochs\[e1\]\.stations\[ST02\]"
HALL = '{ name = "hall", low_m = [50.0, -10.0, -1.0], high_m = [70.0, 10.0, 8.0] }'


def with_parts(first: str, second: str) -> str:
    """Two stations of an epoch in one file."""
    text = edited('"e1/ST01.laz"', f'"e1/all.e57"\n{first}')
    return edited('"e1/ST02.laz"', f'"e1/all.e57"\n{second}', text)


def with_stable(*boxes: str, text: str = WHOLE) -> str:
    return f"{text}[registration]\nstable = [{', '.join(boxes)}]\n"


@pytest.mark.parametrize("dropped", [POSITION_2, HEADING_2])
def test_a_station_may_leave_out_what_is_not_known_of_it(tmp_path: Path, dropped: str) -> None:
    station = load(tmp_path, edited(dropped, "")).epochs[0].stations[1]
    assert (station.position_m is None, station.heading_deg is None) == (
        dropped == POSITION_2,
        dropped == HEADING_2,
    )


@pytest.mark.parametrize(("written", "part"), [("2", 2), ('"Scan 2"', "Scan 2")])
def test_a_part_is_a_number_or_a_name(tmp_path: Path, written: str, part: int | str) -> None:
    campaign = load(tmp_path, with_parts("part = 1", f"part = {written}"))
    assert [station.part for station in campaign.epochs[0].stations] == [1, part]


@pytest.mark.parametrize("written", ["0", "-1", "1.5", "true", '" "', "[1]"])
def test_a_part_that_is_no_number_from_1_and_no_name_is_refused(tmp_path: Path, written: str) -> None:
    with pytest.raises(
        InputError, match=rf"{STATION_2}\.part: needs the number of a scan, from 1, or its name"
    ):
        load(tmp_path, with_parts("part = 1", f"part = {written}"))


def test_a_part_that_two_stations_name_is_told(tmp_path: Path) -> None:
    told = (
        rf"{STATION_2}\.scan: part 2 of 'e1/all\.e57' is already used by epochs\[e1\]\.stations\[ST01\]\.scan"
    )
    with pytest.raises(InputError, match=told):
        load(tmp_path, with_parts("part = 2", "part = 2"))


def test_a_file_of_two_stations_needs_a_part_for_each(tmp_path: Path) -> None:
    told = "scan 'e1/all\\.e57' is already used by .*; name each scan once, or say which with part"
    with pytest.raises(InputError, match=told):
        load(tmp_path, with_parts("part = 2", ""))


def test_a_part_does_not_let_two_epochs_share_a_file(tmp_path: Path) -> None:
    text = edited('"e1/ST02.laz"', '"e2/merged.laz"\npart = 2')
    with pytest.raises(
        InputError, match=r"scan 'e2/merged\.laz' is already used by .*; name each scan once$"
    ):
        load(tmp_path, text)


def test_the_pose_of_a_file_stands_in_place_of_position_and_heading(tmp_path: Path) -> None:
    text = edited(HEADING_2, 'pose = "file"\n', edited(POSITION_2, ""))
    assert load(tmp_path, text).epochs[0].stations[1].pose == "file"


@pytest.mark.parametrize("dropped", [POSITION_2, HEADING_2])
def test_a_pose_is_stated_in_one_place_only(tmp_path: Path, dropped: str) -> None:
    text = edited(dropped, 'pose = "file"\n')
    with pytest.raises(
        InputError, match=rf'{STATION_2}: pose = "file" takes position and heading from the scan'
    ):
        load(tmp_path, text)


def test_the_pose_of_a_file_needs_right_handed_axes(tmp_path: Path) -> None:
    text = edited(
        'axes = "ENU"', 'axes = "NEU"', edited(HEADING_2, 'pose = "file"\n', edited(POSITION_2, ""))
    )
    with pytest.raises(
        InputError, match=rf"{STATION_2}\.pose: a scan file states poses with x east, y north"
    ):
        load(tmp_path, text)


def test_stable_surroundings_are_boxes_with_names(tmp_path: Path) -> None:
    (region,) = load(tmp_path, with_stable(HALL)).registration.stable
    assert (region.name, region.low_m, region.high_m) == ("hall", (50.0, -10.0, -1.0), (70.0, 10.0, 8.0))


def test_no_stable_surroundings_are_the_default(tmp_path: Path) -> None:
    assert load(tmp_path, WHOLE).registration.stable == ()


@pytest.mark.parametrize("low_m", ["[70.0, -10.0, -1.0]", "[50.0, 11.0, -1.0]", "[50.0, -10.0, 8.0]"])
def test_a_box_needs_its_least_coordinates_in_low(tmp_path: Path, low_m: str) -> None:
    box = HALL.replace("[50.0, -10.0, -1.0]", low_m)
    with pytest.raises(InputError, match=r"stable\[#1\]: box 'hall' needs every number of low_m below that"):
        load(tmp_path, with_stable(box))


def test_two_boxes_of_one_name_are_told(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"stable\[#2\]\.name: name of a box 'hall' is taken by registration\."
    ):
        load(tmp_path, with_stable(HALL, HALL))


# the shaft has a radius of 4.6 m at most: 2 m beside it is 6.6 m from its axis
@pytest.mark.parametrize(("low_east_m", "is_near"), [(-5.0, True), (6.5, True), (6.7, False)])
def test_a_box_near_the_shaft_is_refused_at_any_height(
    tmp_path: Path, low_east_m: float, is_near: bool
) -> None:
    box = HALL.replace("50.0, -10.0, -1.0", f"{low_east_m}, -10.0, -9.0").replace("10.0, 8.0]", "10.0, -8.0]")
    if not is_near:
        assert load(tmp_path, with_stable(box)).registration.stable
        return
    with pytest.raises(InputError, match="epochs are never registered on the structure itself"):
        load(tmp_path, with_stable(box))


def test_a_box_is_meant_in_the_axes_of_the_frame_before_the_origin(tmp_path: Path) -> None:
    text = edited('axes = "ENU"', 'axes = "NEU"').replace("base_xy_m = [0.0, 0.0]", "base_xy_m = [0.0, 60.0]")
    text = edited("origin_m = [0.0, 0.0, 0.0]", "origin_m = [500.0, 100.0, 0.0]", text)
    far, near = (
        HALL.replace("50.0, -10.0", f"490.0, {east}").replace("70.0, 10.0", f"510.0, {east + 20.0}")
        for east in (100.0, 150.0)
    )
    assert load(tmp_path, with_stable(far, text=text)).registration.stable
    with pytest.raises(InputError, match=r"stable\[#1\]: box 'hall' comes within 2 m of the shaft"):
        load(tmp_path, with_stable(near, text=text))
