"""Runs that are refused before anything starts: bad campaign files, unknown names, places that are no workspace."""

import os
from pathlib import Path

import pytest

from tests.faults.sites import FIRST, SECOND, Site
from tests.flows.campaigns import replace_text


@pytest.fixture
def site(tmp_path: Path) -> Site:
    """A campaign file whose scans are never looked at, because it is refused before."""
    site = Site(tmp_path)
    head = (
        'schema_version = 1\n[structure]\nid = "silo"\nkind = "silo"\nheight_m = 3.0\nshaft_z_m = [0.0, 3.0]\n'
        'radius_m = [1.0, 1.0]\n[frame]\naxes = "ENU"\n[instrument]\n'
    )
    station = "position_m = [20.0, 0.0, 1.0]\nheading_deg = 0.0\n"
    epochs = [
        f'[[epochs]]\nid = "{epoch}"\ntime = {epoch}-14T06:00:00Z\n'
        + "".join(
            f'[[epochs.stations]]\nid = "{name}"\nscan = "{epoch}/{name}.laz"\n{station}'
            for name in ("S1", "S2")
        )
        for epoch in (FIRST, SECOND)
    ]
    site.file.write_text(head + "".join(epochs), encoding="utf-8")
    return site


@pytest.mark.parametrize(
    ("old", "new", "errors"),
    [
        (
            f'scan = "{SECOND}/S2.laz"',
            f'scan = "{SECOND}/S1.laz"',
            [
                f"scan '{SECOND}/S1.laz' is already used by epochs[{SECOND}].stations[S1].scan; name each scan once"
            ],
        ),
        (
            f'scan = "{SECOND}/S2.laz"',
            f'scan = "{FIRST}/../{FIRST}/S2.laz"',
            [f"is already used by epochs[{FIRST}].stations[S2].scan; name each scan once"],
        ),
        (
            f'id = "{SECOND}"',
            f'id = "{FIRST}"',
            [f"epoch id '{FIRST}' is taken by epochs[#1 {FIRST}].id; choose another"],
        ),
        (
            "[instrument]",
            "[schemes.G]\ninterval_m = 5.0\n[instrument]",
            ["schemes.G.interval_m: 5 m leaves 1 slice on the 3 m of shaft_z_m; an axis needs at least 2"],
        ),
        (
            "[instrument]",
            "[schemes.G]\nheights_m = [1.0]\n[instrument]",
            ["schemes.G.heights_m: needs at least 2 heights for an axis, got 1; add another height"],
        ),
    ],
    ids=["scan twice", "scan twice by another spelling", "epoch twice", "one slice", "one height"],
)
def test_a_bad_campaign_file_is_refused_with_place_fault_and_way_out(
    site: Site, old: str, new: str, errors: list[str]
) -> None:
    replace_text(site.file, old, new, 1)
    told = site.run("--json")
    assert (told.code, told.answer["ok"], told.answer["exit_code"]) == (3, False, 3)
    assert [line for line in told.err.splitlines()[1:] if not line.startswith(f"error: {site.file}: ")] == []
    for error in errors:
        assert any(error in line for line in told.answer["errors"]), told.answer["errors"]
    assert not site.workspace.exists()


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (("--scheme", "G"), "unknown slicing scheme 'G'; known: A, B, C, D, E, F, S"),
        (("--epoch", "2031-01"), f"unknown epoch '2031-01'; known: {FIRST}, {SECOND}"),
    ],
    ids=["scheme", "epoch"],
)
def test_unknown_names_are_wrong_usage(site: Site, words: tuple[str, str], error: str) -> None:
    told = site.run(*words)
    assert (told.code, told.out, told.err.splitlines()[1:]) == (2, "", [f"error: {error}"])
    assert not site.workspace.exists()


def test_a_workspace_that_is_a_file_is_refused(site: Site) -> None:
    site.workspace.write_text("mine", encoding="utf-8")
    told = site.run()
    assert told.code == 3
    assert told.err.endswith(
        f"error: workspace {site.workspace} needs a folder; it is a file: choose another path\n"
    )
    assert site.workspace.read_text("utf-8") == "mine"


def test_a_workspace_below_a_file_is_refused(site: Site) -> None:
    told = site.run(workspace=site.file / "ws")
    assert told.code == 3
    assert f"error: cannot write {site.file / 'ws'}" in told.err


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_workspace_that_cannot_be_written_is_refused(site: Site) -> None:
    site.workspace.mkdir(mode=0o500)
    told = site.run()
    assert told.code == 3
    assert f"error: cannot write {site.workspace}" in told.err
    assert "the folder must be writable" in told.err
