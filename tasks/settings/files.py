"""The table [files]: where scans may lie."""

from typing import Annotated

from pydantic import Field

from tasks.settings.section import Line, Section


class Files(Section):
    """Folders outside the campaign file's own that scans may come from."""

    roots: Annotated[tuple[Annotated[Line, Field(min_length=1)], ...], Field(strict=False)] = Field(
        default=(), description="folders, absolute or relative to the campaign file, whose files may be named"
    )
