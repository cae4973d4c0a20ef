"""``tiltwatch limits``: every table with its papers, and what it allows."""

import json
from pathlib import Path

import pytest

from tasks.limits import TABLES
from tests.flows.calls import call

OWN = """
[[limits]]
name = "own"
version = 2
valid_from = 2026-01-01
kind = "measurement"
document = "our rules"
edition = "2026"
clause = "7"
source = "our file"
verified_by = "A. Engineer"
ratio = 0.0005
sigmas = 2.0
[[limits]]
name = "own"
kind = "measurement"
document = "our rules"
source = "our file"
points_m = [[10.0, 0.01], [20.0, 0.02]]
"""


def test_every_shipped_table_is_listed_with_its_papers(capsys: pytest.CaptureFixture[str]) -> None:
    told = call(capsys, "limits")
    assert told.code == 0
    for table in TABLES.values():
        for what in (table.name, table.document, table.clause, table.source, table.note):
            assert what in told.out
    assert told.out.count("verified by: nobody: not compared with the document") == len(TABLES)


def test_the_value_at_a_height_or_why_there_is_none(capsys: pytest.CaptureFixture[str]) -> None:
    answer = json.loads(call(capsys, "limits", "--height-m", "102", "--json").out)
    values = {limit["name"]: limit["allowable_m"] for limit in answer["limits"]}
    assert values["gb50078-concrete-quoted"] == pytest.approx(0.0605)
    assert values["bre-digest-475"] == pytest.approx(0.408)
    low = call(capsys, "limits", "gb50078-concrete-quoted", "--height-m", "80").out
    assert "at 80 m: no limit; gb50078-concrete-quoted: the table holds from 100 m to 120 m" in low


def test_a_users_file_is_listed_with_its_versions(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(OWN, encoding="utf-8")
    out = call(capsys, "limits", "own", "--file", file, "--height-m", "15").out
    assert "own, version 2, for epochs from 2026-01-01 on" in out
    assert "own, version 1\n" in out
    assert "judges: 2 sigma of the deviation, not the deviation" in out
    assert "verified by: A. Engineer" in out
    assert "at 15 m: 7.5 mm" in out
    assert "at 15 m: 15.0 mm" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("bre",), "unknown table of limits 'bre'; known: aci117-general, bre-digest-475, gb50078"),
        (("--height-m", "-3"), "--height-m needs a height above 0, got -3"),
    ],
)
def test_what_is_asked_wrongly_is_said(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], message: str
) -> None:
    told = call(capsys, "limits", *arguments)
    assert told.code == 2
    assert message in told.err
