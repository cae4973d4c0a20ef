"""Square towers: planes per face, which nothing here fits yet."""

from typing import Final

from tasks.preprocessing.kinds.kind import StructureKind

KIND: Final = StructureKind(
    name="square-tower",
    position_slack_m=1.5,
    max_lean=0.05,
    unsupported_because="its faces are planes and the search is for round sections",
)
