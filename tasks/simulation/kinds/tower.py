"""A concrete telecommunication tower of 110 m: its radius steps in twice, platforms with antennas stand around it."""

from typing import Final

from tasks.simulation.attachments import Antenna, Attachments
from tasks.simulation.kinds.case import SimulatedKind
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.shape import Horizontal, ShaftShape
from tasks.simulation.structure import Fittings
from tasks.simulation.wall import Wall

CASE: Final = SimulatedKind(
    name="tower",
    shape=ShaftShape(
        height_m=110.0,
        radius_foot_m=5.0,
        radius_top_m=3.2,
        lean=Horizontal(-0.0012, 0.0008),
        bend_top_m=Horizontal(0.02, 0.01),
        bend_form="cantilever",
    ),
    movement=Movement(azimuth_deg=300.0, lean_arcsec=(0.0, 15.0, 30.0, 60.0)),
    layout=Layout(distance_m=(120.0, 220.0)),
    fittings=Fittings(platform_z_m=100.1, platform_width_m=1.5, ladder_azimuth_deg=70.0),
    wall=Wall(profile_m=((40.0, 0.0), (40.0, -0.35), (75.0, -0.35), (75.0, -0.6)), ring_step_m=1.0),
    attachments=Attachments(
        platforms_m=((40.0, 1.4), (75.0, 1.6), (88.0, 1.2)),
        antennas=(
            Antenna(76.5, 30.0, 2.2, 0.9),
            Antenna(76.5, 150.0, 2.2, 0.9),
            Antenna(76.5, 270.0, 2.2, 0.9),
            Antenna(89.0, 90.0, 1.8, 0.7),
            Antenna(89.0, 210.0, 1.8, 0.7),
        ),
    ),
    limits=("bre-digest-475", "aci117-general"),
)
