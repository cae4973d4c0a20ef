"""How a structure is scanned: from how far, and which part of it is sliced."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Layout:
    """Distances of a survey, metres; the defaults are those of a chimney of 110 m.

    Stations stand between the two ``distance_m`` from the foot, and are set up again in a later epoch within
    ``new_place_m`` east and north of there. The fine window reaches ``margin_m`` beyond the structure. The part that is
    sliced begins at ``shaft_foot_m`` and ends ``below_top_m`` below the platform, or the top where there is none.
    """

    distance_m: tuple[float, float] = (200.0, 300.0)
    new_place_m: float = 4.0
    margin_m: float = 2.5
    shaft_foot_m: float = 2.0
    below_top_m: float = 0.09
