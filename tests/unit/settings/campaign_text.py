"""A campaign file with one of everything, as the contract shows it."""

from pathlib import Path

from tasks.settings import Campaign, load_campaign

WHOLE = """\
schema_version = 1
[structure]
id = "chimney-01"
name = "Heritage chimney"
kind = "chimney"
height_m = 102.0
shaft_z_m = [2.0, 102.0]
base_xy_m = [0.0, 0.0]
radius_m = [4.6, 2.7]
[frame]
axes = "ENU"
horizontal = "local"
origin_m = [0.0, 0.0, 0.0]
[instrument]
range_sigma_m = 0.005
angle_sigma_deg = 0.001
level_sigma_deg = 0.0008
position_sigma_m = [0.015, 0.0225]
heading_sigma_deg = 0.15
[[epochs]]
id = "e1"
time = 2025-03-14T06:00:00+08:00
reference = true
[[epochs.stations]]
id = "ST01"
scan = "e1/ST01.laz"
position_m = [231.4, -12.9, 1.61]
heading_deg = 271.3
coordinates = "cartesian"
[[epochs.stations]]
id = "ST02"
scan = "e1/ST02.laz"
position_m = [-12.9, 231.4, 1.61]
heading_deg = 180.0
[[epochs.references]]
source = "total station"
lean_east = 0.00726
lean_north = -0.00571
sigma = 0.00005
[[epochs]]
id = "e2"
time = 2026-03-11T06:00:00+08:00
registered = "e2/merged.laz"
[schemes.G]
interval_m = 2.5
[limits]
table = "gb50078-concrete-quoted"
verticality_m = [[100.0, 0.060], [120.0, 0.065]]
[report]
primary = ["S", "surface"]
control = ["F", "paper"]
"""

FEWEST = """\
schema_version = 1
[structure]
id = "pole"
kind = "mast"
height_m = 10.0
shaft_z_m = [0.5, 10.0]
radius_m = [0.2, 0.1]
[frame]
axes = "ENU"
[[epochs]]
id = "e1"
time = 2025-03-14T06:00:00Z
registered = "cloud.laz"
"""


def load(folder: Path, text: str) -> Campaign:
    """Write a campaign file and load it."""
    file = folder / "campaign.toml"
    file.write_text(text, encoding="utf-8")
    return load_campaign(file)


def edited(old: str, new: str, text: str = WHOLE) -> str:
    """The text with one place changed; the place must be there."""
    if old not in text:
        raise ValueError(f"{old!r} is not in the text")
    return text.replace(old, new, 1)
