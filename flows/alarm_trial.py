"""A message to every target that says nothing but that messages arrive."""

from collections.abc import Iterator
from datetime import datetime

from flows.alarm_targets import Letter, send
from tasks.settings import Campaign


def send_trials(campaign: Campaign, now: datetime) -> Iterator[tuple[str, str | None]]:
    """Send a trial message to every target of a campaign: its id, and None where it was taken, else the reason.

    Nothing is put into the log of alarms: it is none.
    """
    title = campaign.structure.title
    for target in campaign.notify:
        letter = Letter(
            title=f"{title}: trial message",
            body=f"This is a trial. Alarms of {title} go to {target.id} this way. Nothing is wrong.",
            severity="info",
            is_over=False,
            facts={
                "structure": campaign.structure.id,
                "structure_name": title,
                "action": "trial",
                "severity": "info",
                "happened_at": now.isoformat(),
                "what": "trial message",
            },
        )
        yield target.id, send(target, letter, campaign.folder)
