"""What the record of a stage says, for people who look at its artifacts.

Of a record only the references and facts are read, which is less than ``tasks.produced`` knows of it; tests hold both to the
same form.
"""

import json
from typing import Any

from storage.places import store_of
from storage.records import StageRunRow
from storage.workspace import Workspace


def stage_record(ws: Workspace, row: StageRunRow) -> dict[str, Any] | None:
    """What a stage produced; None where its record was swept or is of another form."""
    text = store_of(ws).get(f"records/{row.cache_key}")
    try:
        payload = json.loads(text or b"")["result"]
        produced = json.loads(payload) if isinstance(payload, str) else payload
        return {"artifacts": dict(produced["artifacts"]), "facts": dict(produced["facts"])}
    except (ValueError, KeyError, TypeError):
        return None
