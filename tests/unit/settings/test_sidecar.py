"""The sidecar of a scan that comes through an inbox."""

from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.settings.sidecar import load_sidecar, station_of

SOUND = """\
epoch = "2026-03"
time = 2026-03-11T06:00:00+08:00
position_m = [231.4, -12.9, 1.61]
heading_deg = 271.3
"""


def sidecar_file(folder: Path, text: str) -> Path:
    path = folder / "ST01.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_sidecar_is_the_table_of_its_station(tmp_path: Path) -> None:
    sidecar = load_sidecar(sidecar_file(tmp_path, SOUND), "ST01.laz")
    assert station_of(sidecar, "here/ST01.laz") == {
        "id": "ST01",
        "scan": "here/ST01.laz",
        "position_m": (231.4, -12.9, 1.61),
        "heading_deg": 271.3,
    }


def test_the_station_has_the_name_of_the_scan_unless_it_says_another(tmp_path: Path) -> None:
    assert load_sidecar(sidecar_file(tmp_path, SOUND), "ST01.laz").id == "ST01"
    assert load_sidecar(sidecar_file(tmp_path, SOUND + 'id = "north"\n'), "ST01.laz").id == "north"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (SOUND.replace("heading_deg", "heading_dge"), "heading_dge: unknown key; did you mean 'heading_deg'"),
        (SOUND.replace('epoch = "2026-03"\n', ""), "epoch: is required"),
        (SOUND.replace("+08:00", ""), "time: needs an offset from UTC"),
        (SOUND + 'scan = "ST02.laz"\n', "scan: names 'ST02.laz', the file beside it is 'ST01.laz'"),
        (SOUND + 'of = ["ST02", "ST03"]\n', "of: lists no station 'ST01'"),
        (SOUND + 'of = ["ST01", "st01"]\n', "of: names a station twice"),
        (SOUND + 'sha256 = "abc"\n', "sha256: "),
        (SOUND + 'pose = "file"\n', 'pose = "file" takes position and heading from the scan file'),
        (SOUND.replace('"2026-03"', '"../x"'), "epoch: needs 1 to 64 letters"),
        ("epoch = ", "invalid value"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(InputError) as caught:
        load_sidecar(sidecar_file(tmp_path, text), "ST01.laz")
    assert "ST01.toml: " in str(caught.value)
    assert told in str(caught.value)
