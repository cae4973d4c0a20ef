"""A brick or concrete chimney as in the paper: 110 m, tapered, with a platform and a ladder."""

from typing import Final

from tasks.simulation.kinds.case import SimulatedKind
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.shape import ShaftShape
from tasks.simulation.structure import Fittings

CASE: Final = SimulatedKind(
    name="chimney",
    shape=ShaftShape(),
    movement=Movement(),
    layout=Layout(),
    fittings=Fittings(),
    limits=("gb50078-concrete-quoted",),
)
