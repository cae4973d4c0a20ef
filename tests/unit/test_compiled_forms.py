"""What compiled loops were asked for is loaded by the next process before it is asked for."""

import pickle
from pathlib import Path

import numpy as np
import pytest

from tasks.geometry import compiled_forms
from tasks.geometry.choice_kernel import draw_of_rows
from tasks.geometry.compiled import FOLDER
from tasks.geometry.compiled_forms import NAME, keep_forms, load_forms


@pytest.fixture(autouse=True)
def _used() -> None:
    draw_of_rows(10, 3)


def test_forms_that_were_used_are_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    keep_forms(tmp_path)
    asked = []
    monkeypatch.setattr(type(draw_of_rows), "compile", lambda made, form: asked.append((made.__name__, form)))
    load_forms(tmp_path)
    forms = {form for name, form in asked if name == "draw_of_rows"}
    assert forms == set(draw_of_rows.signatures)  # type: ignore[attr-defined]


def test_those_of_other_processes_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    keep_forms(tmp_path)
    before = (tmp_path / NAME).read_bytes()
    monkeypatch.setattr(compiled_forms, "MADE", [])
    keep_forms(tmp_path)
    assert (tmp_path / NAME).read_bytes() == before


@pytest.mark.parametrize("content", [b"", b"no pickle", b"\x80\x04]\x94.", pickle.dumps({("a", "b"): 1})])
def test_a_file_that_cannot_be_read_is_as_good_as_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / NAME).write_bytes(content)
    load_forms(tmp_path)
    keep_forms(tmp_path)
    assert ("tasks.geometry.choice_kernel", "draw_of_rows") in compiled_forms._kept_in(tmp_path)


def test_where_nothing_is_kept_nothing_is_done() -> None:
    keep_forms(None)
    load_forms(None)


def test_a_loaded_form_gives_the_same() -> None:
    before = draw_of_rows(1000, 10)
    keep_forms(FOLDER)
    load_forms(FOLDER)
    assert np.array_equal(draw_of_rows(1000, 10), before)
