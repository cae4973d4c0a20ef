"""Scheme D: a slice every twenty metres."""

from typing import Final

from tasks.slicing.scheme import SlicingScheme

SCHEME: Final = SlicingScheme("D", "every 20 m", interval_m=20.0)
