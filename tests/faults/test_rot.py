"""Bit rot: the table of kinds of files is complete for a workspace that was run, and what was damaged is found."""

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


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Site:
    return sound_site(tmp_path_factory.mktemp("rot") / "sound")


@pytest.mark.slow
def test_damaged_series_are_found_whatever_the_damage_is(sound: Site, tmp_path: Path) -> None:
    kinds = [kind.name for kind in KINDS if kind.name.startswith("series ")]
    cases = list(looks(sound, tmp_path, kinds, []))
    assert {case.kind for case in cases} == set(kinds)
    assert [(case.kind, case.damage) for case in cases if not case.found_by] == []
    assert set(DAMAGES) >= {case.damage for case in cases}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "damage", "ended"),
    [
        ("series trends", "flipped", "healed by the run"),
        ("version table", "flipped", "said by the run"),
        ("intake note", "deleted", "harmless"),
    ],
)
def test_what_a_run_makes_of_damage(sound: Site, tmp_path: Path, name: str, damage: str, ended: str) -> None:
    kind = next(kind for kind in KINDS if kind.name == name)
    case = run_case(sound, tmp_path / "case", kind, damage)
    assert case is not None
    assert case.is_well, case
    assert case.ended == ended
