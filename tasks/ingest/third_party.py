"""The line between our errors and those of decoders written by others."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from storage.errors import InputError


@contextmanager
def decoding(path: Path) -> Iterator[None]:
    """Turn whatever a decoder raises on damaged input into InputError.

    A panic of a decoder written in Rust derives from BaseException, so that is what must be caught.
    """
    try:
        yield
    except (InputError, MemoryError, KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    except BaseException as error:
        raise InputError(
            f"{path}: needs points that can be decoded, came {type(error).__name__} ({error}); "
            "the file is cut short or damaged, copy or export it again"
        ) from error
