"""The table [execution]: what the machine may spend; it never changes a result."""

from pydantic import Field

from tasks.settings.section import Section


class Execution(Section):
    """How many stages may run at once."""

    workers: int | None = Field(
        default=None, ge=1, le=512, description="stages that run at once; as many as cores where missing"
    )
