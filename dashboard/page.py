"""A page of the dashboard, and all of them, found by themselves: one file of ``dashboard/pages`` each."""

import importlib
import pkgutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from dashboard.panel import Panel
from dashboard.view import View

Fill: TypeAlias = Callable[[View], Sequence[Panel]]

FOLDER = "dashboard.pages"


@dataclass(frozen=True, slots=True)
class Page:
    """What stands at an address: ``fill`` makes its panels.

    ``place`` orders the pages and is their key on the keyboard, 1 to 9 and 0. ``asks`` is the question it answers.
    """

    name: str
    place: int
    title: str
    asks: str
    fill: Fill


@cache
def pages() -> Mapping[str, Page]:
    """All pages by name, in their order.

    Raises
    ------
    TypeError
        If two files claim one name, or one lacks its ``PAGE``.
    """
    home = importlib.import_module(FOLDER)
    found: dict[str, Page] = {}
    for info in pkgutil.iter_modules(home.__path__):
        page = getattr(importlib.import_module(f"{FOLDER}.{info.name}"), "PAGE", None)
        if not isinstance(page, Page) or page.name in found:
            raise TypeError(f"{FOLDER}.{info.name} needs a PAGE of a name of its own")
        found[page.name] = page
    return dict(sorted(found.items(), key=lambda item: item[1].place))
