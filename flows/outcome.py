"""How epochs and runs end, for whoever started them."""

import traceback
from dataclasses import dataclass
from pathlib import Path

from storage.errors import InputError, StorageError, TiltwatchError


class EpochsFailedError(TiltwatchError):
    """Epochs of a deployed run failed; the others are published."""


@dataclass(frozen=True, slots=True)
class EpochOutcome:
    """How an epoch ended, for the command line; ``bad_input`` says that the user can mend it.

    ``storage_fault`` says that it was the drive or store, which may be otherwise next time.
    """

    epoch: str
    state: str
    reasons: tuple[str, ...]
    bad_input: bool
    fault: str | None = None
    notes: tuple[str, ...] = ()
    storage_fault: bool = False


@dataclass(frozen=True, slots=True)
class RunOutcome:
    """How a run ended: its id, stages by state, and every epoch."""

    run: str
    workspace: Path
    computed: int
    cached: int
    epochs: tuple[EpochOutcome, ...]


def failed_epoch(epoch: str, fault: Exception) -> EpochOutcome:
    """How an epoch ended that met an exception: as bad input where the user can mend it, else as a fault of the program."""
    if isinstance(fault, InputError | StorageError):
        storage_fault = isinstance(fault, StorageError)
        return EpochOutcome(epoch, "failed", (str(fault),), bad_input=True, storage_fault=storage_fault)
    reason = f"fault of the program: {type(fault).__name__}: {fault}"
    told = "".join(traceback.format_exception(fault))
    return EpochOutcome(epoch, "failed", (reason,), bad_input=False, fault=told)
