"""Are the records of stages, the settings, and the notes beside them what was written."""

import json
from collections.abc import Iterator

from storage.artifacts import ArtifactRef
from storage.errors import StorageError
from storage.fault import Fault
from storage.places import store_of
from storage.sealed import is_true_record
from storage.store import Store
from storage.workspace import Workspace


def record_faults(ws: Workspace) -> Iterator[Fault | None]:
    """Records that are torn or altered, or whose artifacts are gone; what is computed anew is computed anew by a run."""
    store = store_of(ws)
    there = frozenset(store.names("artifacts"))
    for name in store.names("records"):
        if not name.endswith(".bad"):
            what = _fault_of(store, name, there)
            yield Fault(name, what, "run again: what it says is computed anew") if what else None


def _fault_of(store: Store, name: str, there: frozenset[str]) -> str | None:
    try:
        record = json.loads(store.get(name) or b"")
        payload, said = record["result"], record.get("metadata", {}).get("storage_key")
        produced = json.loads(payload) if isinstance(payload, str) else payload
        refs = [ArtifactRef.from_json(ref) for ref in produced["artifacts"].values()]
    except (ValueError, KeyError, TypeError, AttributeError, StorageError):
        return "is no record of a stage"
    if not is_true_record(produced):
        return "does not have the digest that it says"
    if said is not None and f"records/{said}" != name:
        return f"is the record of {said}"
    missing = [ref.name for ref in refs if ref.name not in there]
    return f"names {missing[0]}, which is gone" if missing else None
