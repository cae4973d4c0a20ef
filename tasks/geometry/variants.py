"""Find the variants of a thing: one file each, found by itself, a wrong name answered with the known ones."""

import importlib
import pkgutil
from collections.abc import Mapping
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
        If an attribute is not of type ``kind``, or two modules claim one name.
    """
    found: dict[str, T] = {}
    home = importlib.import_module(package)
    for module in sorted(info.name for info in pkgutil.iter_modules(home.__path__)):
        if module.endswith(COMPILED):
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
