"""Square and rectangular towers: four plane faces, position read off a plan; the radius is half the side."""

from typing import Final

from tasks.preprocessing.kinds.kind import StructureKind

KIND: Final = StructureKind(
    name="square-tower", position_slack_m=1.5, max_lean=0.05, n_faces=4, robust_contour="polygon"
)
