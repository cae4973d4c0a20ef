"""Settings files that were written to do harm, or by a program gone wrong: refused soon, in words that fit a line."""

import time
from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.settings import load_campaign
from tasks.settings.limit_file import load_limits
from tasks.settings.problems import MOST_PROBLEMS
from tasks.settings.sidecar import load_sidecar, station_of
from tasks.settings.toml_text import toml_text
from tests.unit.settings.campaign_text import FEWEST, WHOLE, edited, load
from tests.unit.settings.test_sidecar import SOUND, sidecar_file

SOON_S = 5.0
"""Of processor time; what is quadratic takes minutes."""

NAME = 'name = "Heritage chimney"'
HEIGHT = "height_m = 102.0"


def _refusal(folder: Path, text: str) -> str:
    start = time.process_time()
    with pytest.raises(InputError) as caught:
        load(folder, text)
    assert time.process_time() - start < SOON_S
    return str(caught.value)


@pytest.mark.parametrize("number", ["9" * 5000, "0x" + "f" * 5000, "-" + "9" * 30, "9223372036854775808"])
def test_a_whole_number_beyond_64_bits_is_refused(tmp_path: Path, number: str) -> None:
    assert "whole number of" in _refusal(tmp_path, edited(HEIGHT, f"height_m = {number}"))


@pytest.mark.parametrize("number", ["nan", "inf", "-inf", "1e999", "1e308"])
def test_a_height_that_is_no_height_is_refused(tmp_path: Path, number: str) -> None:
    assert "structure.height_m: " in _refusal(tmp_path, edited(HEIGHT, f"height_m = {number}"))


@pytest.mark.parametrize(
    "time_text",
    [
        "0001-01-01T00:00:00Z",
        "9999-12-31T23:59:59Z",
        "2025-02-30T00:00:00Z",
        "2025-03-14T25:00:00Z",
        "2025-03-14T06:00:00+24:00",
        "2024-12-31T23:59:60Z",
        "2025-03-14T06:00:00",
    ],
)
def test_a_time_out_of_range_is_refused(tmp_path: Path, time_text: str) -> None:
    text = edited("time = 2025-03-14T06:00:00+08:00", f"time = {time_text}")
    assert "campaign.toml: " in _refusal(tmp_path, text)


@pytest.mark.parametrize(
    "deep",
    [
        "a" + ".a" * 100_000 + " = 1\n",
        "[a" + ".a" * 100_000 + "]\n",
        '"a"' + ' . "a"' * 50_000 + " = 1\n",
        "x = {a" + ".a" * 50_000 + " = 1}\n",
        "x = " + "[" * 100_000 + "]" * 100_000 + "\n",
        "x = " + "{a = " * 900 + "1" + "}" * 900 + "\n",
        "x = " + "[" * 60 + "]" * 60 + "\n",
    ],
    ids=["dotted", "table", "quoted", "inline", "array", "tables in tables", "60 arrays"],
)
def test_depth_is_refused_before_it_takes_time(tmp_path: Path, deep: str) -> None:
    assert "deep" in _refusal(tmp_path, deep + WHOLE)


def test_arrays_of_many_numbers_and_texts_with_dots_are_not_taken_for_depth(tmp_path: Path) -> None:
    assert load(tmp_path, edited(NAME, f'name = "{"1.5. " * 15}"')).structure.name.startswith("1.5. 1.5.")  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "escape", ["\\u001b[31m", "\\u0000", "\\r", "\\u202e", "\\u007f", "\\u2028", "\\u009b"]
)
def test_a_name_with_control_characters_is_refused_and_not_repeated(tmp_path: Path, escape: str) -> None:
    told = _refusal(tmp_path, edited(NAME, f'name = "a{escape}b"'))
    assert "control character" in told
    assert told.isprintable()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (NAME, 'name = "a\\nerror: all is lost"'),
        ('scan = "e1/ST01.laz"', 'scan = "e1/ST\\n01.laz"'),
        ('scan = "e1/ST01.laz"', 'scan = "e1/ST\\u001b]0;x\\u0007.laz"'),
        ('source = "total station"', 'source = "total\\tstation"'),
        ("[limits]", '[limits]\nfile = "own\\n.toml"'),
        ("[structure]", '"a\\nb" = 1\n[structure]'),
        ("[structure]", '"\\u001b[2J" = 1\n[structure]'),
    ],
)
def test_what_stands_in_a_line_cannot_begin_another(tmp_path: Path, old: str, new: str) -> None:
    for line in _refusal(tmp_path, edited(old, new)).splitlines():
        assert "campaign.toml: " in line
        assert line.isprintable()


