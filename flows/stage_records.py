"""Prefect's results of stages, kept in the store of a workspace: plain JSON beside the artifacts that they name."""

from typing import Any, ParamSpec, TypeVar

from prefect import Flow
from prefect.filesystems import WritableFileSystem

from storage.errors import StorageError
from storage.places import store_at
from storage.workspace import Workspace
from tasks.caching import record_name

P = ParamSpec("P")
R = TypeVar("R")


class StageRecords(WritableFileSystem):
    """Records in the store of a workspace, for Prefect; known by its place alone, so that a worker can open it, too.

    A record comes into place whole: Prefect's own storage writes into the file that another stage under the same key (two
    stations with equal bytes) may be reading.
    """

    _block_type_name = "Tiltwatch stage records"
    _block_type_slug = "tiltwatch-stage-records"

    place: str

    def read_path(self, path: str, **_how: Any) -> bytes:  # type: ignore[override]
        """Read a record.

        Raises
        ------
        StorageError
            If there is none, which Prefect takes for a stage that was never computed.
        """
        content = store_at(self.place).get(record_name(path))
        if content is None:
            raise StorageError(f"no {self.place}/{record_name(path)}")
        return content

    def write_path(self, path: str, content: bytes, **_how: Any) -> None:  # type: ignore[override]
        """Keep a record."""
        store_at(self.place).put(record_name(path), content)

    async def aread_path(self, path: str) -> bytes:
        """Read a record, for Prefect's own loop."""
        return self.read_path(path)

    async def awrite_path(self, path: str, content: bytes) -> None:
        """Keep a record, for Prefect's own loop."""
        self.write_path(path, content)

    def _resolve_path(self, _path: str) -> None:
        """Prefect asks for an absolute path: a record has a name in the store, and none."""


def keep_records(epoch_flow: Flow[P, R], workspace: Workspace) -> Flow[P, R]:
    """Let a flow keep the results of its stages in the store of a workspace; gives the flow."""
    # not by with_options: that takes only blocks that are saved on a server, and then every machine asks it
    epoch_flow.result_storage = StageRecords(place=workspace.place)
    return epoch_flow
