"""A steel tube of 40 m, 0.6 m wide at its foot and 0.4 m at its top, bent by the wind, with antennas and a ladder."""

from typing import Final

from tasks.simulation.attachments import Antenna, Attachments
from tasks.simulation.kinds.case import BEYOND_M, SimulatedKind
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.shape import Horizontal, ShaftShape
from tasks.simulation.structure import Fittings

CASE: Final = SimulatedKind(
    name="mast",
    shape=ShaftShape(
        height_m=40.0,
        radius_foot_m=0.3,
        radius_top_m=0.2,
        lean=Horizontal(0.004, 0.003),
        bend_top_m=Horizontal(0.04, -0.02),
        bend_form="cantilever",
    ),
    movement=Movement(azimuth_deg=50.0, lean_arcsec=(0.0, 40.0, 80.0, 160.0)),
    layout=Layout(distance_m=(30.0, 60.0), new_place_m=2.0, margin_m=0.6, shaft_foot_m=1.0, below_top_m=0.49),
    fittings=Fittings(
        platform_z_m=BEYOND_M,
        ladder_azimuth_deg=200.0,
        ladder_foot_m=3.0,
        ladder_width_m=0.4,
        ladder_standoff_m=0.15,
    ),
    attachments=Attachments(
        antennas=(
            Antenna(30.0, 20.0, 2.0, 0.35),
            Antenna(30.0, 140.0, 2.0, 0.35),
            Antenna(30.0, 260.0, 2.0, 0.35),
            Antenna(36.0, 80.0, 1.5, 0.3),
        )
    ),
)
