"""Each quantity is found where it changed, and is silent where something else did: slices of simulated surveys."""

import numpy as np
import pytest

from benchmarks.change.no_change import CASES, RING, SIDE, false_alarms, power_of
from benchmarks.change.simulated_epochs import Site, State, Survey, axis_record
from tasks.change_quantities import AxisRecord, Kinship, Quantity, changed_quantities

STILL = State()
LEAN = STILL.lean
FULL = Kinship(alike=1.0, before_holds_frame=True, partial=False)
ARC = Kinship(alike=1.0, before_holds_frame=True, partial=True)
RING_SURVEY = Survey(RING, points=12, slices=40)
SIDE_SURVEY = Survey(SIDE, points=12, slices=40, arc_deg=100.0)


def compared(
    later: State, survey: Survey = RING_SURVEY, kinship: Kinship = FULL, seed: int = 4
) -> dict[str, Quantity]:
    rng = np.random.default_rng(seed)
    site = Site(survey)
    before, after = (axis_record(site, site.draw(rng, state), n) for n, state in enumerate((STILL, later)))
    return {one.quantity: one for one in changed_quantities(before, after, kinship)}


def significant(found: dict[str, Quantity]) -> set[str]:
    return {name for name, one in found.items() if one.significant}


def test_a_lean_that_grew_is_no_shift_of_the_base_and_no_bending() -> None:
    found = compared(State(lean=(LEAN[0] + 3e-4, LEAN[1])))
    assert significant(found) >= {"lean"}
    assert not significant(found) & {"base", "bending", "radius"}
    assert found["lean"].size_m == pytest.approx(3e-4 * 102.0, rel=0.2)
    assert found["lean"].basis == "free"


def test_a_base_that_slid_is_no_lean() -> None:
    found = compared(State(base_m=(0.2, 0.0)))
    assert significant(found) >= {"base"}
    assert not significant(found) & {"lean", "bending", "radius"}
    assert found["base"].size_m == pytest.approx(0.2, rel=0.15)


def test_a_shaft_that_bent_is_told_by_its_sagitta_and_by_its_centres() -> None:
    found = compared(State(bend_m=(0.0, 0.03)))
    assert significant(found) >= {"bending", "centres"}
    assert not significant(found) & {"lean", "base", "radius"}
    assert found["bending"].size_m == pytest.approx(0.03, rel=0.1)
    assert "the shape changed between" in (found["centres"].reason or "")


def test_a_wall_that_grew_is_no_movement() -> None:
    found = compared(State(wider_m=0.02))
    assert significant(found) == {"radius"}
    assert found["radius"].size_m == pytest.approx(0.02, rel=0.2)


def test_on_an_arc_the_radius_is_held_and_the_lean_gets_more_certain() -> None:
    free, held = (compared(STILL, SIDE_SURVEY, kinship)["lean"] for kinship in (FULL, ARC))
    assert (free.basis, held.basis) == ("free", "radius held")
    assert held.sigma_m is not None
    assert free.covariance is not None
    assert held.covariance is not None
    assert np.trace(held.covariance) < 0.8 * np.trace(free.covariance)
    assert "taken for unchanged" in (held.reason or "")


def test_a_radius_that_changed_itself_is_not_held() -> None:
    found = compared(State(wider_m=0.2), SIDE_SURVEY, ARC)
    assert found["lean"].basis == "free"
    assert "so it was not held" in (found["lean"].reason or "")


def test_without_parameters_the_lean_alone_is_compared_and_nothing_is_cancelled() -> None:
    rng = np.random.default_rng(1)
    site = Site(RING_SURVEY)
    whole = [axis_record(site, site.draw(rng, STILL), n) for n in range(2)]
    bare = [AxisRecord(one.tilt, None, one.slices) for one in whole]
    (lean,) = changed_quantities(bare[0], bare[1], FULL)
    assert lean.covariance is not None
    assert lean.covariance[0, 0] == pytest.approx(
        (bare[0].tilt.lean_cov_ee or 0.0) + (bare[1].tilt.lean_cov_ee or 0.0)
    )


@pytest.mark.slow
def test_false_alarms_and_power_are_as_stated() -> None:
    case = CASES[0]
    lean = false_alarms(case, 1000, seed=1)["lean"]
    # the standard error of 1000 campaigns is 0.7 %
    assert np.mean(lean < 0.05) == pytest.approx(0.05, abs=0.02)
    assert power_of(case, 400, seed=2) == pytest.approx(0.8, abs=0.06)
