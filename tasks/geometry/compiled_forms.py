"""Which forms of the compiled loops runs needed, so that the next one has them before a stage asks.

A function is compiled for the types that it meets: a form of it. To load one that was compiled before takes some
hundredths of a second of one core, and stages need dozens.
"""

import importlib
import pickle
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from storage.errors import StorageError
from tasks.geometry.compiled import FOLDER, MADE

NAME: Final = "forms.pickle"
"""Beside the machine code of these forms, where nobody else can write (tasks/geometry/compiled.py)."""

Forms = dict[tuple[str, str], set[Any]]
"""Argument types by the module and the name of a function."""


def keep_forms(folder: Path | None = FOLDER) -> None:
    """Put down what this process used, beside what others did; where that cannot be written it is loaded when needed."""
    from storage.atomic import write_atomically  # noqa: PLC0415 (the kernels need nothing of storage)

    if folder is None:
        return
    used: Forms = {(one.__module__, one.__name__): set(one.signatures) for one in MADE if one.signatures}
    known = _kept_in(folder)
    both = {name: known.get(name, set()) | used.get(name, set()) for name in known.keys() | used.keys()}
    if both != known:
        with suppress(StorageError):
            write_atomically(folder / NAME, pickle.dumps(both))


def load_forms(folder: Path | None = FOLDER) -> None:
    """Load what processes before this one used."""
    if folder is None:
        return
    for (module, name), forms in _kept_in(folder).items():
        function = getattr(importlib.import_module(module), name)
        for form in forms:
            function.compile(form)


def _kept_in(folder: Path) -> Forms:
    """What is put down; nothing where that cannot be read, as of another version of numba."""
    with suppress(Exception):
        found = pickle.loads((folder / NAME).read_bytes())  # noqa: S301 (where machine code lies that is run, too)
        if isinstance(found, dict) and all(isinstance(forms, set) for forms in found.values()):
            return found
    return {}
