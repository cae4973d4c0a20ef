"""Everything that is wrong with a campaign file is told at once: where, what, and what to do."""

from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.settings import load_campaign
from tests.unit.settings.campaign_text import FEWEST, WHOLE, edited, load

STATION_2 = "epochs[e1].stations[ST02]"

ONE_FAULT = [
    ("schema_version = 1", "schema_version = 2", "schema_version: should be 1, got 2"),
    ("height_m = 102.0", "heigth_m = 102.0", "structure.heigth_m: unknown key; did you mean 'height_m'?"),
    ("height_m = 102.0", "", "structure.height_m: is required; meaning: H: the height at which"),
    ("height_m = 102.0", "height_m = 0.0", "structure.height_m: should be greater than 0, got 0.0"),
    ("height_m = 102.0", 'height_m = "102"', "structure.height_m: needs a number, got '102'"),
    ("height_m = 102.0", "height_m = nan", "structure.height_m: needs a finite number, got nan"),
    ("height_m = 102.0", "height_m = true", "structure.height_m: needs a number, got true"),
    ("height_m = 102.0", "height_m = 4000.0", "structure.height_m: should be less than or equal to 1500"),
    ('kind = "chimney"', 'kind = "chimny"', "structure.kind: should be 'chimney', 'tower', 'silo'"),
    (
        "[2.0, 102.0]",
        "[102.0, 2.0]",
        "structure.shaft_z_m: needs the lower end first, got [102, 2]; write [lower",
    ),
    ("[4.6, 2.7]", "[4.6, -2.7]", "structure.radius_m[#2]: should be greater than 0, got -2.7"),
    ("[4.6, 2.7]", "[4.6]", "structure.radius_m[#2]: is required"),
    ("[4.6, 2.7]", "4.6", "structure.radius_m: needs an array, got 4.6"),
    ('id = "chimney-01"', 'id = "a b"', "structure.id: needs 1 to 64 letters, digits, dots"),
    ('id = "chimney-01"', 'id = "../x"', "structure.id: needs 1 to 64 letters, digits, dots"),
    ('id = "chimney-01"', 'id = "nul"', "structure.id: 'nul' cannot name a folder on every system"),
    ('axes = "ENU"\n', "", "frame.axes: is required; meaning: order of the coordinates"),
    ('axes = "ENU"', 'axes = "UEN"', "frame.axes: should be 'ENU' or 'NEU', got 'UEN'"),
    ('"local"', '"utm"', "frame.horizontal: needs 'local' or an EPSG code, got 'utm'"),
    (
        '"local"',
        '"EPSG:4326"',
        "frame.horizontal: EPSG:4326 counts in degrees; a frame needs metres; use a proj",
    ),
    (
        "time = 2025-03-14T06:00:00+08:00",
        "time = 2025-03-14T06:00:00",
        "epochs[e1].time: needs an offset from UTC",
    ),
    (
        "time = 2025-03-14T06:00:00+08:00",
        "time = 2025-03-14",
        "epochs[e1].time: needs a date and time with an off",
    ),
    ("2025-03-14T", "1025-03-14T", "epochs[e1].time: needs a year from 1960 to 2200, got 1025"),
    (
        'id = "e2"',
        'id = "e1"',
        "epochs[#2 e1].id: epoch id 'e1' is taken by epochs[#1 e1].id; choose another",
    ),
    (
        'id = "e2"',
        'id = "E1"',
        "epochs[E1].id: epoch id 'E1' is taken by epochs[e1].id (as 'e1'; only the case",
    ),
    (
        '"ST02"',
        '"ST01"',
        "stations[#2 ST01].id: station id 'ST01' is taken by epochs[e1].stations[#1 ST01].id",
    ),
    (
        "e1/ST02.laz",
        "e1/ST01.laz",
        f"{STATION_2}.scan: scan 'e1/ST01.laz' is already used by epochs[e1].stations[ST01].scan; name each scan once",
    ),
    (
        "e2/merged.laz",
        "e2/../e1/ST02.laz",
        "epochs[e2].registered: scan 'e2/../e1/ST02.laz' is already used by epochs[e1].stations[ST02].scan",
    ),
    ("e1/ST02.laz", "../ST02.laz", f"{STATION_2}.scan: '../ST02.laz' lies outside the allowed folders"),
    ("e1/ST02.laz", "/etc/passwd", f"{STATION_2}.scan: '/etc/passwd' lies outside the allowed folders"),
    (
        'registered = "e2/merged.laz"',
        "",
        "epochs[e2]: has neither stations nor a registered cloud; add [[epochs.",
    ),
    (
        "reference = true",
        'registered = "x.laz"',
        "epochs[e1]: has both stations and a registered cloud; keep one",
    ),
    (
        'registered = "e2/',
        'reference = true\nregistered = "e2/',
        "epochs[e2].reference: epochs[e1] is the reference",
    ),
    (
        "heading_deg = 180.0",
        "heading_deg = 500.0",
        f"{STATION_2}.heading_deg: should be less than or equal to 360",
    ),
    (
        "[231.4, -12.9",
        "[440231.4, -12.9",
        "stations[ST01].position_m: lies 440231 m from the origin; no scanner",
    ),
    (
        '"cartesian"',
        '"spherical"',
        "stations[ST01].coordinates: should be 'cartesian' or 'polar', got 'spherical'",
    ),
    ("[schemes.G]", "[schemes.A]", "schemes.A: the name is taken by the built-in scheme A; choose another"),
    ("[schemes.G]", "[schemes.s]", "schemes.s: the name is taken by the built-in scheme S; choose another"),
    (
        "interval_m = 2.5",
        "",
        "schemes.G: needs one of interval_m, heights_m, adaptive, surface, got none; write one of them",
    ),
    (
        "interval_m = 2.5",
        "interval_m = 2.5\nadaptive = 0.002",
        "schemes.G: needs one of interval_m, heights_m, adaptive, surface, got interval_m and adaptive",
    ),
    (
        "interval_m = 2.5",
        "adaptive = 0.002\nthickness_m = 0.1",
        "schemes.G: thickness_m has no meaning beside adaptive; drop one of the two",
    ),
    (
        "interval_m = 2.5",
        'interval_m = 2.5\ncontour = "elipse"',
        "schemes.G.contour: unknown contour model 'elipse'; did you mean 'ellipse'?",
    ),
    (
        "interval_m = 2.5",
        'interval_m = 2.5\naxis = "irl"',
        "schemes.G.axis: unknown axis estimator 'irl'; did you mean 'irls'?",
    ),
    (
        "interval_m = 2.5",
        'surface = "conee"',
        "schemes.G.surface: unknown surface model 'conee'; did you mean 'cone'?",
    ),
    (
        "interval_m = 2.5",
        'surface = "cone"\ncontour = "kasa"',
        "schemes.G: contour has no meaning beside surface; drop one of the two",
    ),
    (
        '["S", "surface"]',
        '["F", "robust"]',
        "report.primary: scheme 'F' has no method 'robust'; F goes with paper",
    ),
    (
        "interval_m = 2.5",
        "adaptive = 0.0",
        "schemes.G.adaptive: should be greater than or equal to 0.00001, got 0.0",
    ),
    ("interval_m = 2.5", 'adaptive = "2 mm"', "schemes.G.adaptive: needs a number, got '2 mm'"),
    (
        "interval_m = 2.5",
        "adaptive = { sigma_centre_m = 0.002 }",
        "schemes.G.adaptive.sigma_centre_m: unknown key; did you mean 'sigma_center_m'?",
    ),
    (
        "interval_m = 2.5",
        "adaptive = { most_thickness_m = 1.0 }",
        "schemes.G.adaptive.sigma_center_m: is required; meaning: wanted standard deviation",
    ),
    (
        "interval_m = 2.5",
        "adaptive = { sigma_center_m = 0.002, least_thickness_m = 3.0 }",
        "schemes.G.adaptive: least_thickness_m = 3 is above most_thickness_m = 2",
    ),
    (
        "interval_m = 2.5",
        "adaptive = { sigma_center_m = 0.002, most_thickness_m = 50.0, least_thickness_m = 0.02 }\n[schemes.I]\n"
        "adaptive = { sigma_center_m = 0.001, most_thickness_m = 50.1 }",
        "schemes.I.adaptive.most_thickness_m: should be less than or equal to 50",
    ),
    (
        '["S", "surface"]',
        '["G", "surface"]',
        "report.primary: scheme 'G' has no method 'surface'; G goes with paper or robust",
    ),
    (
        "interval_m = 2.5",
        "intervall_m = 2.5",
        "schemes.G.intervall_m: unknown key; did you mean 'interval_m'?",
    ),
    (
        "interval_m = 2.5",
        "interval_m = 101.0",
        "schemes.G.interval_m: 101 m leaves 1 slice on the 100 m of shaft",
    ),
    (
        "interval_m = 2.5",
        "heights_m = [5.0]",
        "schemes.G.heights_m: needs at least 2 heights for an axis, got 1",
    ),
    ("interval_m = 2.5", "heights_m = [9.0, 5.0]", "schemes.G.heights_m: must rise, each height once; sort"),
    ("interval_m = 2.5", "heights_m = [1.0, 5.0]", "schemes.G.heights_m: 1 lies outside shaft_z_m [2, 102]"),
    (
        "gb50078-concrete-quoted",
        "gb50078",
        "limits.table: unknown table of limits 'gb50078'; known: aci117-general",
    ),
    ("[120.0, 0.065]", "[90.0, 0.065]", "limits.verticality_m: heights must rise, each height once"),
    (
        '["S", "surface"]',
        '["Z", "robust"]',
        "report.primary: unknown scheme 'Z'; known: A, B, C, D, E, F, S, G",
    ),
    (
        '["S", "surface"]',
        '["S", "robust"]',
        "report.primary: scheme 'S' has no method 'robust'; S goes with surface",
    ),
    (
        '["S", "surface"]',
        '["A", "fast"]',
        "report.primary[#2]: should be 'paper', 'robust' or 'surface', got 'fast'",
    ),
    (
        '["F", "paper"]',
        '"gps"',
        "report.control: no epoch has a reference with source 'gps'; known: total station",
    ),
    ('["F", "paper"]', '["F"]', "report.control[#2]: is required"),
    ("[report]", "[reports]", "reports: unknown key; did you mean 'report'?"),
    (
        "[limits]",
        "[limits]\nheading_deg = 2.0",
        "limits.heading_deg: unknown key; 'heading_deg' belongs to [epochs.stat",
    ),
]


