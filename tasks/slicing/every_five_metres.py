"""Scheme B: a slice every five metres."""

from typing import Final

from tasks.slicing.scheme import SlicingScheme

SCHEME: Final = SlicingScheme("B", "every 5 m", interval_m=5.0)
