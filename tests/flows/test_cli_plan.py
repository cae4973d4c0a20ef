"""``tiltwatch plan``: the prediction on the screen and for programs, and its exit codes."""

from pathlib import Path

import pytest

from tests.flows.calls import call
from tests.unit.settings.campaign_text import WHOLE
from tests.unit.settings.test_plan_file import PLAN

ALL_KEYS = {
    "ok",
    "sigma_worst_m",
    "smallest_detectable_m",
    "variance_shares",
    "coverage",
    "stations",
    "one_more",
}


@pytest.fixture
def plan_file(tmp_path: Path) -> Path:
    file = tmp_path / "plan.toml"
    file.write_text(PLAN, encoding="utf-8")
    return file


def test_a_plan_is_told_to_programs(capsys: pytest.CaptureFixture[str], plan_file: Path) -> None:
    called = call(capsys, "plan", plan_file, "--json")
    found = called.answer
    assert (called.code, found["ok"], called.err) == (0, True, "")
    assert set(found) >= ALL_KEYS
    assert found["smallest_detectable_m"] == pytest.approx(3.7257 * 2.0**0.5 * found["sigma_worst_m"])
    assert found["least_covered_deg"] == 360.0
    assert found["one_more"]["gain"] > 0.0


def test_a_plan_is_told_to_people(capsys: pytest.CaptureFixture[str], plan_file: Path) -> None:
    called = call(capsys, "plan", plan_file, "--points", "1000000")
    assert called.code == 0
    assert "limited by the level of the stations: more stations or a better compensator help" in called.out
    assert called.out.count("  ST0") == 4
    assert "1,000,000" in called.out
    assert "one more station: best at azimuth" in called.out


def test_the_stations_of_an_epoch_are_taken(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "campaign.toml"
    file.write_text(WHOLE, encoding="utf-8")
    found = call(capsys, "plan", file, "--epoch", "e1", "--json").answer
    assert [station["station"] for station in found["stations"]] == ["ST01", "ST02"]
    assert found["least_covered_deg"] < 300.0


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["--epoch", "e1"], 2, "has no epochs"),
        (["--points", "3"], 2, "--points needs at least 10, got 3"),
    ],
)
def test_wrong_usage_is_told(
    capsys: pytest.CaptureFixture[str], plan_file: Path, words: list[str], code: int, message: str
) -> None:
    called = call(capsys, "plan", plan_file, *words)
    assert (called.code, called.out) == (code, "")
    assert message in called.err


def test_an_unknown_epoch_is_wrong_usage(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "campaign.toml"
    file.write_text(WHOLE, encoding="utf-8")
    called = call(capsys, "plan", file, "--epoch", "e9")
    assert called.code == 2
    assert "unknown epoch 'e9'; known: e1, e2" in called.err


def test_a_survey_that_sees_nothing_is_bad_input(capsys: pytest.CaptureFixture[str], plan_file: Path) -> None:
    plan_file.write_text(PLAN + "reach_m = 50.0\n", encoding="utf-8")
    called = call(capsys, "plan", plan_file, "--json")
    assert (called.code, called.answer["ok"]) == (3, False)
    assert "needed a station that sees the shaft, none does; move or add stations" in called.err


@pytest.mark.parametrize("kind", ["chimney", "tower", "silo", "tank", "mast", "column", "stem"])
def test_every_example_of_a_plan_can_be_predicted(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, kind: str
) -> None:
    file = tmp_path / "plan.toml"
    assert call(capsys, "init", kind, file, "--plan").code == 0
    # comments become settings: the other ways to state things are sound, too
    text = file.read_text(encoding="utf-8").replace("# hidden", "hidden").replace("# form_m", "form_m")
    file.write_text(text, encoding="utf-8")
    found = call(capsys, "plan", file, "--json").answer
    assert found["ok"]
    assert found["primary"] == ["S", "surface"]
    assert found["variance_shares"]["form"] > 0.0
    assert found["least_covered_deg"] == 310.0


def test_a_square_tower_has_no_example_of_a_plan(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    called = call(capsys, "init", "square-tower", tmp_path / "plan.toml", "--plan")
    assert (called.code, list(tmp_path.iterdir())) == (2, [])
