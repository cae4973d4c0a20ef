"""Read the file of ``tiltwatch plan``: a plan file, or a campaign file whose stations are taken."""

from pathlib import Path

from pydantic import ValidationError

from tasks.settings.campaign import Campaign
from tasks.settings.plan import PlanFile
from tasks.settings.problems import problems_of
from tasks.settings.reading import input_error, load_campaign, read_toml


def load_plan(path: Path) -> PlanFile | Campaign:
    """Read and check a file with a table [plan]; one without it is read as a campaign file.

    Raises
    ------
    InputError
        One line for every problem, each ``FILE: where: what; hint``.
    """
    raw = read_toml(path)
    if "plan" not in raw:
        return load_campaign(path)
    try:
        return PlanFile.model_validate(raw)
    except ValidationError as error:
        raise input_error(path, list(problems_of(error, raw, PlanFile))) from error
