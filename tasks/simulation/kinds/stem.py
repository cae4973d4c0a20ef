"""The stem of a tree of 12 m, 0.3 m wide, with taper, sweep, rough bark and branches that hide it higher up."""

from typing import Final

from tasks.simulation.attachments import Attachments
from tasks.simulation.kinds.case import SimulatedKind
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.shape import Horizontal, ShaftShape
from tasks.simulation.wall import Bumps, Wall

CASE: Final = SimulatedKind(
    name="stem",
    shape=ShaftShape(
        height_m=12.0,
        radius_foot_m=0.16,
        radius_top_m=0.07,
        lean=Horizontal(0.03, -0.02),
        bend_top_m=Horizontal(-0.12, 0.08),
        bend_form="sweep",
    ),
    movement=Movement(azimuth_deg=120.0, lean_arcsec=(0.0, 900.0, 1800.0, 3600.0)),
    layout=Layout(distance_m=(6.0, 12.0), new_place_m=0.5, margin_m=0.4, shaft_foot_m=1.0, below_top_m=3.99),
    wall=Wall(bumps=Bumps(sigma_m=0.005, tall_m=0.3, wide_m=0.04), ring_step_m=0.05),
    attachments=Attachments(branches=40, branches_from_m=4.0),
)
