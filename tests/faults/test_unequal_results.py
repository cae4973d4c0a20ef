"""What stands in the record when a later run is worse, partial, or finds the record damaged."""

import pytest

from storage.tables import table_path
from storage.workspace import Workspace
from tests.faults.sites import FIRST, SECOND, Site, state_of
from tests.flows.calls import call
from tests.flows.campaigns import STRUCTURE, replace_text, rows

THIN = "[schemes.G]\ninterval_m = 40.0\nthickness_m = 0.001\n"
"""Slices of 1 mm hold too few of so few points for method paper to find an axis."""


def tables_of(site: Site, epoch: str) -> dict[str, list]:  # type: ignore[type-arg]
    names = ("epochs", "stations", "slices", "tilt", "schemes", "accuracy")
    return {name: rows(site.workspace, name, epoch) for name in names}


def test_a_good_result_stays_when_its_scan_goes_missing_and_the_note_says_so(published: Site) -> None:
    before = tables_of(published, SECOND)
    published.scan("ST02").unlink()
    again = published.run("--epoch", SECOND, "--scheme", "A", "--json")
    assert again.code == 3
    told = state_of(again, SECOND)
    old_run = before["epochs"][0].run
    assert told["state"] == "degraded"
    assert told["notes"][-1] == f"the result of run {old_run} (ok) stays published; this run was degraded"
    assert f"error: {SECOND}: station ST02: {published.scan('ST02')}: no such file" in again.err
    assert tables_of(published, SECOND) == before
    assert published.states() == {FIRST: "ok", SECOND: "ok"}


def test_a_better_result_replaces_a_worse_one(unpublished: Site) -> None:
    away = unpublished.folder / "away.laz"
    unpublished.scan("ST02").rename(away)
    assert unpublished.run("--epoch", SECOND, "--scheme", "A").code == 3
    assert unpublished.states() == {SECOND: "degraded"}
    away.rename(unpublished.scan("ST02"))
    assert unpublished.run("--epoch", SECOND).code == 0
    assert unpublished.states() == {SECOND: "ok"}
    assert unpublished.stations(SECOND)["ST02"].state == "ok"


def test_one_scheme_alone_keeps_the_rows_of_the_others(published: Site) -> None:
    before = tables_of(published, SECOND)
    again = published.run("--scheme", "B", "--epoch", SECOND, "--json")
    assert (again.code, state_of(again, SECOND)["state"]) == (0, "ok")
    assert tables_of(published, SECOND) == before


def test_a_new_scheme_alone_is_put_beside_the_others_and_compared_with_the_control(published: Site) -> None:
    replace_text(published.file, 'control = ["F", "paper"]', 'control = ["A", "robust"]')
    published.append("[schemes.G]\ninterval_m = 2.5\n")
    before = published.schemes(SECOND)
    assert published.run("--scheme", "G", "--epoch", SECOND).code == 0
    after = published.schemes(SECOND)
    assert after.keys() - before.keys() == {"G/paper", "G/robust"}
    assert {label: after[label] for label in before} == before
    compared = {f"{row.scheme}/{row.method}" for row in rows(published.workspace, "accuracy", SECOND)}
    assert compared == published.tilts(SECOND).keys() - {"A/robust"}


def test_a_scheme_without_axis_does_not_make_a_complete_epoch_a_failed_one(published: Site) -> None:
    published.append(THIN)
    again = published.run("--scheme", "G", "--epoch", SECOND, "--json")
    assert (again.code, state_of(again, SECOND)["state"]) == (0, "ok")
    assert published.schemes(SECOND)["G/paper"].state == "failed"
    assert published.schemes(SECOND)["A/robust"].state == "ok"


def test_schemes_that_rest_on_other_points_are_left_out_and_the_note_says_so(published: Site) -> None:
    replace_text(published.file, "[limits]", "[preprocessing]\nvoxel_m = 0.01\n[limits]")
    again = published.run("--scheme", "B", "--epoch", SECOND, "--json")
    assert {row.scheme for row in published.schemes(SECOND).values()} == {"B"}
    assert state_of(again, SECOND)["notes"][-1] == (
        "schemes A, C, D, E, F, S rested on other scans, poses or points and are left out; run without --scheme"
    )


def test_a_primary_scheme_without_axis_degrades_the_epoch(
    capsys: pytest.CaptureFixture[str], unpublished: Site
) -> None:
    unpublished.append(THIN)
    replace_text(unpublished.file, 'primary = ["S", "surface"]', 'primary = ["G", "paper"]')
    told = unpublished.run("--epoch", SECOND, "--fail-on", "quality", "--json")
    assert told.code == 4
    assert state_of(told, SECOND)["state"] == "degraded"
    scheme = unpublished.schemes(SECOND)["G/paper"]
    assert (scheme.state, scheme.n_slices) == ("failed", 3)
    assert scheme.n_centres < 2
    assert str(scheme.reason).startswith("needs at least 2 centres, got ")
    assert unpublished.epoch(SECOND).reason == f"the primary G/paper gave no axis: {scheme.reason}"
    status = call(capsys, "status", unpublished.file, "--workspace", unpublished.workspace)
    assert status.code == 4
    assert "the primary G/paper gave no axis" in status.out


def test_an_epoch_without_any_axis_has_failed_and_says_why(unpublished: Site) -> None:
    # F is measured by method paper alone, and its 1 cm slices of so few points give no contour
    told = unpublished.run("--epoch", FIRST, "--scheme", "F", "--json")
    assert (told.code, state_of(told, FIRST)["state"]) == (3, "failed")
    expected = "no scheme gave an axis; F/paper: needs at least 2 centres, got "
    assert str(unpublished.epoch(FIRST).reason).startswith(expected)


@pytest.mark.parametrize("table", ["epochs", "stations"])
def test_a_damaged_published_table_is_made_anew(published: Site, table: str) -> None:
    before = tables_of(published, SECOND)
    path = table_path(Workspace(published.workspace), table, STRUCTURE, SECOND)
    path.write_bytes(path.read_bytes()[:200])
    again = published.run("--epoch", SECOND, "--json")
    assert (again.code, state_of(again, SECOND)["state"]) == (0, "ok")
    after = tables_of(published, SECOND)
    assert {name: after[name] for name in after if name != "epochs"} == {
        name: before[name] for name in before if name != "epochs"
    }
