"""How a probability is written in a sentence."""

from typing import Final

LEAST: Final = 1e-4
"""Below this no model of ours is good enough to tell one from another."""


def p_text(p: float) -> str:
    """Write a probability with its name: ``p = 0.031``, or ``p < 0.0001``."""
    return f"p < {LEAST:g}" if p < LEAST else f"p = {p:.2g}"
