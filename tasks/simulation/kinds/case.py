"""What a simulation case of a kind of structure consists of."""

from dataclasses import dataclass, field
from typing import Final

from tasks.simulation.attachments import Attachments
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.scanner import Scanner
from tasks.simulation.shape import ShaftShape
from tasks.simulation.site import Surroundings
from tasks.simulation.structure import Fittings
from tasks.simulation.wall import Wall

BEYOND_M: Final = 1e4
"""Higher than anything: a platform or a ladder that is to be left out begins there."""

BARE: Final = Fittings(platform_z_m=BEYOND_M, ladder_foot_m=BEYOND_M)
"""Neither platform nor ladder."""


@dataclass(frozen=True, slots=True)
class SimulatedKind:
    """A usual structure of a kind, what is on it, how it moves, and how a crew scans it.

    ``limits`` are the shipped tables of limits that say something of such a structure; the first one counts.
    """

    name: str
    shape: ShaftShape
    movement: Movement
    layout: Layout
    fittings: Fittings = BARE
    wall: Wall | None = None
    attachments: Attachments | None = None
    scanner: Scanner = field(default_factory=Scanner)
    surroundings: Surroundings = field(default_factory=Surroundings)
    limits: tuple[str, ...] = ()
