"""Which formats there are for what: found in their folders, a wrong word answered with the known ones."""

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from functools import cache
from types import ModuleType
from typing import BinaryIO, Final, cast

from storage.drawing.content import Drawing, DrawnCloud
from storage.errors import UsageError

SHAPES: Final = ("axis", "slice-circles")
CLOUD: Final = "cloud"
GEOMETRY: Final = (*SHAPES, CLOUD)
"""What can be drawn."""

Encode = Callable[[Drawing], bytes]
WriteCloud = Callable[[DrawnCloud, BinaryIO], None]


def encoder_of(what: str, file_format: str) -> Encode:
    """What makes a file of shapes.

    Raises
    ------
    UsageError
        If shapes cannot be written so.
    """
    return cast("Encode", _module("storage.drawing.shapes_as", what, file_format).encode)


def cloud_writer_of(file_format: str) -> WriteCloud:
    """What writes a cloud.

    Raises
    ------
    UsageError
        If a cloud cannot be written so.
    """
    return cast("WriteCloud", _module("storage.drawing.points_as", CLOUD, file_format).write)


def formats_of(what: str) -> tuple[str, ...]:
    """Names of the formats of something that can be drawn."""
    return tuple(_modules("storage.drawing.points_as" if what == CLOUD else "storage.drawing.shapes_as"))


def _module(package: str, what: str, file_format: str) -> ModuleType:
    known = _modules(package)
    if file_format not in known:
        raise UsageError(
            f"{what} cannot be written as {file_format!r}; known: {', '.join(known)}{_way_out(what, file_format)}"
        )
    return known[file_format]


def _way_out(what: str, file_format: str) -> str:
    if what == CLOUD and file_format in formats_of(SHAPES[0]):
        return (
            f" (a {file_format} of so many points opens nowhere: write laz and attach it to the drawing as a point cloud; "
            f"the shapes {' and '.join(SHAPES)} can be {file_format})"
        )
    if what != CLOUD and file_format in formats_of(CLOUD):
        return f" ({file_format} holds points only: WHAT = {CLOUD})"
    return ""


@cache
def _modules(package: str) -> Mapping[str, ModuleType]:
    home = importlib.import_module(package)
    names = sorted(info.name for info in pkgutil.iter_modules(home.__path__))
    modules = [importlib.import_module(f"{package}.{name}") for name in names]
    return {str(module.NAME): module for module in modules}
