"""The map of the surface, from the campaign file through a run to the view that compares two epochs."""

from pathlib import Path

import pytest

from flows.outcome import RunOutcome
from storage.records import SurfaceMapRow
from storage.views import surface_change_rows
from storage.workspace import Workspace
from tests.flows.campaigns import STRUCTURE, computed_stages, replace_text, rows, run, small_campaign

pytestmark = pytest.mark.usefixtures("prefect_api")


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory, prefect_api: str) -> Path:
    return small_campaign(tmp_path_factory.mktemp("mapped"), epochs=2, stations=4, points=60_000)


@pytest.fixture(scope="module")
def outcome(campaign: Path) -> RunOutcome:
    return run(campaign, campaign.parent / "ws", schemes=["S"])


def maps(outcome: RunOutcome) -> list[list[SurfaceMapRow]]:
    return [rows(outcome.workspace, "surface_map", epoch.epoch) for epoch in outcome.epochs]


def test_every_piece_of_every_epoch_is_a_row(outcome: RunOutcome) -> None:
    assert "surface map" in computed_stages(outcome)
    for found in maps(outcome):
        assert len(found) % 36 == 0
        seen = [row for row in found if row.n_points]
        assert len(seen) > 100
        assert {row.design_deviation_m for row in found} == {None}
        # the simulated chimney is round, its points are good to 15 mm
        assert sum(abs(row.deviation_m or 0.0) < 0.05 for row in seen) > 0.98 * len(seen)


def test_of_a_shaft_that_only_leans_more_few_pieces_changed(outcome: RunOutcome) -> None:
    workspace = Workspace(Path(outcome.workspace))
    told = [row for row in surface_change_rows(workspace, STRUCTURE) if row.significant is not None]
    assert {row.epoch for row in told} == {outcome.epochs[1].epoch}
    assert len(told) > 100
    assert sum(bool(row.significant) for row in told) < 0.15 * len(told)


@pytest.mark.slow
def test_a_run_of_other_schemes_keeps_the_map(campaign: Path, outcome: RunOutcome) -> None:
    before = maps(outcome)
    again = run(campaign, campaign.parent / "ws", schemes=["B"])
    assert "surface map" not in computed_stages(again)
    assert maps(again) == before


@pytest.mark.slow
def test_a_design_is_mapped_without_measuring_anew(campaign: Path, outcome: RunOutcome) -> None:
    radii = "design_radius_m = [[0.0, 4.6], [110.0, 2.6]]\n"
    replace_text(campaign, "[frame]", radii + "[frame]", 1)
    again = run(campaign, campaign.parent / "ws", schemes=["S"])
    assert {stage for stage in computed_stages(again) if not stage.startswith("evaluation")} == {
        "surface map"
    }
    for found in maps(again):
        assert all((row.design_deviation_m is None) == (row.n_points == 0) for row in found)
