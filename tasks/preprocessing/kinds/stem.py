"""Stems of trees: thin, crooked, neighbours near, lean up to some degrees, girth unknown."""

from typing import Final

from tasks.preprocessing.kinds.kind import StructureKind

KIND: Final = StructureKind(name="stem", position_slack_m=0.4, max_lean=0.15, radius_window=(0.4, 1.7))
