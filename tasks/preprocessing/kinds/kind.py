"""What a kind of structure allows its shaft to do."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StructureKind:
    """A kind of structure, as the search for its shaft sees it.

    ``position_slack_m`` is how far off ``base_xy_m`` may be, ``max_lean`` the largest horizontal run of the
    axis per metre of height that is searched, ``radius_window`` the searched radii as multiples of the prior's.
    ``unsupported_because`` is empty for a kind with a round shaft.
    """

    name: str
    position_slack_m: float
    max_lean: float
    radius_window: tuple[float, float] = (0.6, 1.5)
    unsupported_because: str = ""
