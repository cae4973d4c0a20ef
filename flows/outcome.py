"""How epochs and runs end, for whoever started them."""

from dataclasses import dataclass
from pathlib import Path

from storage.errors import TiltwatchError


class EpochsFailedError(TiltwatchError):
    """Epochs of a deployed run failed; the others are published."""


@dataclass(frozen=True, slots=True)
class EpochOutcome:
    """How an epoch ended, for the command line; ``bad_input`` says that the user can mend it."""

    epoch: str
    state: str
    reasons: tuple[str, ...]
    bad_input: bool
    fault: str | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class RunOutcome:
    """How a run ended: its id, stages by state, and every epoch."""

    run: str
    workspace: Path
    computed: int
    cached: int
    epochs: tuple[EpochOutcome, ...]
