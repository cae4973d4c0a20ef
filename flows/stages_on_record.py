"""Stages that are answered from their records alone: a run on which nothing is new needs no workflow engine."""

from dataclasses import dataclass
from typing import Any

from flows.stage_calls import Answer
from storage.errors import TiltwatchError
from storage.places import workspace_at
from tasks.caching import Stage, on_record
from tasks.produced import Produced


class NotOnRecordError(TiltwatchError):
    """A stage must be computed."""


@dataclass(frozen=True, slots=True)
class _Found:
    """A stage whose record and artifacts are whole."""

    produced: Produced

    def result(self) -> Produced:
        """What the record says."""
        return self.produced

    def was_cached(self) -> bool:
        """It was."""
        return True


@dataclass(frozen=True, slots=True)
class RecordedStages:
    """Answers for stages that are on record; the same records, verified in the same way, as a flow finds."""

    def ask(self, _stage: Stage, label: str, inputs: dict[str, Any], key: str, *, anew: bool) -> Answer:
        """Look a stage up.

        Raises
        ------
        NotOnRecordError
            If it must be computed.
        """
        produced = None if anew else on_record(workspace_at(inputs["workspace"]), key)
        if produced is None:
            raise NotOnRecordError(f"{label} is not on record")
        return _Found(produced)
