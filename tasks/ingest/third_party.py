"""The line between our errors and those of decoders written by others."""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from storage.decoders.process import DecoderFault, DecoderLost
from storage.errors import InputError

FROM_WITHIN: Final = frozenset({None, errno.EINVAL, errno.EOVERFLOW})
"""Numbers of an OSError that speaks of the input: Arrow has it without a number, and damage asks for impossible places."""


@contextmanager
def decoding(path: Path) -> Iterator[None]:
    """Turn whatever a decoder does on damaged input, here or in a process of its own, into InputError.

    A panic of a decoder written in Rust derives from BaseException, so that is what must be caught. What the system
    refuses stays OSError: a drive that does not answer is no damage.
    """
    try:
        yield
    except (InputError, MemoryError, KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    except DecoderLost as lost:
        # its cause is the system, which a stage does not remember
        raise InputError(
            f"{path}: needs points that can be decoded, came {lost}; "
            "free memory, look whether its disk answers, and run again"
        ) from lost
    except DecoderFault as fault:
        raise _damaged(path, str(fault)) from fault
    except BaseException as error:
        if isinstance(error, OSError) and error.errno not in FROM_WITHIN:
            raise
        raise _damaged(path, f"{type(error).__name__} ({error})") from error


def _damaged(path: Path, came: str) -> InputError:
    return InputError(
        f"{path}: needs points that can be decoded, came {came}; "
        "the file is cut short or damaged, copy or export it again"
    )
