"""Epochs that came through an inbox, beside those of the campaign file."""

import tomllib
from datetime import UTC, datetime
from pathlib import Path

import pytest

from storage.errors import InputError
from storage.intake import write_intake
from storage.workspace import Workspace
from tasks.settings import load_campaign
from tasks.settings.intake import Intake, intake_text, load_awaiting, load_with_intake, read_intakes
from tests.unit.settings.campaign_text import WHOLE

TIME = datetime(2027, 3, 1, 6, 0, tzinfo=UTC)
LISTED = """\
[[epochs]]
id = "e3"
time = 2027-03-01T06:00:00Z
[[epochs.stations]]
id = "ST01"
scan = "e3/ST01.laz"
heading_deg = 10.0
"""


def intake_of(epoch: str = "e3", station: str = "ST01", **changes: object) -> Intake:
    table = {
        "epoch": epoch,
        "time": TIME,
        "first_arrival": TIME,
        "complete": "stations",
        "stations": [
            {
                "id": station,
                "scan": f"in/{station}.laz",
                "position_m": [231.4, -12.9, 1.61],
                "heading_deg": 271.3,
            }
        ],
    }
    return Intake.model_validate({**table, **changes})


def site(folder: Path, text: str, *intakes: Intake) -> tuple[Path, Path]:
    file, workspace = folder / "campaign.toml", folder / "workspace"
    file.write_text(text, encoding="utf-8")
    for intake in intakes:
        write_intake(Workspace(workspace), "chimney-01", intake.epoch, intake_text(intake))
    return file, workspace


def test_an_epoch_of_the_inbox_stands_beside_those_of_the_file(tmp_path: Path) -> None:
    file, workspace = site(tmp_path, WHOLE, intake_of())
    campaign = load_with_intake(file, workspace)
    assert [epoch.id for epoch in campaign.epochs] == ["e1", "e2", "e3"]
    assert campaign.epochs[2].stations[0].heading_deg == 271.3
    assert campaign.digest != load_campaign(file).digest


def test_without_a_workspace_the_campaign_is_that_of_its_file(tmp_path: Path) -> None:
    file, workspace = site(tmp_path, WHOLE)
    assert load_with_intake(file, workspace) == load_campaign(file)
    assert load_with_intake(file, workspace).digest == load_campaign(file).digest


def test_an_epoch_that_still_arrives_is_not_seen(tmp_path: Path) -> None:
    file, workspace = site(tmp_path, WHOLE, intake_of(complete=None))
    assert load_with_intake(file, workspace).epoch("e3") is None
    assert read_intakes(workspace, "chimney-01")[0].arrived == ("ST01",)


def test_a_campaign_may_have_no_epochs_but_those_of_the_inbox(tmp_path: Path) -> None:
    head = WHOLE[: WHOLE.index("[[epochs]]")]
    file, workspace = site(tmp_path, head, intake_of())
    assert load_awaiting(file).epochs == ()
    assert load_with_intake(file, workspace).reference_epoch.id == "e3"


def test_an_epoch_that_the_file_lists_beforehand_is_filled_in_and_its_own_words_count(tmp_path: Path) -> None:
    text = WHOLE.replace("[schemes.G]", LISTED + "[schemes.G]")
    file, workspace = site(tmp_path, text, intake_of())
    (station,) = load_with_intake(file, workspace).epochs[2].stations
    assert (station.scan, station.heading_deg) == ("in/ST01.laz", 10.0)
    assert station.position_m == (231.4, -12.9, 1.61)
    (tmp_path / "e3").mkdir()
    (tmp_path / "e3" / "ST01.laz").write_bytes(b"the user's own")
    assert load_with_intake(file, workspace).epochs[2].stations[0].scan == "e3/ST01.laz"


def test_a_station_that_the_file_does_not_list_is_a_contradiction(tmp_path: Path) -> None:
    text = WHOLE.replace("[schemes.G]", LISTED + "[schemes.G]")
    file, workspace = site(tmp_path, text, intake_of(station="ST09"))
    with pytest.raises(InputError, match=r"epochs\[e3\]: station ST09 came for it through the inbox"):
        load_with_intake(file, workspace)


def test_a_damaged_intake_names_itself(tmp_path: Path) -> None:
    file, workspace = site(tmp_path, WHOLE, intake_of())
    (damaged,) = (workspace / "intake").rglob("*.toml")
    damaged.write_text("epoch = 5\n")
    with pytest.raises(InputError, match=r"e3\.toml: epoch: needs a text"):
        load_with_intake(file, workspace)


@pytest.mark.parametrize("name", ['quo"te', "back\\slash", "naïve \x7f \t"])
def test_what_is_written_is_read_again(name: str) -> None:
    arrival = {"station": "ST01", "name": name, "sha256": "0" * 64, "size_bytes": 1, "arrived": TIME}
    intake = intake_of(arrivals=[arrival], expected=["ST01", "ST02"])
    assert Intake.model_validate(tomllib.loads(intake_text(intake))) == intake
