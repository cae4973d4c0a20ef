"""Read a campaign file, and say everything that is wrong with it at once."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from pydantic import ValidationError

from storage.errors import InputError
from tasks.settings.campaign import AWAITS_EPOCHS, FOLDER, OWN_LIMITS, Campaign
from tasks.settings.cross_checks import problems_between_names, problems_between_values
from tasks.settings.limit_file import StatedLimit, load_limits, stated_file
from tasks.settings.outline import outline_of
from tasks.settings.problems import Problem, problems_of
from tasks.settings.scan_paths import resolve_scan
from tasks.settings.toml_file import input_error, read_toml


def load_campaign(path: Path) -> Campaign:
    """Read and check a campaign file; no scan is opened.

    Raises
    ------
    InputError
        One line for every problem, each ``FILE: where: what; hint``.
    """
    return campaign_of(read_toml(path), path)


def campaign_of(raw: Mapping[str, object], path: Path, *, awaits_epochs: bool = False) -> Campaign:
    """Check the content of a campaign file at ``path``.

    Parameters
    ----------
    raw
        Content of the file, and of what was taken in for it.
    path
        Names it in messages; scans are relative to its folder.
    awaits_epochs
        Whether it may be without epochs, because they come through an inbox.

    Raises
    ------
    InputError
        One line for every problem, each ``FILE: where: what; hint``.
    """
    folder = path.absolute().parent
    outline = outline_of(raw)
    problems = list(problems_between_names(outline, folder))
    context = {
        FOLDER: folder,
        AWAITS_EPOCHS: awaits_epochs,
        OWN_LIMITS: _own_limits(raw, folder, outline.roots, path),
    }
    try:
        campaign = Campaign.model_validate(raw, context=context)
    except ValidationError as error:
        problems = [*problems_of(error, raw, Campaign), *problems]
        raise input_error(path, problems) from error
    problems.extend(_later_problems(campaign))
    if problems:
        raise input_error(path, problems)
    return campaign


def _own_limits(
    raw: Mapping[str, object], folder: Path, roots: Sequence[str], path: Path
) -> tuple[StatedLimit, ...]:
    """Tables of the file of limits that a campaign names."""
    file = stated_file(raw)
    if file is None:
        return ()
    try:
        place = resolve_scan(file, folder, roots)
    except InputError as error:
        hint = "move the file, or name its folder in [files] roots"
        raise input_error(path, [Problem("limits.file", str(error), hint)]) from error
    return load_limits(place)


def _later_problems(campaign: Campaign) -> Iterator[Problem]:
    yield from problems_between_values(campaign)


__all__ = ["Campaign", "campaign_of", "input_error", "load_campaign", "read_toml"]
