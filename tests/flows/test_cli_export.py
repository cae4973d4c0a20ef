"""Geometry from the command line: in the campaign's own coordinates, whatever the order of its axes."""

import csv
import json
from pathlib import Path

import ezdxf.filemanagement
import pytest

from storage.views import tilt_rows
from tests.flows.calls import call
from tests.flows.stored_campaign import Stored, publish, stored_campaign
from tests.flows.test_cli_report import processed
from tests.flows.test_cli_stored import FAIL


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    made = stored_campaign(tmp_path)
    process(made)
    return made


def process(stored: Stored) -> None:
    """Publish both epochs under the settings of the campaign file as it is."""
    settings = processed(stored)
    publish(stored, "e1", 0, FAIL, **settings)
    publish(stored, "e2", 1, FAIL, moved_m=0.05, **settings)


def north_first(stored: Stored) -> None:
    """North comes first in the campaign, and its origin is not the foot."""
    text = stored.file.read_text(encoding="utf-8")
    assert 'axes = "ENU"' in text
    frame = 'axes = "NEU"\nhorizontal = "EPSG:32650"\norigin_m = [20.0, 40.0, 5.0]'
    kept = [line for line in text.splitlines() if not line.startswith(("horizontal", "origin_m"))]
    stored.file.write_text("\n".join(kept).replace('axes = "ENU"', frame), encoding="utf-8")


def foot_of(stored: Stored) -> tuple[float, float, float]:
    row = next(row for row in tilt_rows(stored.workspace, "chimney-01", "e2") if row.scheme == "A")
    return (row.base_east_m, row.base_north_m, 0.0)


def start_of_axis(drawing: Path) -> tuple[float, ...]:
    (line,) = ezdxf.filemanagement.readfile(drawing).modelspace().query('LINE[layer=="axis_A_paper"]')
    return tuple(line.dxf.start)


def test_a_frame_that_was_written_since_does_not_move_what_was_processed(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    north_first(stored)
    out = stored.file.parent / "axis.dxf"
    called = call(capsys, "export", stored.file, "axis", "--format", "dxf", "--out", out, "--json")
    assert called.code == 0
    assert "a local frame of the site" in called.answer["coordinates"]
    assert "[frame] of the campaign file changed since epoch e2 was processed" in called.answer["warnings"][0]
    assert start_of_axis(out) == pytest.approx(foot_of(stored))


def test_an_epoch_whose_settings_are_gone_is_exported_while_the_campaign_file_has_them(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    for settings in stored.workspace.runs.glob("settings/*"):
        settings.unlink()
    words = ("export", stored.file, "axis", "--format", "csv", "--out", stored.file.parent / "axis.csv")
    assert call(capsys, *words).code == 0
    north_first(stored)
    called = call(capsys, *words)
    assert called.code == 3
    assert "the frame in which epoch e2 was processed is not known" in called.err
    assert "`tiltwatch run FILE --epoch e2` processes it again" in called.err


@pytest.mark.parametrize("code", [2263, 9999])
def test_a_system_that_is_no_frame_is_bad_input_for_export_and_check(
    capsys: pytest.CaptureFixture[str], stored: Stored, code: int
) -> None:
    north_first(stored)
    text = stored.file.read_text(encoding="utf-8")
    stored.file.write_text(text.replace("EPSG:32650", f"EPSG:{code}"), encoding="utf-8")
    process(stored)
    out = stored.file.parent / "axis.csv"
    called = call(capsys, "export", stored.file, "axis", "--format", "csv", "--out", out)
    assert (called.code, out.exists()) == (3, False)
    assert f"EPSG:{code} " in called.err
    assert f"frame.horizontal: EPSG:{code} " in call(capsys, "check", stored.file).err


def test_axis_lies_where_the_campaign_states_its_positions(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    north_first(stored)
    process(stored)
    out = stored.file.parent / "axis.dxf"
    called = call(capsys, "export", stored.file, "axis", "--format", "dxf", "--out", out, "--json")
    assert (called.code, called.answer["epoch"], called.answer["count"]) == (0, "e2", 5)
    assert "EPSG:32650" in called.answer["coordinates"]
    east, north, _ = foot_of(stored)
    assert start_of_axis(out) == pytest.approx((40.0 + east, 20.0 + north, 5.0))


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
