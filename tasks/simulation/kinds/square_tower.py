"""A brick tower of 45 m, 6 m wide, that narrows a little, with a gallery and a lightning ladder."""

from typing import Final

from tasks.simulation.kinds.case import SimulatedKind
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.shape import Horizontal, ShaftShape
from tasks.simulation.site import Surroundings
from tasks.simulation.structure import Fittings
from tasks.simulation.wall import Bumps, Wall

CASE: Final = SimulatedKind(
    name="square-tower",
    shape=ShaftShape(
        height_m=45.0,
        radius_foot_m=3.1,
        radius_top_m=2.9,
        lean=Horizontal(0.008, -0.005),
    ),
    movement=Movement(azimuth_deg=210.0, lean_arcsec=(0.0, 60.0, 120.0, 240.0)),
    layout=Layout(distance_m=(40.0, 80.0), new_place_m=3.0, shaft_foot_m=1.0, below_top_m=0.09),
    fittings=Fittings(platform_z_m=42.1, platform_width_m=2.0, ladder_azimuth_deg=25.0, ladder_width_m=0.4),
    wall=Wall(
        bumps=Bumps(sigma_m=0.003, tall_m=0.6, wide_m=0.6), faces=4, face_azimuth_deg=25.0, ring_step_m=0.25
    ),
    surroundings=Surroundings(keep_off_m=10.0),
)
