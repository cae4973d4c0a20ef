"""The table [execution]: what the machine may spend; it never changes a result."""

from pydantic import Field

from tasks.settings.section import Section


class Execution(Section):
    """Bounds on memory and workers."""

    memory_gb: float | None = Field(
        default=None,
        gt=0.0,
        le=4096.0,
        description="memory that a run may use; what is free where missing [GB]",
    )
    workers: int | None = Field(
        default=None, ge=1, le=512, description="stages that run at once; chosen by the machine where missing"
    )