@pytest.mark.parametrize(("old", "new", "line"), ONE_FAULT)
def test_each_fault_is_told_in_its_place(tmp_path: Path, old: str, new: str, line: str) -> None:
    with pytest.raises(InputError, match=r"campaign\.toml: ") as caught:
        load(tmp_path, edited(old, new))
    assert line in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "campaign.toml"))


def test_grid_coordinates_need_an_origin(tmp_path: Path) -> None:
    text = edited('"local"', '"EPSG:32650"', edited("origin_m = [0.0, 0.0, 0.0]\n", ""))
    with pytest.raises(
        InputError, match="frame: horizontal 'EPSG:32650' needs origin_m; write the grid coord"
    ):
        load(tmp_path, text)


def test_campaign_without_epochs_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="epochs: is required"):
        load(tmp_path, FEWEST.split("[[epochs]]")[0])


def test_all_faults_of_a_file_are_told_at_once(tmp_path: Path) -> None:
    text = edited("height_m = 102.0", "heigth_m = 102.0")
    text = edited("e1/ST02.laz", "e1/ST01.laz", text)
    text = edited("time = 2026-03-11T06:00:00+08:00", "time = 2026-03-11T06:00:00", text)
    text = edited("[schemes.G]", "[schemes.A]", text)
    with pytest.raises(InputError, match="heigth_m") as caught:
        load(tmp_path, text)
    assert len(str(caught.value).splitlines()) == 5, "height_m missing, heigth_m unknown, scan, time, scheme"


