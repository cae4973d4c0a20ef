"""``tiltwatch init``: a campaign file to begin with."""
# ruff: noqa: PLC0415 (imports stand where they are needed: a start must be quick)

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from flows.terminal import note, say
from storage.errors import UsageError


def init(
    kind: Annotated[str, Parameter(name="KIND")],
    file: Annotated[Path, Parameter(name="FILE")] = Path("campaign.toml"),
    /,
    *,
    wants_plan: Annotated[bool, Parameter(name="--plan", negative="", show_default=False)] = False,
) -> int:
    """Write a commented example of a campaign file; an existing file is never overwritten.

    Parameters
    ----------
    kind
        chimney, tower, silo, tank, mast, column, stem or square-tower.
    file
        Where to write it.
    wants_plan
        Write a plan file instead: a survey to come, for `tiltwatch plan`.
    """
    from tasks.settings.example import example_campaign
    from tasks.settings.plan_example import example_plan

    text = example_plan(kind) if wants_plan else example_campaign(kind)
    try:
        with file.open("x", encoding="utf-8", newline="\n") as new:
            new.write(text)
    except FileExistsError as error:
        raise UsageError(f"{file} is there already; name another file or move it away") from error
    except OSError as error:
        raise UsageError(f"{file} cannot be written: {error.strerror}; name another file") from error
    say(str(file))
    note(f"next: edit {file}, then `tiltwatch {'plan' if wants_plan else 'check'} {file}`")
    return 0
