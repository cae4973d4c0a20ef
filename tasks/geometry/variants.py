"""Find the variants of a thing: one file each, found by itself, a wrong name answered with the known ones."""

import importlib
import importlib.util
import pkgutil
import re
from collections.abc import Mapping
from importlib.abc import InspectLoader
from typing import Final, TypeVar

from storage.errors import InputError

T = TypeVar("T")

COMPILED: Final = ("kernel", "kernels")
"""Endings of modules that hold compiled loops: no variants, and slow to import."""


def discover(package: str, attribute: str, kind: type[T]) -> dict[str, T]:
    """Collect ``attribute`` of every module of ``package`` that has it, by the variant's own ``name``.

    Raises
    ------
    TypeError
        If an attribute is not of type ``kind``, two modules claim one name, or one that is named as if it held compiled
        loops has the attribute.
    """
    found: dict[str, T] = {}
    home = importlib.import_module(package)
    for module in sorted(info.name for info in pkgutil.iter_modules(home.__path__)):
        if module.endswith(COMPILED):
            _refuse_variant(package, module, attribute)
            continue
        variant = getattr(importlib.import_module(f"{package}.{module}"), attribute, None)
        if variant is None:
            continue
        if not isinstance(variant, kind):
            raise TypeError(
                f"{package}.{module}.{attribute} needs type {kind.__name__}, got {type(variant).__name__}"
            )
        name = variant.name  # type: ignore[attr-defined]
        if name in found:
            raise TypeError(f"{package}.{module} claims the name {name!r} that another module has")
        found[name] = variant
    return found


def _refuse_variant(package: str, module: str, attribute: str) -> None:
    """Refuse a variant that would be overlooked; its source is looked at, not imported."""
    spec = importlib.util.find_spec(f"{package}.{module}")
    loader = None if spec is None else spec.loader
    source = loader.get_source(f"{package}.{module}") if isinstance(loader, InspectLoader) else None
    if re.search(rf"^{attribute}\s*[:=]", source or "", re.MULTILINE):
        raise TypeError(
            f"{package}.{module} has a {attribute}, but a module whose name ends in {' or '.join(COMPILED)} holds compiled "
            "loops and is no variant; name it otherwise"
        )


def choose(variants: Mapping[str, T], name: str, what: str) -> T:
    """Return the variant of that name.

    Raises
    ------
    InputError
        If there is none; the message lists the known names.
    """
    if name not in variants:
        raise InputError(f"unknown {what} {name!r}; known: {', '.join(sorted(variants))}")
    return variants[name]
