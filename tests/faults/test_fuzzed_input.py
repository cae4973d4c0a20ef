"""Damaged files by the thousand: no crash, no hang, no gigabyte, no wrong points without a word; and the judge can fail."""

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tasks.ingest import ScanRequest
from tests.faults.fuzzing import parent, verdict
from tests.faults.fuzzing.__main__ import run
from tests.faults.fuzzing.bad_child import FALLS_AT, HANGS_AT
from tests.faults.fuzzing.cases import FAMILIES, WEIGHTS, Case, case_of
from tests.faults.fuzzing.parent import Part, run_part
from tests.faults.fuzzing.seeds import SETTINGS, seeds
from tests.faults.fuzzing.verdict import judge
from tests.shared import needs_shared

pytestmark = pytest.mark.timeout(600)

QUICK, LONG = 1500, 10_000


@needs_shared
@pytest.mark.parametrize("n_cases", [QUICK, pytest.param(LONG, marks=pytest.mark.slow)])
def test_no_damaged_file_does_harm(n_cases: int) -> None:
    figures = run(n_cases, run_seed=n_cases, n_workers=1)
    assert figures.n_cases == n_cases
    assert figures.counts.keys() == WEIGHTS.keys()
    assert figures.faults == []


def test_a_case_is_the_same_wherever_it_is_made() -> None:
    for number in range(0, 200, 7):
        assert case_of(number, 8) == case_of(number, 8)


def test_every_family_has_seeds_that_are_read_and_judged_the_same(tmp_path: Path) -> None:
    for family in WEIGHTS:
        outcomes = {
            judge(_untouched(seed), tmp_path).outcome for seed in seeds()[family] if not seed.is_broken
        }
        assert outcomes == {"same"}, family


def _untouched(seed) -> Case:  # type: ignore[no-untyped-def]
    polar = ScanRequest(coordinates="polar")
    first = ScanRequest(part=1 if seed.family in {"e57", "ptx", "pts"} else None)
    return Case(-1, seed, seed.content, polar if seed.name == "own-polar" else first, ())


@pytest.mark.parametrize("family", sorted(set(FAMILIES) - {"parquet", "laz", *SETTINGS}))
def test_points_that_were_moved_are_found_by_the_independent_reader(
    tmp_path: Path, family: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    seed = next(seed for seed in seeds()[family] if seed.name.startswith("own") and not seed.is_broken)
    case = replace(_untouched(seed), content=seed.content)
    monkeypatch.setattr(verdict, "_baseline", lambda _case: verdict._Read(None, frozenset(), "another file"))
    read = verdict._read
    monkeypatch.setattr(
        verdict, "_read", lambda path, request: replace(read(path, request), notes=frozenset())
    )
    assert judge(case, tmp_path).outcome == "as it says"
    asked = verdict._as_asked
    monkeypatch.setattr(verdict, "_as_asked", lambda case, records: asked(case, records + 1e-3))
    assert judge(case, tmp_path).outcome == "finding"


def test_a_record_that_a_header_hides_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (seed,) = (seed for seed in seeds()["las"] if seed.name == "own-format-0")
    content = bytearray(seed.content)
    struct.pack_into("<d", content, 131, 2e-4)
    case = replace(_untouched(seed), content=bytes(content))
    # the header's box no longer holds the points: that is the word
    assert judge(case, tmp_path).outcome == "told"
    read = verdict._read
    monkeypatch.setattr(
        verdict, "_read", lambda path, request: replace(read(path, request), notes=frozenset())
    )
    assert judge(case, tmp_path).outcome == "as it says"


def test_a_child_that_falls_or_hangs_is_told_and_the_next_cases_are_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(parent, "MOST_SECONDS", 0.3)
    told: list[dict[str, object]] = []
    run_part(Part(0, 6, 1, 8, "tests.faults.fuzzing.bad_child"), told.append)
    outcomes = {answer["case"]: answer["outcome"] for answer in told}
    assert outcomes == {**dict.fromkeys(range(6), "same"), FALLS_AT: "crash", HANGS_AT: "hang"}


def test_an_independent_reader_of_e57_agrees_to_the_last_bit_of_a_scaled_integer() -> None:
    from tests.faults.fuzzing.independent_binary import e57  # noqa: PLC0415
    from tests.unit.ingest.clouds import wall_points  # noqa: PLC0415

    (seed,) = (seed for seed in seeds()["e57"] if seed.name == "own-scaled")
    assert np.allclose(e57(seed.content, None, in_file=False), wall_points(30), rtol=0, atol=1e-9)
