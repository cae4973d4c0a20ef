"""Prefect's results of stages, kept in the store of a workspace: plain JSON beside the artifacts that they name."""

import json
from typing import Any, Final, ParamSpec, TypeVar

from prefect import Flow
from prefect.filesystems import WritableFileSystem
from prefect.serializers import JSONSerializer

from storage.errors import StorageError
from storage.places import store_at
from storage.workspace import Workspace
from tasks.caching import record_name
from tasks.produced import record_result

P = ParamSpec("P")
R = TypeVar("R")

PLAIN_JSON: Final = JSONSerializer(object_encoder=None, object_decoder=None)
"""No object hooks: a record may hold plain JSON and nothing that is imported on reading."""


class StageRecords(WritableFileSystem):
    """Records in the store of a workspace, for Prefect; known by its place alone, so that a worker can open it, too.

    A record comes into place whole: Prefect's own storage writes into the file that another stage under the same key (two
    stations with equal bytes) may be reading.
    """

    _block_type_name = "Tiltwatch stage records"
    _block_type_slug = "tiltwatch-stage-records"

    place: str

    def read_path(self, path: str, **_how: Any) -> bytes:  # type: ignore[override]
        """Read a record; Prefect gets what the stage produced, in a record made here.

        Prefect reads a record in the way that the record itself asks for, and that may be a pickle: whoever can write
        into the store could run code here.

        Raises
        ------
        StorageError
            If there is none, or it is not that of a stage, which Prefect takes for a stage that was never computed.
        """
        content = store_at(self.place).get(record_name(path))
        if content is None:
            raise StorageError(f"no {self.place}/{record_name(path)}")
        try:
            return _as_prefect_reads(path, content)
        except ValueError as fault:
            raise StorageError(
                f"{self.place}/{record_name(path)} is no record of a stage: {fault}"
            ) from fault

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


def _as_prefect_reads(key: str, content: bytes) -> bytes:
    produced = json.dumps(record_result(content, key).to_json())
    metadata = {"storage_key": key, "serializer": PLAIN_JSON.model_dump()}
    return json.dumps({"metadata": metadata, "result": produced}).encode()


def keep_records(epoch_flow: Flow[P, R], workspace: Workspace) -> Flow[P, R]:
    """Let a flow keep the results of its stages in the store of a workspace; gives the flow."""
    # not by with_options: that takes only blocks that are saved on a server, and then every machine asks it
    epoch_flow.result_storage = StageRecords(place=workspace.place)
    return epoch_flow
