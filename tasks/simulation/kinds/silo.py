"""A silo of 8 m by 40 m on legs, with a hopper below, a roof on top and a stair tower that hides a part of it."""

from typing import Final

from tasks.simulation.attachments import Annex, Attachments
from tasks.simulation.kinds.case import BEYOND_M, SimulatedKind
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.shape import Horizontal, ShaftShape
from tasks.simulation.site import Surroundings
from tasks.simulation.structure import Fittings
from tasks.simulation.wall import Wall

HOPPER_TOP_M: Final = 7.0

CASE: Final = SimulatedKind(
    name="silo",
    shape=ShaftShape(
        height_m=40.0,
        radius_foot_m=4.0,
        radius_top_m=4.0,
        lean=Horizontal(0.003, -0.002),
        ovality=0.002,
    ),
    movement=Movement(azimuth_deg=20.0, lean_arcsec=(0.0, 40.0, 80.0, 160.0)),
    layout=Layout(distance_m=(60.0, 100.0), new_place_m=3.0, shaft_foot_m=8.0, below_top_m=0.49),
    fittings=Fittings(platform_z_m=BEYOND_M, ladder_azimuth_deg=300.0, ladder_foot_m=8.5),
    wall=Wall(profile_m=((2.0, -3.6), (HOPPER_TOP_M, 0.0)), roof_m=1.6, ring_step_m=1.0),
    attachments=Attachments(annex=Annex(200.0, 3.0, 41.0), legs=8, legs_top_m=HOPPER_TOP_M),
    surroundings=Surroundings(keep_off_m=10.0),
)
