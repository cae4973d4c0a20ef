"""The campaign of the run that is under way in this process: read once, not once an epoch."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from tasks.settings import Campaign
from tasks.settings.intake import load_with_intake

_current: ContextVar[tuple[str, str, Campaign]] = ContextVar("_current")


@contextmanager
def campaign_held(campaign_file: str, workspace: str, campaign: Campaign) -> Iterator[None]:
    """Hold the campaign that a run has read for its epochs: a thousand of them would read a large file a thousand times."""
    token = _current.set((campaign_file, workspace, campaign))
    try:
        yield
    finally:
        _current.reset(token)


def read_campaign(campaign_file: str, workspace: str) -> Campaign:
    """The campaign that the run holds, or else that of the file with what came through an inbox.

    Raises
    ------
    InputError
        If the file is bad.
    """
    held = _current.get(None)
    if held is not None and held[:2] == (campaign_file, workspace):
        return held[2]
    return load_with_intake(Path(campaign_file), Path(workspace))
