"""A commented plan file to begin with, for every kind of round structure."""

from typing import Final

from storage.errors import UsageError
from tasks.settings.example import COMMENT, COMMENT_COLUMN, KINDS, SIZES
from tasks.settings.problems import nearest

TEMPLATE: Final = """\
# A survey to come: `tiltwatch plan FILE` predicts what it will give.
schema_version = 1

[structure]
id = "{kind}-01"
kind = "{kind}"
height_m = {height}                 # the change that will be detectable is stated at this height
shaft_z_m = [{low}, {height}]       # lower and upper end of the part that is measured
radius_m = [{bottom}, {top}]        # radius at the two ends

[instrument]                        # what the maker states, as standard deviations
range_sigma_m = 0.005               # at 100 m
angle_sigma_deg = 0.001
level_sigma_deg = 0.0008            # of each component of the level
position_sigma_m = [0.015, 0.0225]  # GNSS, horizontal and vertical
heading_sigma_deg = 0.15

[plan]
count = 4                           # stations evenly around; or azimuths_deg = [0.0, 100.0, 200.0]
distance_m = {distance}             # from the axis
# stations = [{{ id = "ST01", position_m = [0.0, {distance}, 1.6] }}]   # instead of count and distance_m
spacing_deg = 0.02                  # step of the scanner; or points_per_station = 100000, on the shaft
# hidden = [{{ azimuth_deg = [80.0, 130.0], below_m = {hidden} }}]   # of the surface, clockwise, seen from the axis
# form_m = 0.01                     # what patches of 5 m by 10 degrees are off a circle
primary = ["S", "surface"]          # the lean will come from this: the whole surface; or ["A", "robust"], ...
"""


def example_plan(kind: str) -> str:
    """Write a commented plan file of a kind; it passes ``load_plan`` as it stands.

    Raises
    ------
    UsageError
        If there is no such kind, or it is not round.
    """
    known = [name for name in KINDS if name != "square-tower"]
    if kind not in known:
        raise UsageError(f"no plan for kind {kind!r}; {nearest(kind, known)}")
    size = SIZES[kind]
    text = TEMPLATE.format(
        kind=kind,
        height=size.height_m,
        low=max(round(size.height_m / 50.0, 1), 0.3),
        bottom=size.radius_m[0],
        top=size.radius_m[1],
        distance=size.distance_m,
        hidden=round(size.height_m / 4.0, 1),
    )
    return COMMENT.sub(lambda line: f"{line[1] + ' ':<{COMMENT_COLUMN}}{line[2]}", text)
