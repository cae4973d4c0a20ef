import json
import tomllib
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import laspy
import numpy as np
import pytest

from storage.errors import InputError, UsageError
from tasks.conventions import rotation_site_scanner
from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign
from tasks.simulation import Horizontal, Movement, ShaftShape

SMALL = SimulatedCampaignRequest(epochs=2, stations=3, points=1500, seed=9)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_simulated_campaign(tmp_path_factory.mktemp("campaign") / "demo", SMALL)


def _files(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def _truth(campaign: Path, epoch: str = "2025-01") -> dict[str, object]:
    found: dict[str, object] = json.loads((campaign.parent / epoch / "truth.json").read_text())
    return found


def test_campaign_file_names_every_scan_that_lies_there(campaign: Path) -> None:
    content = tomllib.loads(campaign.read_text())
    named = [s["scan"] for e in content["epochs"] for s in e["stations"]]
    assert sorted(named) == sorted(name for name in _files(campaign.parent) if name.endswith(".laz"))
    assert len(named) == 6


def test_sliced_part_gives_101_slices_below_the_platform(campaign: Path) -> None:
    structure = tomllib.loads(campaign.read_text())["structure"]
    assert structure["id"] == "demo-chimney"
    assert structure["kind"] == "chimney"
    assert structure["height_m"] == 102.0
    assert structure["shaft_z_m"] == [2.0, 102.01]


def test_report_and_limits_are_those_of_the_paper(campaign: Path) -> None:
    content = tomllib.loads(campaign.read_text())
    assert content["report"] == {"primary": ["S", "surface"], "control": ["F", "paper"]}
    assert content["limits"] == {"table": "gb50078-concrete-quoted"}


def test_epochs_are_three_months_apart_and_the_first_is_the_reference(campaign: Path) -> None:
    epochs = tomllib.loads(campaign.read_text())["epochs"]
    assert [e["time"] for e in epochs] == [
        datetime.fromisoformat("2025-01-14T06:00+08:00"),
        datetime.fromisoformat("2025-04-14T06:00+08:00"),
    ]
    assert [e.get("reference", False) for e in epochs] == [True, False]


def test_total_station_is_within_its_sigma_of_the_truth(campaign: Path) -> None:
    for epoch in tomllib.loads(campaign.read_text())["epochs"]:
        (reference,) = epoch["references"]
        lean = np.array(_truth(campaign, epoch["id"])["lean_fit"])
        assert reference["sigma"] == 5e-5
        assert np.abs(np.array([reference["lean_east"], reference["lean_north"]]) - lean).max() < 4 * 5e-5


def test_scans_are_las_1_4_with_a_tenth_of_a_millimetre(campaign: Path) -> None:
    with laspy.open(campaign.parent / "2025-01" / "ST01.laz") as reader:
        header = reader.header
    assert str(header.version) == "1.4"
    assert header.scales.tolist() == [1e-4, 1e-4, 1e-4]
    assert header.offsets.tolist() == [0.0, 0.0, 0.0]


def test_counts_in_the_truth_are_those_of_the_files(campaign: Path) -> None:
    for station in _truth(campaign)["stations"]:  # type: ignore[attr-defined]
        with laspy.open(campaign.parent / "2025-01" / station["file"]) as reader:
            assert reader.header.point_count == station["points"]
        assert sum(station["points_by_surface"].values()) == station["points"]


def test_true_pose_of_the_truth_puts_the_file_on_the_shaft(campaign: Path) -> None:
    truth = _truth(campaign)
    for station in truth["stations"]:  # type: ignore[attr-defined]
        points_m = laspy.read(campaign.parent / "2025-01" / station["file"]).xyz
        turn = rotation_site_scanner(np.radians(station["true_heading_deg"]))
        site_m = points_m @ turn.T + station["true_position"]
        tall_m = site_m[(site_m[:, 2] > 20.0) & (site_m[:, 2] < 100.0) & (np.hypot(*site_m[:, :2].T) < 8.0)]
        off_m = tall_m[:, :2] - tall_m[:, 2:] * truth["lean_fit"]
        radius_m = ShaftShape().radius_at(tall_m[:, 2])
        assert len(tall_m) > 200
        # 15 mm of range noise at 300 m, 5 mm of level, and a ladder
        assert np.median(np.abs(np.hypot(*off_m.T) - radius_m)) < 0.02


def test_stated_poses_of_the_campaign_file_are_those_of_the_truth(campaign: Path) -> None:
    first = tomllib.loads(campaign.read_text())["epochs"][0]
    for stated, true in zip(first["stations"], _truth(campaign)["stations"], strict=True):  # type: ignore[call-overload]
        assert stated["position_m"] == true["gnss"]
        assert stated["heading_deg"] == true["heading_deg"]
        off_m = np.array(true["gnss"]) - true["true_position"]
        assert 0.0 < np.abs(off_m).max() < 0.12


def test_truth_has_what_the_shared_scoring_reads_and_moves_as_asked(campaign: Path) -> None:
    first, second = (_truth(campaign, name) for name in ("2025-01", "2025-04"))
    moved = np.subtract(second["lean_fit"], first["lean_fit"])  # type: ignore[call-overload]
    assert first["lean_fit"] == pytest.approx([0.00725, -0.00695], abs=1e-12)
    assert np.hypot(*moved) * 206264.806 == pytest.approx(8.0, rel=1e-6)
    assert first["tilt_deg"] == pytest.approx(np.degrees(np.arctan(np.hypot(0.00725, 0.00695))), abs=1e-9)


def test_bending_is_told_and_counts_in_the_lean(tmp_path: Path) -> None:
    bent = replace(
        SMALL,
        epochs=1,
        stations=1,
        shape=ShaftShape(lean=Horizontal(0.0, 0.0), bend_top_m=Horizontal(0.1, 0.0)),
    )
    truth = _truth(write_simulated_campaign(tmp_path, bent))
    # a parabola over [a, b] has the slope of its chord, bend * (a + b) / height**2
    assert truth["lean_fit"] == pytest.approx([0.1 * 104.01 / 110.0**2, 0.0], abs=1e-12)
    assert truth["bending_m"] == pytest.approx(0.1 * 100.01**2 / 110.0**2 / 6.0, rel=1e-3)


def test_same_request_gives_the_same_bytes_in_another_folder(campaign: Path, tmp_path: Path) -> None:
    again = write_simulated_campaign(tmp_path / "again", SMALL)
    assert _files(again.parent) == _files(campaign.parent)


def test_another_seed_gives_other_scans(campaign: Path, tmp_path: Path) -> None:
    other = write_simulated_campaign(tmp_path, replace(SMALL, seed=10))
    name = "2025-01/ST01.laz"
    assert _files(other.parent)[name] != _files(campaign.parent)[name]


def test_further_epoch_leaves_the_earlier_ones_as_they_are(campaign: Path, tmp_path: Path) -> None:
    longer = _files(write_simulated_campaign(tmp_path, replace(SMALL, epochs=3)).parent)
    for name, content in _files(campaign.parent).items():
        if name.endswith(".laz"):
            assert longer[name] == content


def test_second_call_writes_nothing(campaign: Path) -> None:
    before = {p: p.stat().st_mtime_ns for p in campaign.parent.rglob("*")}
    write_simulated_campaign(campaign.parent, SMALL)
    assert {p: p.stat().st_mtime_ns for p in campaign.parent.rglob("*")} == before


def test_deleted_scan_is_written_again(tmp_path: Path) -> None:
    tiny = replace(SMALL, epochs=1, stations=1)
    campaign = write_simulated_campaign(tmp_path, tiny)
    scan = tmp_path / "2025-01" / "ST01.laz"
    content = scan.read_bytes()
    scan.unlink()
    write_simulated_campaign(campaign.parent, tiny)
    assert scan.read_bytes() == content


def test_campaign_that_was_interrupted_is_written_again(tmp_path: Path) -> None:
    tiny = replace(SMALL, epochs=1, stations=1)
    campaign = write_simulated_campaign(tmp_path, tiny)
    whole = _files(tmp_path)
    request = tmp_path / "simulation.json"
    half = json.loads(request.read_text())
    del half["files"]
    request.write_text(json.dumps(half))
    campaign.write_text("half of")
    write_simulated_campaign(tmp_path, tiny)
    assert _files(tmp_path) == whole


def test_smaller_request_takes_the_larger_ones_files_away(tmp_path: Path) -> None:
    write_simulated_campaign(tmp_path, replace(SMALL, stations=2))
    (tmp_path / "notes.txt").write_text("a stranger's")
    write_simulated_campaign(tmp_path, replace(SMALL, epochs=1, stations=1))
    assert sorted(_files(tmp_path)) == [
        "2025-01/ST01.laz",
        "2025-01/truth.json",
        "campaign.toml",
        "notes.txt",
        "simulation.json",
    ]


def test_campaign_of_a_stranger_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "campaign.toml").write_text("schema_version = 1\n")
    with pytest.raises(InputError, match="not overwritten; choose another folder"):
        write_simulated_campaign(tmp_path, SMALL)
    assert (tmp_path / "campaign.toml").read_text() == "schema_version = 1\n"


@pytest.mark.parametrize("wrong", [{"epochs": 0}, {"stations": 0}, {"points": 0}, {"seed": -1}])
def test_request_for_nothing_is_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(UsageError, match="at least 1 epoch, 1 station and 1 point, and a seed >= 0"):
        SimulatedCampaignRequest(**wrong)


def test_movement_of_the_request_is_what_the_truth_tells(tmp_path: Path) -> None:
    request = replace(
        SMALL, stations=1, points=200, movement=Movement(azimuth_deg=0.0, lean_arcsec=(0.0, 100.0))
    )
    campaign = write_simulated_campaign(tmp_path, request)
    first, second = (_truth(campaign, name)["lean_fit"] for name in ("2025-01", "2025-04"))
    assert np.subtract(second, first) * 206264.806 == pytest.approx([0.0, 100.0], abs=1e-6)  # type: ignore[call-overload]
