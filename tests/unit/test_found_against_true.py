"""Found against true: errors, stated regions and changes of a stored campaign with a truth beside it."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.conventions import ARCSEC_RAD
from tasks.found_against_true import FoundAgainstTrue, found_against_true, text_lines
from tasks.settings import load_campaign
from tests.flows.stored_campaign import LEAN, publish, stored_campaign


def _found(folder: Path, error: tuple[float, float], moved_m: float = 0.004) -> FoundAgainstTrue:
    """Two epochs whose true lean is off by ``error`` from the found one; the second moved east."""
    stored = stored_campaign(folder)
    for number, epoch in enumerate(("e1", "e2")):
        publish(stored, epoch, number, moved_m=moved_m * number)
        truth = (LEAN[0] + moved_m / 102.0 * number - error[0], LEAN[1] - error[1])
        (folder / epoch).mkdir()
        (folder / epoch / "truth.json").write_text(json.dumps({"lean_fit": truth}), encoding="utf-8")
    return found_against_true(stored.workspace, load_campaign(stored.file))


def test_error_is_the_length_of_the_difference(tmp_path: Path) -> None:
    found = _found(tmp_path, (3e-6, 4e-6))
    assert [lean.error_arcsec for lean in found.leans] == pytest.approx([5e-6 / ARCSEC_RAD] * 4)
    assert found.leans[0].error_top_m == pytest.approx(102.0 * 5e-6)


def test_error_common_to_both_epochs_cancels_in_the_change(tmp_path: Path) -> None:
    (change, _) = _found(tmp_path, (3e-6, 4e-6)).changes
    assert change.true_top_m == pytest.approx(0.004)
    assert change.error_top_m == pytest.approx(0.0, abs=1e-12)
    assert change.inside_95


@pytest.mark.parametrize(("sigmas", "inside"), [(2.4, True), (2.5, False)])
def test_region_of_95_percent_ends_at_2_45_sigma(tmp_path: Path, sigmas: float, inside: bool) -> None:
    # along the smaller axis of the ellipse (4e-10, 1e-10, 9e-10) of the stored rows
    direction, sigma = (0.98305, -0.18335), 3.8135e-10**0.5
    found = _found(tmp_path, (sigmas * sigma * direction[0], sigmas * sigma * direction[1]))
    assert {lean.inside_95 for lean in found.leans} == {inside}


def test_lines_say_whether_the_truth_is_inside(tmp_path: Path) -> None:
    found = _found(tmp_path, (3e-6, 4e-6))
    lines = list(text_lines(replace(found, changes=found.changes[:1])))
    assert lines[2].split() == ["e1", "A", "paper", '1.03"', "0.51", "mm", '5.26"', "yes"]
    assert lines[-1].split()[3:9] == ["4.00", "mm", "4.00", "mm", "0.00", "mm"]


def test_campaign_without_truth_is_refused(tmp_path: Path) -> None:
    stored = stored_campaign(tmp_path)
    with pytest.raises(InputError, match="no such file; only a simulated campaign has its truth beside it"):
        found_against_true(stored.workspace, load_campaign(stored.file))
