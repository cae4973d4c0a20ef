"""``tiltwatch plan``: what a survey will give, before anybody goes out."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, check_epochs
from flows.terminal import answer, say
from storage.errors import InputError, UsageError

FEWEST_POINTS = 10


def plan(
    file: Annotated[Path, Parameter(name="FILE")],
    /,
    *,
    epoch: Annotated[str | None, Parameter(name="--epoch")] = None,
    points: Annotated[int | None, Parameter(name="--points")] = None,
    as_json: AsJson = False,
) -> int:
    """Predict the sigma of the lean, the change that will be detectable and the coverage of a survey to come.

    No scans need to exist. Predicted, too: what limits, the best place for one more station, what each station adds.

    Parameters
    ----------
    file
        Plan file (TOML with a table [plan]), or campaign file, whose stations are taken.
    epoch
        Epoch of the campaign file; the latest that states the position of every station.
    points
        Points of each station on the shaft, in place of what the file states.
    """
    from flows.plan_text import plan_facts, plan_lines
    from tasks.design import best_place, foresee
    from tasks.geometry.failure import FitFailure
    from tasks.settings import Campaign
    from tasks.settings.plan_reading import load_plan
    from tasks.survey_design import design_survey, with_points

    settings = load_plan(file)
    if isinstance(settings, Campaign):
        check_epochs(settings, (epoch,) if epoch is not None else ())
    elif epoch is not None:
        raise UsageError(f"{file} is a plan file and has no epochs; leave --epoch {epoch} out")
    if points is not None and points < FEWEST_POINTS:
        raise UsageError(f"--points needs at least {FEWEST_POINTS}, got {points}")
    try:
        design = design_survey(settings, epoch)
    except InputError as error:
        raise InputError(f"{file}: {error}") from error
    design = design if points is None else with_points(design, points)
    outlook = foresee(design.survey)
    if isinstance(outlook, FitFailure):
        raise InputError(f"{file}: no lean can come from this survey: {outlook.reason}; move or add stations")
    place = best_place(design.survey)
    if as_json:
        return answer(0, plan_facts(design, outlook, place))
    say(*plan_lines(design, outlook, place))
    return 0
