"""A simulation case of every kind of structure, one file each."""

from dataclasses import replace
from typing import Final

from tasks.geometry.variants import choose, discover
from tasks.simulation.campaign import SimulatedCampaignRequest
from tasks.simulation.kinds.case import SimulatedKind
from tasks.simulation.wall import Wall

CASES: Final = discover(__name__, "CASE", SimulatedKind)
"""Cases by name of the kind, found by themselves: a module of this folder that has ``CASE``."""


def request_of_kind(
    kind: str, epochs: int = 4, stations: int = 8, points: int = 200_000, seed: int = 1
) -> SimulatedCampaignRequest:
    """What to simulate for a structure of a kind.

    Raises
    ------
    InputError
        If there is no such kind; the message lists the known ones.
    UsageError
        If there is nothing to simulate.
    """
    case = choose(CASES, kind, "kind of structure")
    return SimulatedCampaignRequest(
        epochs=epochs,
        stations=stations,
        points=points,
        seed=seed,
        shape=case.shape,
        movement=case.movement,
        scanner=case.scanner,
        fittings=case.fittings,
        surroundings=case.surroundings,
        kind=case.name,
        limits=case.limits,
        layout=case.layout,
        wall=_wall_of(case, seed),
        attachments=case.attachments,
    )


def _wall_of(case: SimulatedKind, seed: int) -> Wall | None:
    """The wall of one structure of the kind: another seed is another structure."""
    wall = case.wall
    if wall is None or wall.bumps is None:
        return wall
    return replace(wall, bumps=replace(wall.bumps, seed=seed))


__all__ = ["CASES", "SimulatedKind", "request_of_kind"]
