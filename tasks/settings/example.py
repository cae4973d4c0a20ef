"""A commented campaign file to begin with, for every kind of structure."""

import re
from dataclasses import dataclass
from typing import Final, get_args

from storage.errors import UsageError
from tasks.settings.problems import nearest
from tasks.settings.structure import Kind

KINDS: Final[tuple[str, ...]] = get_args(Kind)
"""What a structure can be."""


@dataclass(frozen=True, slots=True)
class Size:
    """Size of a usual structure of a kind, and how far away its scanner stands; metres."""

    height_m: float
    radius_m: tuple[float, float]
    distance_m: float


SIZES: Final = {
    "chimney": Size(102.0, (4.6, 2.7), 230.0),
    "tower": Size(60.0, (4.0, 3.0), 140.0),
    "silo": Size(40.0, (4.0, 4.0), 80.0),
    "tank": Size(20.0, (15.0, 15.0), 60.0),
    "mast": Size(40.0, (0.3, 0.2), 45.0),
    "column": Size(25.0, (0.75, 0.62), 30.0),
    "stem": Size(12.0, (0.16, 0.07), 10.0),
    "square-tower": Size(45.0, (3.1, 2.9), 60.0),
}

LOW_M: Final = 30.0
"""Of a structure below this the schemes A to F, of one slice every metre and fewer, leave few slices: it gets its own."""

SHIPPED: Final = {"chimney": "bre-digest-475", "tower": "bre-digest-475"}
"""Kinds that a shipped table of limits speaks of."""

TEMPLATE: Final = """\
# A campaign of tiltwatch: one structure, measured at several times.
# `tiltwatch check FILE` checks this file, `tiltwatch schema` prints all keys with bounds and meaning.
schema_version = 1

[structure]
id = "{kind}-01"                      # names files and tables: letters, digits, dots, underscores, hyphens
name = "Our {kind}"
kind = "{kind}"                       # {kinds}
height_m = {height}                   # H: the verticality deviation is stated at this height
shaft_z_m = [{low}, {height}]         # lower and upper end of the part that is sliced
base_xy_m = [0.0, 0.0]                # rough position of the foot; a prior only
radius_m = [{bottom}, {top}]          # rough radius at the two ends of shaft_z_m; a prior only{side}
# design_radius_m = [[0.0, {bottom}], [{height}, {top}]]  # designed shape, [height, radius], for surface_map
# design_lean = [0.0, 0.0]            # designed lean east, north; plumb where it is missing
# design_base_xy_m = [0.0, 0.0]       # designed axis at z = 0; where it is missing, it starts at the measured foot

[frame]
axes = "ENU"                          # order of x, y, z of positions: ENU (east, north, up) or NEU
horizontal = "local"                  # or a projected system such as "EPSG:32650", with origin_m near the foot
origin_m = [0.0, 0.0, 0.0]            # subtracted from positions before any work

[instrument]                          # what the maker states, as standard deviations
range_sigma_m = 0.005                 # at 100 m
angle_sigma_deg = 0.001
level_sigma_deg = 0.0008
position_sigma_m = [0.015, 0.0225]    # of station positions, horizontal and vertical
heading_sigma_deg = 0.15

[[epochs]]
id = "2025-03"
time = 2025-03-14T06:00:00+08:00      # with its offset from UTC
reference = true                      # changes are counted from this epoch
{stations}
# position_m and heading_deg may be left out where they are not known: they are then found from the shaft and the
# other stations. Of a file that holds several scans (E57, PTX), part = 2 or part = "NAME" says which one. In place
# of position_m and heading_deg, pose = "file" takes the position, heading and levelling that such a file states.

# The next time of measuring. Instead of stations, one cloud that is in the frame already:
# [[epochs]]
# id = "2026-03"
# time = 2026-03-11T06:00:00+08:00
# registered = "2026-03/merged.laz"

# A lean that was measured by other means, in the epoch above it; may serve as control:
# [[epochs.references]]
# source = "total station"
# lean_east = 0.00726
# lean_north = -0.00571
# sigma = 0.00005                     # of each component

# A slicing scheme of your own beside A to F and S:
{own}[schemes.G]
{own}interval_m = {interval}                      # or heights_m = [{low}, {height}]
# contour = "robust_circle"           # contour model and axis estimator of method robust: docs/variants.md
# axis = "robust_line"
# [schemes.H]
# adaptive = 0.002                    # slices just thick enough that every centre reaches this sigma

# Surroundings that do not move, away from the structure; they tie later epochs to the reference beside GNSS:
# [registration]
# stable = [{{ name = "hall", low_m = [{hall}, -10.0, -1.0], high_m = [{hall_end}, 10.0, 8.0] }}]

# How far from plumb it may be; without limits the verdict is "no limit". `tiltwatch limits` lists the shipped tables:
# [limits]
# {table}
# kind = "in-service"                 # what points of your own were written for: construction, design or in-service
# verticality_m = [[{half}, {half_limit}], [{height}, {limit}]]

[report]
primary = ["S", "surface"]            # the verdict comes from this scheme and method
control = ["F", "paper"]              # relative errors are counted against this

# What raises an alarm. Without [[alarms]] the rules of docs/monitoring.md hold, and nobody is told of them.
# [[alarms]]
# id = "too-far"
# when = "moved"                      # limit | share-of-limit | moved | rate | cusum | quality | missed-campaign |
# p = 0.001                           # late-station; the keys of each are in docs/monitoring.md
# severity = "alarm"                  # info | warning | alarm
# notify = ["office"]                 # ids of [[notify]] tables
# [[alarms]]
# id = "missed"
# when = "missed-campaign"
# interval_days = 182.0
# grace_days = 14.0
# notify = ["office"]
# [[notify]]
# id = "office"
# kind = "email"                      # email | webhook | command
# url_env = "TILTWATCH_MAIL_URL"      # the variable holds mailtos://USER:PASSWORD@HOST?to=...; no secrets in this file

# [files]
# roots = ["/data/scans"]             # folders outside this one that scans may come from
"""

