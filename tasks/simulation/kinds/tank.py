"""A steel tank, 30 m wide and 20 m tall: courses that step in by a plate's thickness, a rim, a roof, a stair."""

from typing import Final

from tasks.simulation.kinds.case import SimulatedKind
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.shape import Horizontal, ShaftShape
from tasks.simulation.site import Surroundings
from tasks.simulation.structure import Fittings
from tasks.simulation.wall import Wall

COURSE_M: Final = 2.5
PLATE_STEP_M: Final = 0.002
"""So much thinner is the plate of every course than of the one below; inside they are flush."""

COURSES: Final = tuple(
    (COURSE_M * number, -PLATE_STEP_M * step) for number in range(1, 8) for step in (number - 1, number)
)

CASE: Final = SimulatedKind(
    name="tank",
    shape=ShaftShape(
        height_m=20.0,
        radius_foot_m=15.0,
        radius_top_m=15.0,
        lean=Horizontal(0.002, 0.0012),
        ovality=0.0006,
    ),
    movement=Movement(azimuth_deg=100.0, lean_arcsec=(0.0, 80.0, 160.0, 320.0)),
    layout=Layout(distance_m=(50.0, 80.0), new_place_m=3.0, shaft_foot_m=0.5, below_top_m=0.09),
    fittings=Fittings(
        platform_z_m=19.1,
        platform_width_m=0.8,
        ladder_azimuth_deg=240.0,
        ladder_foot_m=0.2,
        ladder_width_m=0.8,
    ),
    wall=Wall(profile_m=COURSES, roof_m=2.0, ring_step_m=0.5),
    surroundings=Surroundings(keep_off_m=20.0),
)