def test_syntax_error_is_told_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"campaign.toml: line 4, column 8: invalid value; this is TOML"):
        load(tmp_path, edited('name = "Heritage chimney"', "name = Heritage"))


def test_key_given_twice_is_a_syntax_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"line 7, column \d+: cannot overwrite a value"):
        load(tmp_path, edited("height_m = 102.0", "height_m = 102.0\nheight_m = 103.0"))


def test_missing_file_names_the_command_that_writes_one(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"none\.toml: no such file; `tiltwatch init KIND FILE` writes an example"
    ):
        load_campaign(tmp_path / "none.toml")


def test_folder_is_no_campaign_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        load_campaign(tmp_path)


def test_scan_given_as_campaign_file_is_refused_as_no_text(tmp_path: Path) -> None:
    scan = tmp_path / "ST01.laz"
    scan.write_bytes(b"LASF\xff\xfe\x00")
    with pytest.raises(InputError, match=r"ST01\.laz: is not a text in UTF-8; give the TOML file"):
        load_campaign(scan)


def test_deeply_nested_text_is_refused_without_a_crash(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"campaign\.toml"):
        load(tmp_path, "x = " + "[" * 100_000)


def test_whole_file_has_no_fault(tmp_path: Path) -> None:
    assert load(tmp_path, WHOLE).schema_version == 1
