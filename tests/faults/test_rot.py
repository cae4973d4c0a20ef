"""Bit rot: the table of kinds of files is complete for a workspace that was run, and what was damaged is found."""

import shutil
from pathlib import Path

import pytest

from tests.faults.damages import DAMAGES
from tests.faults.kinds import KINDS, kinds_of, names_in
from tests.faults.rot import looks, run_case, sound_site
from tests.faults.sites import Site


def test_every_file_of_a_workspace_that_was_run_is_of_one_known_kind(published: Site) -> None:
    assert {
        name: len(kinds_of(name)) for name in names_in(published.workspace) if len(kinds_of(name)) != 1
    } == {}


@pytest.mark.slow
def test_damaged_series_are_found_whatever_the_damage_is(tmp_path: Path) -> None:
    sound = sound_site(tmp_path / "sound")
    kinds = [kind.name for kind in KINDS if kind.name.startswith("series ")]
    cases = list(looks(sound, tmp_path, kinds, []))
    assert {case.kind for case in cases} == set(kinds)
    assert [(case.kind, case.damage) for case in cases if not case.found_by] == []
    kind = next(kind for kind in KINDS if kind.name == "series trends")
    healed = run_case(sound, tmp_path / "case", kind, "flipped")
    assert healed is not None
    assert healed.is_well, healed
    shutil.rmtree(tmp_path / "case")
    assert set(DAMAGES) >= {case.damage for case in cases}
