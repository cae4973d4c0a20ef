"""Bad scans through the whole system: a clear error, a recorded state, and the other epochs processed.

One run over a campaign of misfortunes: a sound epoch, an epoch for every way in which one scan of five can be
bad, and a sound one at the end; scheme A alone, to be quick.
"""

import re
import shutil
import struct
from collections.abc import Callable, Mapping
from pathlib import Path

import laspy
import numpy as np
import pytest

from tasks.ingest import read_scan
from tests.faults.conftest import STATIONS
from tests.faults.sites import FIRST, SECOND, Site, epoch_text, head_of, state_of, stations_of
from tests.flows.calls import Called
from tests.unit.ingest.clouds import write_las

LAST = "last"
BAD = "ST01"
SOUND_STATIONS = {f"ST{number:02d}" for number in range(2, STATIONS + 1)}


def nothing_there(scan: Path) -> Path:
    scan.unlink()
    return scan


def a_folder(scan: Path) -> Path:
    scan.unlink()
    scan.mkdir()
    return scan


def without_points(scan: Path) -> Path:
    return write_las(scan, np.empty((0, 3)))


def header_only(scan: Path) -> Path:
    return _text(scan, "x,y,z\n")


def jpeg(scan: Path) -> Path:
    scan.write_bytes(b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01" + bytes(range(256)) * 20)
    return scan


def makers_format(scan: Path) -> Path:
    return scan.rename(scan.with_suffix(".fls"))


def cut_at(share: float) -> Callable[[Path], Path]:
    def cut(scan: Path) -> Path:
        content = scan.read_bytes()
        scan.write_bytes(content[: int(share * len(content))])
        return scan

    return cut


def fewer_points_than_stated(scan: Path) -> Path:
    las = write_las(scan.with_suffix(".las"), read_scan(scan).points_m)
    content = bytearray(las.read_bytes())
    (count,) = struct.unpack_from("<Q", content, 247)
    struct.pack_into("<Q", content, 247, count + 1)
    las.write_bytes(content)
    return las


def nan_in_text(scan: Path) -> Path:
    rows = [f"{x:.4f},{y:.4f},{z:.4f}" for x, y, z in read_scan(scan).points_m[:2000]]
    rows[1000] = "nan,nan,nan"
    return _text(scan, "x,y,z\n" + "\n".join(rows) + "\n")


def nan_in_header(scan: Path) -> Path:
    content = bytearray(scan.read_bytes())
    struct.pack_into("<d", content, 155, np.nan)
    scan.write_bytes(content)
    return scan


def in_feet_and_says_so(scan: Path) -> Path:
    points_ft = read_scan(scan).points_m / 0.3048
    wkt = 'PROJCS["site",UNIT["foot",0.3048]]'
    vlr = laspy.VLR("LASF_Projection", 2112, "wkt", wkt.encode() + b"\0")
    return write_las(scan, points_ft, vlrs=(vlr,))


def _text(scan: Path, text: str) -> Path:
    scan.unlink()
    path = scan.with_suffix(".csv")
    path.write_text(text, encoding="utf-8")
    return path


MISFORTUNES: Mapping[str, tuple[Callable[[Path], Path], str]] = {
    "missing": (nothing_there, "no such file; check the path in the campaign file"),
    "folder": (a_folder, "is a folder; name the scan itself in the campaign file"),
    "empty-laz": (without_points, "holds no points; export the scan again"),
    "empty-csv": (
        header_only,
        "needs rows of three numbers, came none in its first 1 lines; export it again",
    ),
    "jpeg": (
        jpeg,
        "needs a LAS or LAZ file, which begins with 'LASF', came .*; check the file, or export it again",
    ),
    "fls": (makers_format, "came .fls, which is a maker's raw format; export E57 or LAZ"),
    "cut-10": (cut_at(0.1), "cut short.*(copy|export)"),
    "cut-50": (cut_at(0.5), "cut short.*(copy|export)"),
    "cut-99": (cut_at(0.99), "cut short.*(copy|export)"),
    "count": (
        fewer_points_than_stated,
        r"needs the \d+ points that its header states, came room for \d+ points",
    ),
    "nan-csv": (nan_in_text, "came 1 of 2000 points with NaN or infinity; remove those points"),
    "nan-las": (nan_in_header, "finite offsets, came .*nan.*; the header is damaged, export the scan again"),
    "feet-stated": (in_feet_and_says_so, "needs coordinates in metre, came foot .* convert"),
}


@pytest.fixture(scope="module")
def misfortunes(sound: Site, tmp_path_factory: pytest.TempPathFactory) -> Site:
    site = Site(tmp_path_factory.mktemp("misfortunes") / "campaign")
    shutil.copytree(sound.folder, site.folder)
    text = site.text()
    stations = stations_of(text, SECOND)
    epochs = [epoch_text(FIRST, -1, stations_of(text, FIRST))]
    for month, (name, (spoil, _)) in enumerate(MISFORTUNES.items()):
        shutil.copytree(site.folder / SECOND, site.folder / name)
        spoiled = spoil(site.folder / name / f"{BAD}.laz")
        files = {station["id"]: f"{name}/{station['id']}.laz" for station in stations}
        files[BAD] = f"{name}/{spoiled.name}"
        epochs.append(
            epoch_text(name, month, [{**table, "scan": files[str(table["id"])]} for table in stations])
        )
    epochs.append(epoch_text(LAST, len(MISFORTUNES), stations))
    site.file.write_text(head_of(text) + "\n".join(epochs), encoding="utf-8")
    return site


@pytest.fixture(scope="module")
def told(misfortunes: Site) -> Called:
    return misfortunes.run("--scheme", "A", "--json")


def test_bad_scans_end_with_exit_code_3(told: Called) -> None:
    assert (told.code, told.answer["ok"], told.answer["exit_code"]) == (3, False, 3)


def test_epochs_before_and_after_bad_ones_are_processed(told: Called, misfortunes: Site) -> None:
    expected = {FIRST: "ok", **dict.fromkeys(MISFORTUNES, "degraded"), LAST: "ok"}
    assert {epoch["epoch"]: epoch["state"] for epoch in told.answer["epochs"]} == expected
    assert misfortunes.states().items() >= expected.items()


@pytest.mark.parametrize("name", MISFORTUNES)
def test_the_error_names_epoch_station_file_fault_and_way_out(told: Called, name: str) -> None:
    (error,) = state_of(told, name)["errors"]
    says = MISFORTUNES[name][1]
    assert re.fullmatch(rf"station {BAD}: \S+/{name}/{BAD}\.(laz|las|csv|fls): .*{says}.*", error), error
    assert f"error: {name}: {error}\n" in told.err


@pytest.mark.parametrize("name", MISFORTUNES)
def test_the_bad_station_is_recorded_and_the_rest_of_its_epoch_is_processed(
    told: Called, misfortunes: Site, name: str
) -> None:
    epoch, stations = misfortunes.epoch(name), misfortunes.stations(name)
    assert (epoch.state, epoch.n_stations, epoch.n_stations_used) == ("degraded", STATIONS, STATIONS - 1)
    assert epoch.reason == f"station {BAD}: {stations[BAD].reason}"
    assert {station for station, row in stations.items() if row.state == "failed"} == {BAD}
    assert misfortunes.schemes(name)["A/robust"].state == "ok"
    assert misfortunes.tilts(name)["A/robust"].n_centres > 50


def test_the_ledger_says_which_scans_were_refused_and_why(told: Called, misfortunes: Site) -> None:
    refused = misfortunes.query(
        "select epoch, reason from runs where run = ? and stage = ? and outcome = 'refused'",
        (told.answer["run"], f"ingest {BAD}"),
    )
    # what is not there cannot be asked for
    assert {epoch for epoch, _ in refused} == MISFORTUNES.keys() - {"missing", "folder"}
    assert all(reason for _, reason in refused)


def test_the_same_rest_of_an_epoch_is_computed_once_for_all_bad_ones(told: Called, misfortunes: Site) -> None:
    counted = misfortunes.query(
        "select count(*) from runs where run = ? and stage = 'registration' and state = 'computed'",
        (told.answer["run"],),
    )
    assert counted == [(1,)]


def test_a_second_run_says_the_same_from_the_cache(told: Called, misfortunes: Site) -> None:
    again = misfortunes.run("--epoch", "cut-50", "--scheme", "A", "--json")
    assert (again.code, again.answer["stages"]["computed"]) == (3, 0)
    assert state_of(again, "cut-50")["errors"] == state_of(told, "cut-50")["errors"]


def test_without_json_the_errors_and_the_results_are_told(misfortunes: Site, told: Called) -> None:
    plain = misfortunes.run("--epoch", "jpeg", "--epoch", LAST, "--scheme", "A")
    assert plain.code == 3
    assert "error: jpeg: station ST01: " in plain.err
    assert f"\n{LAST}: ok, " in plain.out
