"""The table [limits]: how far from plumb the structure may be."""

from typing import Annotated

from pydantic import Field

from tasks.limits import TABLES
from tasks.settings.limit_points import Kind, LimitPoints
from tasks.settings.section import Line, Section


class Limits(Section):
    """Allowable verticality deviation by height: a shipped table, one of an own file, or points of one's own."""

    table: str | None = Field(
        default=None,
        description=f"name of a shipped table of limits ({', '.join(sorted(TABLES))}) or of one in file; not needed where"
        " file holds one table only",
    )
    verticality_m: LimitPoints | None = Field(
        default=None,
        description="points [height, allowable deviation], rising; linear between, no limit outside;"
        " they win over table [m]",
    )
    kind: Kind | None = Field(default=None, description="what verticality_m was written for")
    file: Line | None = Field(
        default=None,
        min_length=1,
        max_length=1000,
        description="file of own tables with their papers, docs/limits.md; a path as of scans",
    )
    also: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        default=(),
        description="names of tables that are judged beside the first one, in the table `verdicts`",
    )
