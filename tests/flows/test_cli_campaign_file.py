"""init, check and schema: a campaign file from its first line to ready to run."""

import json
from pathlib import Path

import laspy
import numpy as np
import pytest

from storage.errors import InputError
from tasks.settings import load_campaign
from tests.flows.calls import call, call_process
from tests.shared import SHARED, needs_shared
from tests.unit.settings.campaign_text import FEWEST, WHOLE, edited

CAMPAIGN = SHARED / "data" / "campaign" / "campaign.toml"


def write_cloud(path: Path, seed: int = 0, shift_m: float = 0.0) -> None:
    """A small cloud round the pole of the campaign file FEWEST."""
    rng = np.random.default_rng(seed)
    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales = np.array([1e-4, 1e-4, 1e-4])
    cloud = laspy.LasData(header)
    cloud.x, cloud.y = rng.normal(shift_m, 0.2, (2, 500))
    cloud.z = rng.uniform(0.0, 10.0, 500)
    path.parent.mkdir(parents=True, exist_ok=True)
    cloud.write(str(path))


def write_campaign(folder: Path, text: str) -> Path:
    file = folder / "campaign.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_init_writes_a_file_that_check_understands(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "new.toml"
    called = call(capsys, "init", "chimney", file)
    assert (called.code, called.out) == (0, f"{file}\n")
    assert called.err == f"next: edit {file}, then `tiltwatch check {file}`\n"
    assert load_campaign(file).structure.kind == "chimney"


def test_init_never_overwrites(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = write_campaign(tmp_path, "mine")
    called = call(capsys, "init", "chimney", file)
    assert (called.code, file.read_text("utf-8")) == (2, "mine")
    assert called.err == f"error: {file} is there already; name another file or move it away\n"


def test_init_names_the_nearest_kind(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    called = call(capsys, "init", "chimny", tmp_path / "new.toml")
    assert (called.code, called.err) == (2, "error: unknown kind 'chimny'; did you mean 'chimney'?\n")
    assert not (tmp_path / "new.toml").exists()


def test_init_in_a_missing_folder_says_so(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    called = call(capsys, "init", "silo", tmp_path / "none" / "new.toml")
    assert called.code == 2
    assert "cannot be written: No such file or directory; name another file" in called.err


def test_init_writes_campaign_toml_where_no_file_is_named(tmp_path: Path) -> None:
    called = call_process("init", "stem", "-q", cwd=tmp_path)
    assert (called.code, called.out, called.err) == (0, "campaign.toml\n", "")
    assert (tmp_path / "campaign.toml").is_file()


def test_schema_is_the_json_schema_of_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    called = call(capsys, "schema")
    assert called.code == 0
    assert json.loads(called.out)["title"] == "Campaign"


@needs_shared
def test_shared_campaign_is_ready_to_run(capsys: pytest.CaptureFixture[str]) -> None:
    called = call(capsys, "check", CAMPAIGN)
    assert called.code == 0
    assert called.out.splitlines()[1:] == [
        "e1: 8 of 8 scans sound, 2,775,678 points, 19.4 MB",
        "e2: 8 of 8 scans sound, 2,879,280 points, 20.1 MB",
        f"{CAMPAIGN}: ready to run",
    ]


def test_check_answers_programs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    write_cloud(tmp_path / "cloud.laz")
    answer = call(capsys, "check", write_campaign(tmp_path, FEWEST), "--json").answer
    assert (answer["ok"], answer["problems"], answer["reference"]) == (True, [], "e1")
    (scan,) = answer["scans"]
    assert (scan["station"], scan["n_points"]) == ("registered", 500)


def test_check_tells_bad_file_to_programs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = write_campaign(tmp_path, edited("height_m", "heigth_m", FEWEST))
    called = call(capsys, "check", file, "--json")
    assert called.code == 3
    assert called.answer["ok"] is False
    assert f"{file}: structure.heigth_m: unknown key; did you mean 'height_m'?" in called.answer["problems"]
    assert f"error: {file}: structure.heigth_m: unknown key" in called.err


def test_check_tells_every_missing_scan(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    called = call(capsys, "check", write_campaign(tmp_path, WHOLE))
    assert called.code == 3
    assert len(called.err.splitlines()) == 3
    assert (
        f"epochs[e1].stations[ST02].scan: {tmp_path / 'e1' / 'ST02.laz'}: needs a scan, came no such file"
        in called.err
    )
    assert "epochs[e2].registered: " in called.err
    assert called.out.splitlines()[-1].endswith("3 problems")


def test_check_finds_a_truncated_scan_beside_a_missing_one(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    write_cloud(tmp_path / "whole.laz")
    (tmp_path / "e1").mkdir()
    (tmp_path / "e1" / "ST01.laz").write_bytes((tmp_path / "whole.laz").read_bytes()[:100])
    called = call(capsys, "check", write_campaign(tmp_path, WHOLE))
    assert called.code == 3
    assert "epochs[e1].stations[ST01].scan: " in called.err
    assert len(called.err.splitlines()) == 3


def test_check_finds_a_copy_under_another_name(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    write_cloud(tmp_path / "e1" / "ST01.laz")
    (tmp_path / "e1" / "ST02.laz").write_bytes((tmp_path / "e1" / "ST01.laz").read_bytes())
    write_cloud(tmp_path / "e2" / "merged.laz", seed=1)
    called = call(capsys, "check", write_campaign(tmp_path, WHOLE))
    assert called.code == 3
    assert (
        "ST02.laz is a copy of epochs[e1].stations[ST01].scan; name the scan that belongs here" in called.err
    )


def test_check_finds_a_registered_cloud_that_misses_the_shaft(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    write_cloud(tmp_path / "cloud.laz", shift_m=500.0)
    called = call(capsys, "check", write_campaign(tmp_path, FEWEST))
    assert called.code == 3
    assert (
        "after frame.origin_m, the shaft from -0.2 to 0.2 m; check frame.origin_m, frame.axes" in called.err
    )


def test_check_takes_origin_and_axes_into_account(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    write_cloud(tmp_path / "cloud.laz", shift_m=500.0)
    frame = 'axes = "NEU"\norigin_m = [500.0, 500.0, 0.0]'
    called = call(capsys, "check", write_campaign(tmp_path, edited('axes = "ENU"', frame, FEWEST)))
    assert (called.code, called.err) == (0, "")


def test_check_of_no_file_names_init(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    called = call(capsys, "check", tmp_path / "none.toml")
    assert called.code == 3
    assert called.err.endswith("none.toml: no such file; `tiltwatch init KIND FILE` writes an example\n")


def test_written_example_lacks_only_its_scans(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "new.toml"
    call(capsys, "init", "tower", file)
    called = call(capsys, "check", file)
    assert called.code == 3
    assert all("no such file" in line for line in called.err.splitlines())
    with pytest.raises(InputError, match="outside the allowed folders"):
        load_campaign(file).scan_path("../x.laz")
