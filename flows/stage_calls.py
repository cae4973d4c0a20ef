"""Ask for stages and wait for them, with every one noted in the run's ledger."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from prefect import Task
from prefect.futures import PrefectFuture

from flows.ledger import RunLedger, StageDone
from storage.errors import InputError, StorageError
from tasks.caching import Identity, identity_of
from tasks.produced import Cost, Produced, produced_from_json


@dataclass(frozen=True, slots=True)
class Pending:
    """A stage that was asked for."""

    label: str
    identity: Identity
    started_at: datetime
    future: PrefectFuture[Any]


@dataclass(frozen=True, slots=True)
class StageCalls:
    """The stages of one epoch of one run."""

    ledger: RunLedger
    epoch: str
    workspace: str
    on_behalf: str = ""
    """Stands before the label of every stage: of another epoch, whose stages this one needs."""

    def submit(self, stage: Task[..., Any], label: str, **inputs: Any) -> Pending:
        """Ask for a stage; it runs beside others."""
        label = f"{self.on_behalf}{label}"
        self.ledger.begin(self.epoch, label)
        inputs["workspace"] = self.workspace
        identity = identity_of(stage, inputs)
        return Pending(label, identity, datetime.now(UTC), stage.submit(**inputs))

    def finish(self, pending: Pending) -> Produced:
        """Wait for a stage and note it; a fault of the program is noted and raised again.

        A refusal that was raised is one like any other, but was not cached.
        """
        pending.future.wait()
        state = pending.future.state
        cached = state.name == "Cached"
        try:
            produced = produced_from_json(pending.future.result())
        except InputError as refusal:
            produced = Produced(Cost(0.0, None, None), refusal=str(refusal))
        except Exception as fault:
            self._note(pending, cached=cached, produced=None, fault=f"{type(fault).__name__}: {fault}")
            raise
        self._note(pending, cached=cached, produced=produced, fault=None)
        return produced

    def call(self, stage: Task[..., Any], label: str, **inputs: Any) -> Produced:
        """Ask for a stage and wait for it."""
        return self.finish(self.submit(stage, label, **inputs))

    def _note(self, pending: Pending, *, cached: bool, produced: Produced | None, fault: str | None) -> None:
        identity = pending.identity
        done = StageDone(
            stage=pending.label,
            cached=cached,
            started_at=pending.started_at,
            cache_key=identity.cache_key,
            code_version=identity.code_version,
            produced=produced,
            fault=fault,
        )
        self.ledger.note(self.epoch, done)


def artifact_of(produced: Produced | None, name: str) -> Any:
    """Reference to an artifact that a stage produced, as plain JSON.

    Raises
    ------
    StorageError
        If there is none of that name.
    """
    ref = None if produced is None else produced.artifacts.get(name)
    if ref is None:
        raise StorageError(f"a stage produced no {name!r}; run again with an empty workspace")
    return ref.to_json()
