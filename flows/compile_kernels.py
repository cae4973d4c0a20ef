"""Compile the loops of the numerics before anybody waits for them: ``python -m flows.compile_kernels``.

A small simulated campaign of one epoch is measured as a run would, so that every loop of a usual campaign is compiled for
the arrays that it meets. What was compiled is found by every later process (tasks/geometry/compiled.py).
"""

import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flows.early_imports import keep_what_was_compiled
from flows.epoch_method import measure_epoch
from flows.epoch_work import EpochWork
from flows.ledger import RunLedger, StageEvent
from flows.stage_calls import Answer, StageCalls
from flows.terminal import note
from storage.workspace import open_workspace
from tasks.caching import Stage
from tasks.plan import plan_axes
from tasks.produced import Produced, produced_from_json
from tasks.settings import load_campaign
from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign

STATIONS = 3
POINTS = 20_000
"""Of a station: enough for every stage to have something to do."""


def compile_kernels() -> None:
    """Measure a simulated epoch; its results go nowhere.

    Raises
    ------
    TiltwatchError
        If this machine cannot simulate.
    """
    with tempfile.TemporaryDirectory(prefix="tiltwatch-compile-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        request = SimulatedCampaignRequest(epochs=1, stations=STATIONS, points=POINTS)
        campaign = load_campaign(write_simulated_campaign(folder / "campaign", request))
        place, epoch = open_workspace(folder / "workspace"), campaign.reference_epoch
        ledger = RunLedger("compile", campaign.structure.id, _tell_nobody)
        calls = StageCalls(ledger, epoch.id, place.place, _StagesHere())
        measure_epoch(EpochWork(campaign, epoch, place, calls, tuple(plan_axes(campaign, [])), partial=False))
    keep_what_was_compiled()


@dataclass(frozen=True, slots=True)
class _Computed:
    produced: Produced

    def result(self) -> Produced:
        """What it gave."""
        return self.produced

    def was_cached(self) -> bool:
        """It was not."""
        return False


@dataclass(frozen=True, slots=True)
class _StagesHere:
    """Carries a stage out where it is asked for."""

    def ask(self, stage: Stage, _label: str, inputs: dict[str, Any], _key: str, *, anew: bool) -> Answer:  # noqa: ARG002
        """Carry a stage out."""
        return _Computed(produced_from_json(stage.fn(**inputs)))


def _tell_nobody(_event: StageEvent) -> None:
    """Tell nobody of a stage."""


def main() -> int:
    """Compile, and say how long it took; 1 where that cannot be done here, and then the first run does it."""
    began = time.perf_counter()
    try:
        compile_kernels()
    except Exception as fault:
        note(f"the numeric loops are compiled by the first run instead: {type(fault).__name__}: {fault}")
        return 1
    note(f"numeric loops compiled in {time.perf_counter() - began:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
