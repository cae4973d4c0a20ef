"""Columns: thin, neighbours may be near."""

from typing import Final

from tasks.preprocessing.kinds.kind import StructureKind

KIND: Final = StructureKind(name="column", position_slack_m=0.6, max_lean=0.05)
