"""What a kind of structure allows its shaft to do."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StructureKind:
    """A kind of structure, as the search for its shaft sees it.

    ``position_slack_m`` is how far off ``base_xy_m`` may be, ``max_lean`` the largest horizontal run of the
    axis per metre of height that is searched, ``radius_window`` the searched radii as multiples of the prior's.
    ``n_faces`` is the number of plane faces, 0 for a round shaft; 4 is the only other number that is searched.
    ``robust_contour`` is the contour model that method robust needs for its sections; None where that of the slicing
    scheme will do.
    """

    name: str
    position_slack_m: float
    max_lean: float
    radius_window: tuple[float, float] = (0.6, 1.5)
    n_faces: int = 0
    robust_contour: str | None = None