COMMENT: Final = re.compile(r"^((?:# )?[a-z_]+ = \S.*?) +(# .*)$", re.MULTILINE)
COMMENT_COLUMN: Final = 42

STATION: Final = """
[[epochs.stations]]
id = "{id}"
scan = "2025-03/{id}.laz"
position_m = [{east}, {north}, 1.6]   # scanner's centre
heading_deg = {heading}                   # azimuth of the scanner's own +y axis, clockwise from north
"""

AZIMUTH_SIGNS: Final = ((0, 1), (1, 0), (0, -1), (-1, 0))
"""Four stations round the structure: north, east, south, west."""


def example_campaign(kind: str) -> str:
    """Write a commented campaign file of a kind; it passes ``load_campaign`` as it stands.

    Raises
    ------
    UsageError
        If there is no such kind; the message names the nearest one.
    """
    if kind not in KINDS:
        raise UsageError(f"unknown kind {kind!r}; {nearest(kind, KINDS)}")
    size = SIZES[kind]
    text = TEMPLATE.format(
        kind=kind,
        kinds=" | ".join(KINDS),
        height=size.height_m,
        half=size.height_m / 2,
        low=max(round(size.height_m / 50.0, 1), 0.3),
        bottom=size.radius_m[0],
        top=size.radius_m[1],
        side=" (half the side)" if kind == "square-tower" else "",
        stations="".join(_station(number, size.distance_m) for number in range(len(AZIMUTH_SIGNS))),
        interval=round(size.height_m / 40.0, 2),
        hall=round(1.2 * size.distance_m, 1),
        hall_end=round(1.2 * size.distance_m + 20.0, 1),
        table=_table(kind),
        own="" if size.height_m < LOW_M else "# ",
        limit=round(size.height_m / 1000.0, 3),
        half_limit=round(size.height_m / 2000.0, 4),
    )
    return _aligned(text)


def _table(kind: str) -> str:
    """The lines that name a shipped table, or say that none speaks of this kind."""
    if kind in SHIPPED:
        return (
            f'table = "{SHIPPED[kind]}"       # or points of your own, which win over it\n'
            '# also = ["aci117-general"]           # judged beside it'
        )
    return "No shipped table speaks of this kind. Points of your own, [height, deviation]; docs/limits.md for more:"


def _aligned(text: str) -> str:
    """Put the comments behind values into one column."""
    return COMMENT.sub(lambda line: f"{line[1]:<{COMMENT_COLUMN}}{line[2]}", text)


def _station(number: int, distance_m: float) -> str:
    east, north = AZIMUTH_SIGNS[number]
    heading = (180 + 90 * number) % 360
    return STATION.format(
        id=f"ST{number + 1:02d}", east=east * distance_m, north=north * distance_m, heading=f"{heading:.1f}"
    )
