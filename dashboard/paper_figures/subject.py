"""What a figure is of: an epoch of a structure, and what the figures say of it alike."""

from dataclasses import dataclass
from typing import Final

from storage.records import EpochRow

LONGEST_TITLE: Final = 70


@dataclass(frozen=True, slots=True)
class Subject:
    """An epoch, the name of its structure for people, and the primary scheme and method."""

    epoch: EpochRow
    title: str
    primary: tuple[str, str]

    @property
    def line(self) -> str:
        """Structure, epoch and time in one line."""
        title = " ".join(self.title.split())
        short = title if len(title) <= LONGEST_TITLE else f"{title[: LONGEST_TITLE - 1]}…"
        state = "" if self.epoch.state == "ok" else f" ({self.epoch.state})"
        return (
            f"{short}, epoch {self.epoch.epoch}{state}, measured {self.epoch.epoch_time:%Y-%m-%d %H:%M} UTC"
        )

    def because(self, what: str) -> str:
        """Say that something is not there, with the reason of an epoch that failed."""
        return f"{what}; the epoch is {self.epoch.state}: {self.epoch.reason}" if self.epoch.reason else what
