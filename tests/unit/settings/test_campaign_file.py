"""A sound campaign file is read as it is meant."""

import json
import re
from datetime import timedelta
from pathlib import Path
from typing import get_args

import pytest

from storage.errors import InputError
from tasks.preprocessing import ShaftOptions, kinds
from tasks.settings import load_campaign
from tasks.settings.example import KINDS, example_campaign
from tasks.settings.structure import Kind
from tests.shared import SHARED, needs_shared
from tests.unit.settings.campaign_text import FEWEST, WHOLE, edited, load


@needs_shared
def test_example_of_the_contract_is_a_valid_campaign(tmp_path: Path) -> None:
    found = re.search(r"```toml\n(.*?)```", (SHARED / "contract.md").read_text("utf-8"), re.DOTALL)
    assert found is not None
    campaign = load(tmp_path, found[1])
    assert campaign.report.primary == ("S", "surface")
    assert [epoch.id for epoch in campaign.epochs] == ["2025-03", "2026-03"]


@needs_shared
def test_shared_campaign_is_valid_as_it_stands() -> None:
    campaign = load_campaign(SHARED / "data" / "campaign" / "campaign.toml")
    assert [len(epoch.stations) for epoch in campaign.epochs] == [8, 8]


def test_time_keeps_its_offset(tmp_path: Path) -> None:
    assert load(tmp_path, WHOLE).epochs[0].time.utcoffset() == timedelta(hours=8)


def test_defaults_are_filled_in_where_the_file_is_silent(tmp_path: Path) -> None:
    campaign = load(tmp_path, FEWEST)
    assert campaign.structure.title == "pole"
    assert campaign.report.primary == ("S", "surface")
    assert campaign.instrument.position_sigma_m == (0.015, 0.0225)
    assert json.loads(campaign.filled_in_json())["schemes"] == {}


def test_defaults_of_preprocessing_are_those_of_the_stage(tmp_path: Path) -> None:
    settings = load(tmp_path, FEWEST).preprocessing.model_dump()
    assert {name: getattr(ShaftOptions(), name) for name in settings} == settings


def test_earliest_epoch_is_the_reference_where_none_says_so(tmp_path: Path) -> None:
    later_first = edited("2026-03-11", "2024-03-11", edited("reference = true\n", ""))
    assert load(tmp_path, later_first).reference_epoch.id == "e2"


def test_marked_epoch_is_the_reference_although_another_is_earlier(tmp_path: Path) -> None:
    assert load(tmp_path, edited("2026-03-11", "2024-03-11")).reference_epoch.id == "e1"


def test_control_may_be_the_source_of_a_reference(tmp_path: Path) -> None:
    campaign = load(tmp_path, edited('control = ["F", "paper"]', 'control = "total station"'))
    assert campaign.report.control == "total station"


def test_file_with_byte_order_mark_is_read(tmp_path: Path) -> None:
    file = tmp_path / "campaign.toml"
    file.write_bytes(b"\xef\xbb\xbf" + FEWEST.encode())
    assert load_campaign(file).structure.id == "pole"


@pytest.mark.parametrize("kind", KINDS)
def test_example_of_every_kind_is_a_valid_campaign(tmp_path: Path, kind: str) -> None:
    campaign = load(tmp_path, example_campaign(kind))
    assert campaign.structure.kind == kind


@pytest.mark.parametrize("kind", KINDS)
def test_what_an_example_comments_out_is_valid_too(tmp_path: Path, kind: str) -> None:
    whole = re.sub(r"^# (\[|[a-z_]+ = )", r"\1", example_campaign(kind), flags=re.MULTILINE)
    campaign = load(tmp_path, edited('registered = "2026-03/merged.laz"', 'registered = "m.laz"', whole))
    assert set(campaign.schemes) == {"G", "H"}
    assert campaign.limits.table == ("bre-digest-475" if kind in {"chimney", "tower"} else None)
    assert campaign.limits.kind == "in-service"


def test_every_kind_can_be_isolated() -> None:
    assert set(get_args(Kind)) == set(kinds.KINDS)


def test_axes_neu_turn_positions_into_east_north_up(tmp_path: Path) -> None:
    text = edited('axes = "ENU"', 'axes = "NEU"', edited("[0.0, 0.0, 0.0]", "[100.0, 10.0, 1.0]"))
    frame = load(tmp_path, text).frame
    assert frame.site_position_m((103.0, 12.0, 1.5)) == (2.0, 3.0, 0.5)
    assert frame.origin_enu_m == (10.0, 100.0, 1.0)


@pytest.mark.parametrize("written", ['"EPSG:32650"', '"epsg:32650"', "32650"])
def test_epsg_code_is_kept_in_one_spelling(tmp_path: Path, written: str) -> None:
    assert load(tmp_path, edited('"local"', written)).frame.horizontal == "EPSG:32650"


def test_digest_does_not_change_with_folder_comments_or_order(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    reordered = edited('id = "chimney-01"\n', "").replace(
        'kind = "chimney"', 'kind = "chimney"\nid = "chimney-01" # !'
    )
    assert load(tmp_path, WHOLE).digest == load(tmp_path / "other", reordered).digest


def test_digest_changes_with_any_value(tmp_path: Path) -> None:
    assert load(tmp_path, WHOLE).digest != load(tmp_path, edited("271.3", "271.4")).digest


def test_filled_in_settings_are_a_campaign_again(tmp_path: Path) -> None:
    campaign = load(tmp_path, WHOLE)
    again = type(campaign).model_validate_json(campaign.filled_in_json())
    assert again.digest == campaign.digest


def test_scan_in_a_named_root_is_allowed(tmp_path: Path) -> None:
    (tmp_path / "archive").mkdir()
    (tmp_path / "here").mkdir()
    text = edited("cloud.laz", "../archive/cloud.laz", FEWEST) + '[files]\nroots = ["../archive"]\n'
    campaign = load(tmp_path / "here", text)
    assert campaign.scan_path("../archive/cloud.laz") == (tmp_path / "archive" / "cloud.laz").resolve()


def test_link_that_leaves_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "secret.laz").write_bytes(b"x")
    (tmp_path / "here" / "cloud.laz").symlink_to(tmp_path / "secret.laz")
    with pytest.raises(InputError, match=r"'cloud\.laz' lies outside the allowed folders"):
        load(tmp_path / "here", FEWEST)
