"""Each quantity is found where it changed, and is silent where something else did: slices of simulated surveys."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.change.no_change import CASES, RING, SIDE, false_alarms, power_of
from benchmarks.change.simulated_epochs import Site, State, Survey, axis_record
from storage.records import SliceRow
from tasks.change_basis import AxisRecord, Kinship
from tasks.change_quantities import Quantity, changed_quantities

STILL = State()
LEAN = STILL.lean
FULL = Kinship(alike=1.0, frame_of="before", partial=False, fewest_stations=8)
ARC = Kinship(alike=1.0, frame_of="before", partial=True, fewest_stations=5)
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
    assert "differ smoothly beyond shift and lean" in (found["centres"].reason or "")


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


def test_a_radius_that_seems_to_have_changed_is_told_where_it_is_held() -> None:
    found = compared(State(wider_m=0.2), SIDE_SURVEY, ARC)
    assert found["lean"].basis == "radius held"
    assert "although it seems to have changed" in (found["lean"].reason or "")


def test_a_bent_shaft_whose_top_was_not_seen_again_did_not_move() -> None:
    rng = np.random.default_rng(6)
    bent = State(bend_m=(0.05, 0.0))
    sites = [Site(RING_SURVEY), Site(replace(RING_SURVEY, top_m=80.0))]
    before, after = (axis_record(site, site.draw(rng, bent), n) for n, site in enumerate(sites))
    plain = abs(after.tilt.lean_east - before.tilt.lean_east) * 102.0
    found = {one.quantity: one for one in changed_quantities(before, after, FULL)}
    assert plain > 0.03
    assert not significant(found)
    assert "heights that both epochs have" in (found["lean"].reason or "")


def test_axes_that_rest_on_other_centres_are_not_compared() -> None:
    rng = np.random.default_rng(6)
    sites = [Site(RING_SURVEY), Site(replace(RING_SURVEY, top_m=80.0))]
    before, after = (axis_record(site, site.draw(rng, STILL), n) for n, site in enumerate(sites))
    # as with a line through two centres: all others have no weight
    before = replace(before, slices=[_weighing(row, row.slice_index in (0, 39)) for row in before.slices])
    after = replace(after, slices=[_weighing(row, row.slice_index in (1, 30)) for row in after.slices])
    (lean,) = changed_quantities(before, after, FULL)
    assert lean.p_value is None
    assert "fewer than 4 centres" in (lean.reason or "")


def _weighing(row: SliceRow, counts: bool) -> SliceRow:
    return replace(row, weight=None if row.state != "ok" else float(counts))


def test_another_part_of_the_shaft_is_not_compared() -> None:
    rng = np.random.default_rng(6)
    site = Site(RING_SURVEY)
    before, after = (axis_record(site, site.draw(rng, STILL), n) for n in range(2))
    shorter = replace(after, slices=[row for row in after.slices if row.z_m < 80.0])
    (lean,) = changed_quantities(before, shorter, FULL)
    assert (lean.p_value, lean.covariance) == (None, None)
    assert "another part of the shaft was measured" in (lean.reason or "")


def test_few_stations_and_other_sides_are_told() -> None:
    few = compared(STILL, kinship=replace(FULL, fewest_stations=4))["lean"].reason or ""
    assert "4 stations cannot check their stated levels" in few
    other = compared(STILL, kinship=replace(FULL, alike=0.5))["lean"].reason or ""
    assert "other sides of the wall" in other
    assert compared(STILL, kinship=replace(FULL, alike=0.5))["centres"].p_value is None


def test_without_parameters_the_lean_alone_is_compared_and_nothing_is_cancelled() -> None:
    rng = np.random.default_rng(1)
    site = Site(RING_SURVEY)
    whole = [axis_record(site, site.draw(rng, STILL), n) for n in range(2)]
    bare = [AxisRecord(one.tilt, None, one.slices) for one in whole]
    (lean,) = changed_quantities(bare[0], bare[1], FULL)
    assert lean.basis == "sum of both"
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
