"""Attributes of page elements that are no names of Python: ``data-...`` and ``aria-...``."""

from typing import Any, Final


def attributes(**values: str) -> dict[str, Any]:
    """Return attributes with ``_`` in their names written as ``-``, to be unpacked into an element."""
    return {name.replace("_", "-"): value for name, value in values.items()}


HIDDEN: Final = attributes(aria_hidden="true")
"""For signs that repeat a word beside them: readers of screens pass over."""
