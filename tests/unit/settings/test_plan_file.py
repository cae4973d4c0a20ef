"""Plan files: their keys and bounds, and which stations of a campaign file stand in for them."""

from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.methods import ROBUST_THICKNESS_M
from tasks.settings.plan import PlanFile
from tasks.settings.plan_reading import load_plan
from tasks.survey_design import Design, design_survey
from tests.unit.settings.campaign_text import WHOLE, edited

PLAN = """\
schema_version = 1
[structure]
id = "chimney-01"
kind = "chimney"
height_m = 102.0
shaft_z_m = [2.0, 102.0]
radius_m = [4.6, 2.7]
[plan]
count = 4
distance_m = 230.0
"""

NAMED = edited(
    "count = 4\ndistance_m = 230.0\n",
    """\
stations = [{ id = "A", position_m = [100.0, 20.0, 1.5] }, { id = "B", position_m = [-90.0, 5.0, 1.5] }]
""",
    PLAN,
)


def load(folder: Path, text: str) -> PlanFile:
    file = folder / "plan.toml"
    file.write_text(text, encoding="utf-8")
    found = load_plan(file)
    assert isinstance(found, PlanFile)
    return found


def campaign_design(folder: Path, text: str, epoch: str | None = None) -> Design:
    file = folder / "campaign.toml"
    file.write_text(text, encoding="utf-8")
    return design_survey(load_plan(file), epoch)


def test_count_and_distance_place_stations_evenly_around(tmp_path: Path) -> None:
    design = design_survey(load(tmp_path, PLAN))
    assert [site.station for site in design.survey.sites] == ["ST01", "ST02", "ST03", "ST04"]
    east = design.survey.sites[1].position_m
    assert east == pytest.approx((230.0, 0.0, 1.6))


def test_positions_are_read_in_the_order_of_the_axes(tmp_path: Path) -> None:
    text = edited("[plan]", '[frame]\naxes = "NEU"\n[plan]', NAMED)
    design = design_survey(load(tmp_path, text))
    assert design.survey.sites[0].position_m == (20.0, 100.0, 1.5)


def test_the_scheme_says_which_heights_count(tmp_path: Path) -> None:
    ends = design_survey(load(tmp_path, PLAN + 'primary = ["E", "paper"]\n')).survey.bands
    whole = design_survey(load(tmp_path, PLAN + 'primary = ["S", "surface"]\n')).survey.bands
    assert ends.z_m == pytest.approx([2.005, 101.995])
    assert whole.thickness_m.sum() == pytest.approx(100.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (PLAN + "spacin_deg = 0.1\n", "plan.spacin_deg: unknown key; did you mean 'spacing_deg'"),
        (PLAN + "points_per_station = 3\n", "greater than or equal to 10, got 3; meaning: points of each"),
        (
            PLAN + "spacing_deg = 0.1\npoints_per_station = 100\n",
            "has both spacing_deg and points_per_station",
        ),
        (PLAN + "azimuths_deg = [0.0]\n", "needs one of stations, count and azimuths_deg, got 2"),
        (edited("count = 4\n", "", PLAN), "needs one of stations, count and azimuths_deg, got 0"),
        (edited("distance_m = 230.0\n", "", PLAN), "needs distance_m; write the distance from the axis"),
        (NAMED + "distance_m = 9.0\n", "stations have their own positions; drop distance_m"),
        (NAMED.replace('"B"', '"a"'), "station id 'a' is taken"),
        (
            PLAN + 'hidden = [{ station = "ST09", below_m = 5.0 }]\n',
            "unknown station 'ST09'; did you mean 'ST0",
        ),
        (
            PLAN + 'hidden = [{ station = "ST01" }]\n',
            r"hidden\[#1\]: hides the whole shaft; write azimuth_deg",
        ),
        (PLAN + "hidden = [{ azimuth_deg = [10.0, 370.0] }]\n", "should be less than or equal to 360"),
        (PLAN + "hidden = [{ azimuth_deg = [-10.0, 350.0] }]\n", "needs two azimuths that differ"),
        (PLAN + 'primary = ["Z", "robust"]\n', "unknown scheme 'Z'; known: A, B, C, D, E, F, S"),
        (PLAN + 'primary = ["S", "robust"]\n', "scheme 'S' has no method 'robust'; S goes with surface"),
        (PLAN + "incidence_limit_deg = 90.0\n", "should be less than 90"),
        (PLAN + "[[epochs]]\n", "epochs: unknown key"),
    ],
)
def test_what_is_wrong_with_a_plan_file_is_said(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load(tmp_path, text)


def test_a_station_in_the_shaft_is_refused(tmp_path: Path) -> None:
    file = load(tmp_path, edited("distance_m = 230.0", "distance_m = 4.0", PLAN))
    with pytest.raises(
        InputError, match=r"station ST01 stands 4 m from the axis, the shaft has a radius of 4\.6 m"
    ):
        design_survey(file)


def test_a_square_tower_is_refused(tmp_path: Path) -> None:
    file = load(tmp_path, edited('"chimney"', '"square-tower"', PLAN))
    with pytest.raises(InputError, match="needs a round shaft"):
        design_survey(file)


def test_a_campaign_lends_the_stations_of_its_latest_epoch_that_states_positions(tmp_path: Path) -> None:
    design = campaign_design(tmp_path, WHOLE)
    assert (design.epoch, design.primary) == ("e1", ("S", "surface"))
    assert [site.position_m for site in design.survey.sites] == [(231.4, -12.9, 1.61), (-12.9, 231.4, 1.61)]


def test_a_campaign_may_name_a_scheme_of_its_own(tmp_path: Path) -> None:
    design = campaign_design(tmp_path, edited('["S", "surface"]', '["G", "robust"]', WHOLE))
    assert len(design.survey.bands.z_m) == 40


@pytest.mark.parametrize(
    ("text", "epoch", "message"),
    [
        (WHOLE, "e2", "epoch e2 lacks stations: it comes as one registered cloud"),
        (edited("position_m = [231.4, -12.9, 1.61]\n", "", WHOLE), "e1", "epoch e1 lacks ST01"),
        (edited("position_m = [231.4, -12.9, 1.61]\n", "", WHOLE), None, "this campaign has none"),
    ],
)
def test_an_epoch_without_positions_cannot_be_planned(
    tmp_path: Path, text: str, epoch: str | None, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        campaign_design(tmp_path, text, epoch)


def test_slices_are_as_thick_as_the_method_makes_them(tmp_path: Path) -> None:
    thin = design_survey(load(tmp_path, PLAN + 'primary = ["A", "paper"]\n')).survey.bands
    thick = design_survey(load(tmp_path, PLAN + 'primary = ["A", "robust"]\n')).survey.bands
    assert thin.thickness_m == pytest.approx(0.01)
    assert thick.thickness_m == pytest.approx(ROBUST_THICKNESS_M)


def test_the_mean_of_vertices_cannot_be_planned(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="scheme F takes means of vertices"):
        design_survey(load(tmp_path, PLAN + 'primary = ["F", "paper"]\n'))
