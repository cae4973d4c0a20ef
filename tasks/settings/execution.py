"""The table [execution]: where the stages run and what they may spend; it never changes a result."""

import re
from typing import Annotated, Final, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from tasks.settings.section import Section, problem

ADDRESS: Final = re.compile(r"(tcp|tls)://[^\s/:]+:\d{1,5}")
BUCKET: Final = re.compile(r"s3://[a-z0-9][a-z0-9.-]{1,61}[a-z0-9](/[^/\s]+)*/?")


def _address(text: str) -> str:
    if not ADDRESS.fullmatch(text):
        raise problem(f"{text!r} is no address of a scheduler", 'as "tcp://10.0.0.5:8786"')
    return text


def _bucket(text: str) -> str:
    if not BUCKET.fullmatch(text):
        raise problem(
            f"{text!r} names no bucket",
            'as "s3://bucket/prefix"; server and keys come from AWS_ENDPOINT_URL, AWS_ACCESS_KEY_ID and '
            "AWS_SECRET_ACCESS_KEY",
        )
    return text.rstrip("/")


class Execution(Section):
    """Where the stages run, and where their results are kept on the way."""

    engine: Literal["local", "dask"] = Field(
        default="local",
        description="local: threads of this process; dask: workers of a Dask cluster, on this machine or others",
    )
    address: Annotated[str, AfterValidator(_address)] | None = Field(
        default=None, description="scheduler of the Dask cluster, as tcp://host:port"
    )
    workers: int | None = Field(
        default=None,
        ge=1,
        le=512,
        description="stages that run at once in this process; as many as cores where missing; Dask's workers are "
        "those that were started",
    )
    epochs_at_once: int | None = Field(
        default=None,
        ge=1,
        le=64,
        description="epochs that engine dask works on at once; where missing twice as many as its workers have threads and "
        "two, at most 32: an epoch has stages that nothing else of it can run beside",
    )
    memory_gb: float | None = Field(
        default=None,
        ge=0.75,
        le=100_000.0,
        description="memory that a process may take for its stages, which wait for one another or are refused before they "
        "take more; half of the machine's where missing [GB]",
    )
    store: Annotated[str, AfterValidator(_bucket)] | None = Field(
        default=None,
        description="place on S3 for scans, artifacts and records, as s3://bucket/prefix; in the workspace where "
        "missing. Workers on other machines need it, or a workspace and scans on a drive that all of them mount",
    )
    keep_server_s: float = Field(
        default=600.0,
        ge=0.0,
        le=86_400.0,
        description="s; so long the workflow server that a run starts for its workspace, on loopback, is kept for the next "
        "run after the last one used it; 0: it ends with the run",
    )

    @model_validator(mode="after")
    def _engine_and_address(self) -> Self:
        if self.engine == "dask" and self.address is None:
            raise problem(
                'engine = "dask" needs the address of its scheduler', 'add address = "tcp://host:8786"'
            )
        if self.engine == "local" and self.address is not None:
            raise problem(f"address {self.address} is for dask only", 'add engine = "dask"')
        return self
