"""Tanks: wide and low, position read off a plan."""

from typing import Final

from tasks.preprocessing.kinds.kind import StructureKind

KIND: Final = StructureKind(name="tank", position_slack_m=2.0, max_lean=0.05)
