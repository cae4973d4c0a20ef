"""What the stages of a run import, imported while the workflow server starts: for that the run waits anyhow."""

import importlib
from contextlib import suppress
from threading import Thread
from typing import Final

MODULES: Final = (
    "laspy",
    "tasks.geometry.compiled",
    "scipy.linalg",
    "scipy.spatial",
    "scipy.special",
    "scipy.stats",
    "scipy.optimize",
    "scipy.interpolate",
)
"""The slow ones; a stage that needs another imports it when it comes to it."""


def begin_imports() -> None:
    """Import them in a thread that nobody waits for; one that cannot be imported is told of by the stage that needs it."""
    Thread(target=_import_all, name="early imports", daemon=True).start()


def _import_all() -> None:
    for name in MODULES:
        with suppress(Exception):
            importlib.import_module(name)
