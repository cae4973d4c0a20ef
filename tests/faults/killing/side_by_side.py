"""Runs that are killed in several workspaces at once, each in a process of its own."""

import json
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields
from multiprocessing import get_context
from pathlib import Path

from tests.faults.killing.moments import Figures, forker_of, kill_at_moments, prepared_scenes


def kill_runs(folder: Path, moments: int, seed: int, workspaces: int) -> list[Figures]:
    """Each workspace draws moments of its own."""
    parts = [len(range(number, moments, workspaces)) for number in range(workspaces)]
    # each begins without the threads that tables are read with
    with ProcessPoolExecutor(workspaces, mp_context=get_context("spawn")) as pool:
        asked = [
            pool.submit(_kill_some, folder / f"{number}", part, seed + 1000 * number)
            for number, part in enumerate(parts)
        ]
        return [one.result() for one in asked]


def _kill_some(folder: Path, moments: int, seed: int) -> Figures:
    figures = Figures()
    told = 0
    with forker_of(folder) as forker:
        scenes = []
        for one in prepared_scenes(folder, forker):
            scenes.append(one)
            times = f"{one.ended.wall_s:.1f} s, {one.ended.cpu_s:.1f} s of processor"
            _tell(
                f"{folder.name}: {one.scene.name}: exit {one.ended.exit_code}, {times}, {one.ended.steps} steps"
            )
        for _ in kill_at_moments(scenes, forker, moments, seed, figures):
            _tell(f"{folder.name}: {json.dumps(counted(figures) | {'faults': len(figures.faults)})}")
            for fault in figures.faults[told:]:
                _tell(f"{folder.name}: FAULT {fault}")
            told = len(figures.faults)
    return figures


def counted(figures: Figures) -> dict[str, object]:
    """Figures by name."""
    return {one.name: getattr(figures, one.name) for one in fields(figures) if one.name != "last_server"}


def together(figures: Sequence[Figures]) -> Figures:
    """Figures of several workspaces as one; the time is that of the longest."""
    whole = Figures()
    for one in figures:
        whole.moments += one.moments
        for counted, more in (
            (whole.phases, one.phases),
            (whole.scenes, one.scenes),
            (whole.servers, one.servers),
            (whole.moved_on, one.moved_on),
            (whole.starts, one.starts),
        ):
            counted.update(more)
        whole.faults += one.faults
        whole.seconds = max(whole.seconds, one.seconds)
    return whole


def _tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()
