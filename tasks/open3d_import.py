"""The import of open3d: in one place, because bare machines lack a library that it loads."""

import ctypes
import importlib
import sys
from types import ModuleType
from typing import Final

from storage.errors import TiltwatchError

_LIBRARY: Final = "libusb"


def import_open3d() -> ModuleType:
    """Import open3d, with the libusb of the wheel ``libusb-package`` where Linux has none.

    Raises
    ------
    TiltwatchError
        If open3d cannot be loaded; the message says what to install.
    """
    try:
        return importlib.import_module("open3d")
    except ImportError as error:
        if _LIBRARY not in str(error) or not sys.platform.startswith("linux"):
            raise TiltwatchError(_advice(error)) from error
    for name in [name for name in sys.modules if name.partition(".")[0] == "open3d"]:
        del sys.modules[name]
    try:
        # open3d asks the linker for libusb by name; one that is already loaded satisfies it
        path = importlib.import_module("libusb_package").get_library_path()
        ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
        return importlib.import_module("open3d")
    except (ImportError, OSError) as error:
        raise TiltwatchError(_advice(error)) from error


def _advice(error: Exception) -> str:
    return (
        f"this needs open3d, which does not load here ({error}); install the python packages of "
        "requirements.lock, and on linux the system's libusb-1.0 or the package libusb-package; "
        "a slim image also needs libegl1, libgl1, libx11-6, libudev1 and libidn2-0"
    )
