"""A monument column of 25 m, 1.5 m wide, with entasis, on a plinth, with a capital."""

from typing import Final

from tasks.simulation.attachments import Attachments
from tasks.simulation.kinds.case import BEYOND_M, SimulatedKind
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.shape import Horizontal, ShaftShape
from tasks.simulation.structure import Fittings
from tasks.simulation.wall import Bumps, Wall

CASE: Final = SimulatedKind(
    name="column",
    shape=ShaftShape(
        height_m=25.0,
        radius_foot_m=0.75,
        radius_top_m=0.62,
        taper_bow_m=0.025,
        lean=Horizontal(-0.006, 0.009),
    ),
    movement=Movement(azimuth_deg=330.0, lean_arcsec=(0.0, 60.0, 120.0, 240.0)),
    layout=Layout(distance_m=(20.0, 40.0), new_place_m=1.5, margin_m=0.8, shaft_foot_m=3.0, below_top_m=0.09),
    fittings=Fittings(
        platform_z_m=24.1,
        platform_width_m=0.35,
        platform_thickness_m=0.3,
        handrail_m=0.9,
        ladder_foot_m=BEYOND_M,
    ),
    wall=Wall(bumps=Bumps(sigma_m=0.002, tall_m=0.8, wide_m=0.3), ring_step_m=0.25),
    attachments=Attachments(plinth_m=(1.6, 2.5)),
)
