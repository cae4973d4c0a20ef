"""How two stations of an epoch agree."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class PairRow:
    """Two stations of an epoch whose scans were compared: how much they share and how well it fits."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    station: Annotated[str, Column("id of the station whose planes were looked for in the other's scan")]
    other: Annotated[str, Column("id of the other station")]
    overlap: Annotated[float, Column("share of the station's sampled planes that match the other", "1")]
    n_matches: Annotated[int, Column("planes that match")]
    rmse_m: Annotated[
        float | None,
        Column(
            "robust scale of the distances along the normal at the adjusted poses; NULL with too few matches",
            "m",
        ),
    ]
    rmse_shaft_m: Annotated[
        float | None, Column("the same of the matches on the structure; NULL with too few of them", "m")
    ]
    rmse_background_m: Annotated[
        float | None, Column("the same of all other matches; NULL with too few of them", "m")
    ]
    closure_m: Annotated[
        float | None,
        Column(
            "worst loop through this pair and a third station, each pair adjusted alone: its translation at the "
            "structure; NULL where no loop closes",
            "m",
        ),
    ]
    closure_arcsec: Annotated[
        float | None, Column("worst of these loops: its angle; NULL where no loop closes", "arcsec")
    ]
