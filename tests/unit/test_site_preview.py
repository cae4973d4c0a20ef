"""What a quick look at a scan says of the shaft, and what follows for the crew."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.design.shaft import Shaft
from tasks.geometry.failure import FitFailure
from tasks.quick_look import QuickLook, quick_look, thinned
from tasks.settings.intake import Intake, load_awaiting
from tasks.site_preview import SitePreview, look_at_station, preview, preview_facts
from tests.flows.watched_sites import HEAD, position_m, visible_wall_m, write_scan

SHAFT = Shaft((1.0, 30.0), (4.0, 4.0))


def looked(points_m: NDArray[np.float64], shaft: Shaft = SHAFT, scale: float = 1.0) -> QuickLook:
    found = quick_look(points_m, scale, shaft, shift_sigma_m=0.7)
    assert isinstance(found, QuickLook)
    return found


def seen_deg(found: QuickLook) -> NDArray[np.float64]:
    """Azimuths of the sectors of 10 degrees with points."""
    sectors = found.counts.sum(axis=0).reshape(36, -1).sum(axis=1)
    return 10.0 * np.flatnonzero(sectors > 0)


def test_a_scan_shows_the_side_of_its_scanner() -> None:
    found = looked(visible_wall_m(90.0))
    assert seen_deg(found).min() == pytest.approx(0.0, abs=10.0)
    assert seen_deg(found).max() == pytest.approx(170.0, abs=10.0)
    assert found.shift_m < 0.05


@pytest.mark.parametrize("shift_m", [(0.8, 0.0), (-0.5, 0.9), (0.0, -1.2)])
def test_a_heading_that_is_off_does_not_turn_the_side(shift_m: tuple[float, float]) -> None:
    """The shaft is looked for where it is seen, and not where a rough heading puts it."""
    points_m = visible_wall_m(90.0) + np.array([*shift_m, 0.0])
    found = looked(points_m)
    assert found.shift_m == pytest.approx(np.hypot(*shift_m), abs=0.1)
    assert seen_deg(found).tolist() == seen_deg(looked(visible_wall_m(90.0))).tolist()


def test_a_lean_of_a_degree_and_a_rough_radius_do_no_harm() -> None:
    wall_m = visible_wall_m(200.0)
    lean_m = np.outer(wall_m[:, 2], [0.017, -0.01])
    leaning_m = np.column_stack([wall_m[:, :2] + lean_m, wall_m[:, 2]])
    found = looked(leaning_m, Shaft((1.0, 30.0), (3.7, 3.7)))
    assert found.n_on_shaft > 0.9 * np.count_nonzero((wall_m[:, 2] >= 1.0) & (wall_m[:, 2] <= 30.0))


def test_what_stands_beside_the_shaft_is_not_counted() -> None:
    rng = np.random.default_rng(2)
    tree_m = rng.uniform([4.7, -1.5, 1.0], [5.8, 1.5, 9.0], (1500, 3))
    alone = looked(visible_wall_m(270.0))
    beside = looked(np.concatenate([visible_wall_m(270.0), tree_m]))
    assert beside.n_on_shaft == pytest.approx(alone.n_on_shaft, rel=0.02)


def test_a_scan_that_does_not_show_the_shaft_says_so() -> None:
    found = quick_look(visible_wall_m(0.0) + np.array([30.0, 0.0, 0.0]), 1.0, SHAFT, 0.7)
    assert isinstance(found, FitFailure)
    assert "position and heading; are they right" in found.reason


def test_thinned_points_stand_for_all() -> None:
    points_m = np.zeros((1_000_000, 3))
    few_m, scale = thinned(points_m)
    assert len(few_m) <= 400_000
    assert scale * len(few_m) == pytest.approx(len(points_m))


@dataclass
class Crew:
    """A crew that measures the silo from one side after the other."""

    folder: Path

    def preview_from(self, *azimuths_deg: float) -> SitePreview:
        file = self.folder / "silo.toml"
        file.write_text(HEAD)
        campaign = load_awaiting(file)
        stations = []
        for number, azimuth_deg in enumerate(azimuths_deg, start=1):
            write_scan(self.folder / f"ST{number}.csv", azimuth_deg)
            position = list(position_m(azimuth_deg))
            station = {"id": f"ST{number}", "scan": f"ST{number}.csv", "position_m": position}
            stations.append({**station, "heading_deg": 0.0})
        now = datetime(2026, 3, 11, tzinfo=UTC)
        intake = Intake.model_validate(
            {"epoch": "e", "time": now, "first_arrival": now, "stations": stations}
        )
        looks = [look_at_station(campaign, station, None) for station in intake.stations]
        return preview(campaign, intake, looks, ())


def test_every_station_from_a_new_side_adds_coverage_and_certainty(tmp_path: Path) -> None:
    found = [Crew(tmp_path).preview_from(*[0.0, 120.0, 240.0][:n]) for n in (1, 2, 3)]
    covered = [float(one.covered_deg or 0.0) for one in found]
    sigma = [float(str(preview_facts(one)["sigma_worst_arcsec"])) for one in found]
    assert covered == sorted(covered)
    assert covered[2] == pytest.approx(360.0, abs=10.0)
    assert sigma == sorted(sigma, reverse=True)
    assert found[2].unseen_deg == ()


def test_the_next_station_is_wanted_on_the_side_that_is_missing(tmp_path: Path) -> None:
    found = preview_facts(Crew(tmp_path).preview_from(30.0, 60.0))
    (arc,) = found["unseen_deg"]  # type: ignore[misc]
    assert (arc[0], arc[1]) == (pytest.approx(145.0, abs=15.0), pytest.approx(305.0, abs=15.0))
    assert 180.0 <= float(str(found["next_azimuth_deg"])) <= 270.0
    assert float(str(found["next_sigma_worst_arcsec"])) < float(str(found["sigma_worst_arcsec"]))


def test_a_structure_for_which_no_prediction_is_made_says_why(tmp_path: Path) -> None:
    write_scan(tmp_path / "ST1.csv", 0.0)
    file = tmp_path / "tower.toml"
    file.write_text(HEAD.replace('"silo"\nheight', '"square-tower"\nheight'))
    now = datetime(2026, 3, 11, tzinfo=UTC)
    station = {"id": "ST1", "scan": "ST1.csv", "position_m": list(position_m(0.0)), "heading_deg": 0.0}
    intake = Intake.model_validate({"epoch": "e", "time": now, "first_arrival": now, "stations": [station]})
    campaign = load_awaiting(file)
    look = look_at_station(campaign, intake.stations[0], None)
    facts = preview_facts(preview(campaign, intake, [look], ("ST2",)))
    assert look.reason is not None
    assert "round shaft" in look.reason
    assert (facts["covered_deg"], facts["sigma_worst_arcsec"]) == (None, None)
    assert facts["missing_stations"] == ["ST2"]
