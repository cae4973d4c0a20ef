"""A run that is killed with SIGKILL, at any moment and at any step, costs nothing but its time."""

from pathlib import Path

import pytest

from tests.faults.killing.moments import Figures, forker_of, kill_at_moments, prepared_scenes
from tests.faults.killing.storage_steps import kill_at_steps_apart

pytestmark = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="steps are told by /proc")

FEW, MOMENTS = 200, 12


@pytest.mark.slow
def test_a_writer_killed_at_a_step_of_storage_leaves_whole_epochs_and_the_next_one_finishes(
    tmp_path: Path,
) -> None:
    """Some steps, from a drawn one on; all of them are in the slow suite."""
    figures = kill_at_steps_apart(tmp_path, FEW, seed=8)
    assert figures["faults"] == {}
    assert figures["killed"] == 2


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_a_writer_killed_at_any_step_of_storage_leaves_whole_epochs_and_the_next_one_finishes(
    tmp_path: Path,
) -> None:
    figures = kill_at_steps_apart(tmp_path, 1, seed=8)
    assert figures["faults"] == {}
    assert figures["killed"] == figures["steps"]


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_a_run_killed_at_any_moment_costs_nothing_but_its_time(tmp_path: Path) -> None:
    figures = Figures()
    with forker_of(tmp_path) as forker:
        scenes = list(prepared_scenes(tmp_path, forker))
        for _ in kill_at_moments(scenes, forker, MOMENTS, 8, figures):
            pass
    assert figures.faults == []
    assert len(figures.phases) >= 3, figures.phases
    assert len(figures.moved_on) >= 5, figures.moved_on
