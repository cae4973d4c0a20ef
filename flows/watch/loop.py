"""The loop of a watch: look into the inbox, take in what is whole, run what is complete; until it is told to stop."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Final

from flows.watch.epochs import Epochs
from flows.watch.events import Now, Teller, WatchEvent, fault_in_words, utc_now
from flows.watch.late import LateStations
from flows.watch.place import WatchPlace
from flows.watch.runs import Runs
from flows.watch.stations import Stations
from storage.errors import TiltwatchError
from storage.inbox import Clock, Settling, is_unfinished, look_into

INTERRUPTED: Final = 130
BAD_INPUT: Final = 3


@dataclass(frozen=True, slots=True)
class Pace:
    """How often the inbox is looked at, how long a file must rest, how long a run may take; all in seconds."""

    interval_s: float
    settle_s: float
    run_timeout_s: float


class Watch:
    """A watch of one inbox for one structure."""

    def __init__(
        self, place: WatchPlace, teller: Teller, pace: Pace, clock: Clock | None = None, now: Now = utc_now
    ) -> None:
        self._place = place
        self._teller = teller
        self._settling = Settling(pace.settle_s, clock) if clock else Settling(pace.settle_s)
        self._stations = Stations(place, teller, now)
        self._epochs = Epochs(place, teller)
        self._runs = Runs(place, teller, now, pace.run_timeout_s)
        self._late = LateStations(place, teller, now, self._runs)
        self._last_fault = ""

    @property
    def troubled(self) -> bool:
        """Whether anything was told that a user has to do something about."""
        return self._teller.troubled

    def step(self) -> bool:
        """Do what is to be done now; gives whether nothing is left to wait for but new files."""
        try:
            return self._step()
        except TiltwatchError as fault:
            # a share that is away, a campaign file that is being edited: the next look may find it right
            lines = tuple(f"error: {line}" for line in str(fault).splitlines())
            self._teller.tell_once("look", WatchEvent("error", lines, {"reason": str(fault)}))
            return not self._runs.busy
        except Exception as fault:
            # whatever it is, other stations still come; its log is written once
            if repr(fault) != self._last_fault:
                self._last_fault = repr(fault)
                reason = fault_in_words(fault)
                self._teller.tell(WatchEvent("error", (f"error: {reason}",), {"reason": reason}))
            return not self._runs.busy

    def stop(self) -> None:
        """End what is under way."""
        self._runs.stop()

    def _step(self) -> bool:
        self._fetch()
        files = look_into(self._place.inbox)
        settled = self._settling.settled(files)
        whole = [file for file in files if not is_unfinished(file)]
        self._stations.take(whole, settled)
        # what the stations left behind is looked at again: they were taken out
        left = [file for file in whole if file.path.exists()]
        moving = any(file.name not in settled for file in files if file.path.exists())
        intakes = self._epochs.follow([] if moving else left)
        ended = self._runs.follow(intakes)
        self._late.follow(intakes, at_once=ended)
        self._teller.forget("look")
        return not moving and not self._runs.busy

    def _fetch(self) -> None:
        if self._place.objects is None:
            return
        fetched = self._place.objects.fetch()
        for fault in fetched.faults:
            event = WatchEvent("error", (f"error: {fault}",), {"reason": fault})
            self._teller.tell_once(f"fetch {fault}", event)


def keep_watching(watch: Watch, pace: Pace, *, once: bool) -> int:
    """Look again and again until told to stop (SIGTERM, Ctrl-C), or until nothing is left where one pass is wanted.

    Returns
    -------
    int
        Exit code: 0 after one pass, 3 if it kept anything for a reason or met an error, 130 where it was told to stop.
    """
    with _told_to_stop() as stop:
        try:
            while not stop.is_set():
                if watch.step() and once:
                    return BAD_INPUT if watch.troubled else 0
                stop.wait(min(pace.interval_s, max(pace.settle_s, 0.1)) if once else pace.interval_s)
        finally:
            watch.stop()
    return INTERRUPTED


@contextmanager
def _told_to_stop() -> Iterator[threading.Event]:
    """An event that the signals set which end a program; outside the main thread nothing sets it."""
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return

    def note(_number: int, _frame: FrameType | None) -> None:
        stop.set()

    before = {number: signal.signal(number, note) for number in (signal.SIGTERM, signal.SIGINT)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
