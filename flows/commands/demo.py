"""``tiltwatch demo``: a simulated campaign with known truth, found against true."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from dataclasses import asdict
from pathlib import Path
from shlex import quote
from typing import Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson
from flows.terminal import answer, log_into, note, say, terminal
from storage.errors import UsageError

CAMPAIGN = "campaign"
LOGS = "logs"


def demo(  # noqa: PLR0913 (each is an option of the command line)
    *,
    workspace: Annotated[Path, Parameter(help="folder of scans and results")] = Path("tiltwatch-demo"),
    epochs: int = 4,
    stations: int = 8,
    points: int = 200_000,
    seed: int = 1,
    kind: str = "chimney",
    as_json: AsJson = False,
) -> int:
    """Simulate a campaign with known truth, run everything on it, print found against true.

    Parameters
    ----------
    epochs
        Times of measuring.
    stations
        Set-ups of the scanner in each epoch.
    points
        Points of a station.
    seed
        Seed of the simulated noise.
    kind
        chimney, tower, silo, tank, mast, column, stem or square-tower.
    """
    from flows.progress import progress
    from flows.run_campaign import RunRequest, run_campaign
    from flows.run_report import answer_of, conditions_of_run, exit_code_of, tell_errors, tell_results
    from storage.upgrade import ready_or_new_workspace
    from tasks.found_against_true import found_against_true, text_lines
    from tasks.settings import load_campaign
    from tasks.simulated_campaign import write_simulated_campaign
    from tasks.simulation.kinds import CASES, request_of_kind

    if kind not in CASES:
        raise UsageError(f"unknown kind {kind!r}; known: {', '.join(sorted(CASES))}")
    request = request_of_kind(kind, epochs=epochs, stations=stations, points=points, seed=seed)
    place = ready_or_new_workspace(workspace)
    log_into(place.root / LOGS)
    note(f"simulating {epochs} epochs of {stations} stations around a {kind} in {place.root / CAMPAIGN}")
    file = write_simulated_campaign(place.root / CAMPAIGN, request)
    with progress() as on_event:
        outcome = run_campaign(RunRequest(file, place.root), on_event)
    campaign = load_campaign(file)
    states = conditions_of_run(campaign, outcome)
    found = found_against_true(place, campaign)
    tell_errors(outcome.epochs)
    code = exit_code_of(outcome.epochs, states, None)
    if as_json:
        return answer(
            code, {**answer_of(outcome, states), "campaign_file": str(file), "found": asdict(found)}
        )
    tell_results(campaign, outcome, states, all_epochs=terminal().verbose)
    say("", *text_lines(found))
    note(f"next: tiltwatch status {quote(str(file))} --workspace {quote(str(place.root))}")
    return code
