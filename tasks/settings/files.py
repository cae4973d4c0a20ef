"""The table [files]: where scans may lie."""

from typing import Annotated

from pydantic import Field

from tasks.settings.section import Section


class Files(Section):
    """Folders outside the campaign file's own that scans may come from."""

    roots: Annotated[tuple[Annotated[str, Field(min_length=1)], ...], Field(strict=False)] = Field(
        default=(), description="folders, absolute or relative to the campaign file, whose files may be named"
    )
