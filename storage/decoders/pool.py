"""Decoder processes that are kept for the next scan: one that starts for every question would cost more than small scans."""

import atexit
import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from storage.decoders.process import (
    HELLO,
    DecoderFault,
    DecoderLost,
    DecoderProcess,
    DecoderProgram,
    DecoderRefusal,
)

IDLE_S: Final = 3.0
"""So long a decoder without work is kept; then it is ended, and its memory goes back to the system."""


class DecoderPool:
    """The decoders of this process that run one program; as many as threads that read at the same time."""

    def __init__(self, program: DecoderProgram) -> None:
        self.program = program
        self._idle: list[tuple[float, DecoderProcess]] = []
        self._lock = threading.Lock()
        self._sweep: threading.Timer | None = None
        atexit.register(self.end_idle)
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._forget)

    @contextmanager
    def borrowed(self) -> Iterator[DecoderProcess]:
        """Have a decoder to oneself.

        Where the block is left by anything but its refusal of the input it is ended, and the next scan gets a fresh one.

        Raises
        ------
        DecoderLost
            If none can be started.
        """
        decoder = self._taken()
        try:
            yield decoder
        except DecoderRefusal:
            self._give_back(decoder)
            raise
        except BaseException:
            decoder.end()
            raise
        self._give_back(decoder)

    def end_idle(self, idle_s: float = 0.0) -> None:
        """End the decoders that had nothing to do for so long."""
        before = time.monotonic() - idle_s
        with self._lock:
            ended = [decoder for since, decoder in self._idle if since <= before]
            self._idle = [(since, decoder) for since, decoder in self._idle if since > before]
        for decoder in ended:
            decoder.end()

    def _give_back(self, decoder: DecoderProcess) -> None:
        with self._lock:
            self._idle.append((time.monotonic(), decoder))
            self._sweep_later()

    def _taken(self) -> DecoderProcess:
        while (decoder := self._last_idle()) is not None:
            # it may have been ended meanwhile, by whom- and whatever: that is no fault of the next scan
            try:
                decoder.ask("hello", HELLO)
            except (DecoderFault, DecoderLost):
                decoder.end()
            else:
                return decoder
        return DecoderProcess(self.program)

    def _last_idle(self) -> DecoderProcess | None:
        with self._lock:
            return self._idle.pop()[1] if self._idle else None

    def _sweep_later(self) -> None:
        if self._sweep is None:
            self._sweep = threading.Timer(IDLE_S, self._sweep_now)
            self._sweep.daemon = True
            self._sweep.start()

    def _sweep_now(self) -> None:
        # a little less: those of this very moment, too
        self.end_idle(0.9 * IDLE_S)
        with self._lock:
            self._sweep = None
            if self._idle:
                self._sweep_later()

    def _forget(self) -> None:
        """In a process that was forked from this one: the decoders are not its own."""
        self._lock = threading.Lock()
        self._sweep = None
        for _, decoder in self._idle:
            decoder.forget()
        self._idle = []