@pytest.mark.parametrize(
    "name", ["<script>alert(1)</script>", "'; drop table epochs; --", "--help", "NUL", "Kamin\u00a0Süd"]
)
def test_a_name_for_people_may_hold_what_is_dangerous_only_elsewhere(tmp_path: Path, name: str) -> None:
    assert load(tmp_path, edited(NAME, f'name = "{name}"')).structure.name == name


@pytest.mark.parametrize(
    "id_", ["-rf", "--help", "NUL", "con.txt", "LPT1", "a/b", "..", "a b", "<b>", "a'b", "ST01.", "e\\u0301"]
)
def test_an_id_that_is_no_name_of_a_file_is_refused(tmp_path: Path, id_: str) -> None:
    assert "epochs[" in _refusal(tmp_path, edited('id = "e1"', f'id = "{id_}"'))


@pytest.mark.parametrize(
    "path", ["../x.laz", "e1/../../x.laz", "/etc/passwd", "//etc/passwd", "e1/./../../../etc/passwd"]
)
def test_a_path_that_climbs_out_is_refused(tmp_path: Path, path: str) -> None:
    (tmp_path / "e1").mkdir()
    assert "lies outside the allowed folders" in _refusal(tmp_path, edited("e1/ST01.laz", path))


@pytest.mark.parametrize("depth", [1, 2])
def test_a_folder_that_is_a_link_out_is_refused(tmp_path: Path, depth: int) -> None:
    (tmp_path / "other" / "deep").mkdir(parents=True)
    (tmp_path / "here").mkdir()
    target = tmp_path / "other" if depth == 1 else Path("../other/deep")
    (tmp_path / "here" / "e1").symlink_to(target, target_is_directory=True)
    assert "lies outside the allowed folders" in _refusal(tmp_path / "here", WHOLE)


def test_a_link_to_itself_is_refused(tmp_path: Path) -> None:
    (tmp_path / "cloud.laz").symlink_to("cloud.laz")
    assert "cannot be followed" in _refusal(tmp_path, FEWEST)


def test_a_campaign_file_of_100_mb_is_refused_unread(tmp_path: Path) -> None:
    file = tmp_path / "campaign.toml"
    with file.open("wb") as sparse:
        sparse.truncate(100_000_000)
    with pytest.raises(InputError, match="is too large to be a campaign file"):
        load_campaign(file)


def test_of_many_problems_the_first_are_told(tmp_path: Path) -> None:
    told = _refusal(tmp_path, "".join(f"unknown{k} = 1\n" for k in range(30_000)) + WHOLE).splitlines()
    assert len(told) <= 2 * MOST_PROBLEMS
    assert any("29900 more problems" in line for line in told)


def test_a_sidecar_as_large_as_a_campaign_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is too large to be a sidecar"):
        load_sidecar(sidecar_file(tmp_path, SOUND + "# " + "x" * 70_000), "ST01.laz")


def test_the_part_of_a_sidecar_cannot_write_other_keys(tmp_path: Path) -> None:
    hostile = 'a\\" ]\\n[[epochs]]\\nid = \\"x'
    with pytest.raises(InputError, match=r"part: needs one line of plain text"):
        load_sidecar(sidecar_file(tmp_path, SOUND + f'part = "{hostile}"\n'), "ST01.laz")
    quoted = load_sidecar(sidecar_file(tmp_path, SOUND + 'part = "a\\" # \\\\u0041"\n'), "ST01.laz")
    assert 'part = "a\\" # \\\\u0041"' in toml_text("a station", station_of(quoted, "ST01.laz"))


def test_limits_are_held_to_the_same(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(f"[[limits]]\nversion = {'9' * 5000}\n", encoding="utf-8")
    with pytest.raises(InputError, match="whole number"):
        load_limits(file)
