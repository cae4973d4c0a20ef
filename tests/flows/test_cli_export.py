"""Geometry from the command line: in the campaign's own coordinates, whatever the order of its axes."""

import csv
import json
from pathlib import Path

import ezdxf.filemanagement
import pytest

from storage.views import tilt_rows
from tests.flows.calls import call
from tests.flows.stored_campaign import Stored, publish, stored_campaign
from tests.flows.test_cli_stored import FAIL


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    made = stored_campaign(tmp_path)
    publish(made, "e1", 0, FAIL)
    publish(made, "e2", 1, FAIL, moved_m=0.05)
    return made


def north_first(stored: Stored) -> None:
    """North comes first in the campaign, and its origin is not the foot."""
    text = stored.file.read_text(encoding="utf-8")
    assert 'axes = "ENU"' in text
    frame = 'axes = "NEU"\nhorizontal = "EPSG:32650"\norigin_m = [20.0, 40.0, 5.0]'
    kept = [line for line in text.splitlines() if not line.startswith(("horizontal", "origin_m"))]
    stored.file.write_text("\n".join(kept).replace('axes = "ENU"', frame), encoding="utf-8")


def test_axis_lies_where_the_campaign_states_its_positions(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    north_first(stored)
    out = stored.file.parent / "axis.dxf"
    called = call(capsys, "export", stored.file, "axis", "--format", "dxf", "--out", out, "--json")
    assert (called.code, called.answer["epoch"], called.answer["count"]) == (0, "e2", 5)
    assert "EPSG:32650" in called.answer["coordinates"]
    row = next(row for row in tilt_rows(stored.workspace, "chimney-01", "e2") if row.scheme == "A")
    (line,) = ezdxf.filemanagement.readfile(out).modelspace().query('LINE[layer=="axis_A_paper"]')
    foot = (40.0 + row.base_east_m, 20.0 + row.base_north_m, 5.0)
    assert tuple(line.dxf.start) == pytest.approx(foot)


def test_epoch_and_scheme_are_those_that_were_asked_for(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    out = stored.file.parent / "axis.csv"
    words = ("axis", "--format", "csv", "--epoch", "e1", "--scheme", "F", "--method", "paper", "--out", out)
    called = call(capsys, "export", stored.file, *words)
    assert called.code == 0
    assert (
        "axis of epoch e1: 5 shapes; x east, y north, z up in metres, a local frame of the site" in called.err
    )
    with out.open(encoding="utf-8", newline="") as lines:
        assert {(row["epoch"], row["scheme"]) for row in csv.DictReader(lines)} == {("e1", "F")}


def test_geometry_goes_to_stdout_where_no_file_is_named(
    capfdbinary: pytest.CaptureFixture[bytes], stored: Stored
) -> None:
    from flows.cli import main  # noqa: PLC0415 (stdout is captured as bytes here)

    assert main(["export", str(stored.file), "axis", "--format", "geojson"]) == 0
    captured = capfdbinary.readouterr()
    assert len(json.loads(captured.out)["features"]) == 5
    assert b"warning: the frame is local" in captured.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["axis", "--format", "las"], "axis cannot be written as 'las'; known: csv, dxf, geojson, parquet"),
        (["cloud", "--format", "dxf"], "cloud cannot be written as 'dxf'; known: csv, las, laz, parquet"),
        (
            ["axis", "--format", "csv", "--epoch", "e9"],
            "unknown epoch 'e9' of chimney-01; in the workspace: e1, e2",
        ),
        (
            ["tilt", "--format", "csv", "--epoch", "e1"],
            "choose geometry (axis, slice-circles, cloud); a view is written",
        ),
        (["axles", "--format", "csv"], "; geometry: axis, slice-circles, cloud"),
    ],
)
def test_words_that_do_not_fit_are_answered_with_those_that_do(
    capsys: pytest.CaptureFixture[str], stored: Stored, words: list[str], message: str
) -> None:
    called = call(capsys, "export", stored.file, *words)
    assert called.code == 2
    assert message in called.err
    assert "Traceback" not in called.err
