"""Tell the alarms which stations are awaited: one that is late must be heard of while the crew can still go back."""

import time
from collections.abc import Sequence
from typing import Final

from flows.watch.events import Now, Teller, WatchEvent
from flows.watch.place import WatchPlace
from flows.watch.runs import Runs
from storage.errors import TiltwatchError
from tasks.alarms import PendingEpoch
from tasks.arrivals import missing_stations
from tasks.settings.intake import Intake, check_intakes, load_awaiting

ALARMS_EVERY_S: Final = 60.0


class LateStations:
    """Has the alarms evaluated now and then, with what is still to come."""

    def __init__(self, place: WatchPlace, teller: Teller, now: Now, runs: Runs) -> None:
        self._place = place
        self._teller = teller
        self._now = now
        self._runs = runs
        self._last_s: float | None = None

    def follow(self, intakes: Sequence[Intake], *, at_once: bool) -> None:
        """Evaluate the alarms if it is time; while a run is under way it does so itself at its end."""
        if self._runs.busy:
            return
        now_s = time.monotonic()
        if not at_once and self._last_s is not None and now_s - self._last_s < ALARMS_EVERY_S:
            return
        self._last_s = now_s
        # it loads much that a look into the inbox does not need
        from flows.alarm_delivery import evaluate_and_deliver  # noqa: PLC0415

        try:
            campaign = check_intakes(self._place.campaign_file, intakes)
            if not campaign.alarms:
                return
            evaluate_and_deliver(self._place.workspace, campaign, self._now(), pending=self.pending(intakes))
        except TiltwatchError as fault:
            event = WatchEvent("error", (f"error: alarms: {fault}",), {"reason": str(fault)})
            self._teller.tell_once("alarms", event)

    def pending(self, intakes: Sequence[Intake]) -> tuple[PendingEpoch, ...]:
        """Epochs that have begun to arrive, or are complete and not processed yet."""
        campaign = load_awaiting(self._place.campaign_file)
        return tuple(
            PendingEpoch(
                epoch=intake.epoch,
                first_arrival=intake.first_arrival,
                missing=() if intake.complete else missing_stations(intake, campaign),
            )
            for intake in intakes
            if intake.complete is None or self._runs.awaits_run(intake)
        )
