"""Formats that people have and that no reader here reads: what to do about each."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

VENDOR: Final = "is a maker's raw format; export E57 or LAZ from the maker's program"

# fmt: off
RAW_SUFFIXES: Final = (
    ".fls", ".fws", ".rdbx", ".rdb", ".rxp", ".zfs", ".zfc", ".ptg", ".lsproj", ".lgs",
    ".rcp", ".rcs", ".imp", ".fptx", ".3dd", ".hls", ".clr", ".rwp", ".dp",
)
# fmt: on

ADVICE: Final[Mapping[str, str]] = MappingProxyType(
    {
        **dict.fromkeys(RAW_SUFFIXES, VENDOR),
        **dict.fromkeys((".zip", ".gz", ".7z", ".xz", ".bz2", ".zst"), "is packed; unpack it first"),
        **dict.fromkeys((".xlsx", ".xls", ".ods"), "is a spreadsheet; save it as CSV"),
    }
)
"""Advice by suffix."""
