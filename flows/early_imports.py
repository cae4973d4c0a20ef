"""What stages need before they begin, had while the workflow server starts: for that the run waits anyhow."""

import importlib
import logging
import sys
from contextlib import suppress
from threading import Thread
from typing import Final

_LOG: Final = logging.getLogger(__name__)

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
    """Import them in a thread that nobody waits for, and load compiled loops; a stage that needs what failed tells of it."""
    Thread(target=_import_all, name="early imports", daemon=True).start()


def find_versions() -> None:
    """Find the version of every stage's code, where it is not remembered: sources are parsed for that."""
    # they import what stages need, beside the import of Prefect
    from tasks import stages  # noqa: PLC0415
    from tasks.caching import Stage  # noqa: PLC0415
    from tasks.code_version import code_version  # noqa: PLC0415

    for known in vars(stages).values():
        if isinstance(known, Stage):
            code_version(known.fn)


def keep_what_was_compiled() -> None:
    """Put down which compiled loops this process needed, for ``begin_imports`` of the next one."""
    if "tasks.geometry.compiled" in sys.modules:
        from tasks.geometry.compiled_forms import keep_forms  # noqa: PLC0415 (numba is slow to import)

        try:
            keep_forms()
        except Exception:  # the run is done and good: what the next one loads sooner is no part of it
            _LOG.warning("which compiled loops were needed cannot be kept", exc_info=True)


def _import_all() -> None:
    for name in MODULES:
        with suppress(Exception):
            importlib.import_module(name)
    with suppress(Exception):
        from tasks.geometry.compiled_forms import load_forms  # noqa: PLC0415 (numba is slow to import)

        load_forms()
