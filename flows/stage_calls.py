"""Ask for stages and wait for them, with every one noted in the run's ledger."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Protocol

from flows.journal_lines import StageAsked
from flows.ledger import RunLedger, StageDone
from storage.errors import InputError, StorageError
from tasks.caching import Identity, Stage, identity_of
from tasks.produced import Cost, Produced


class Answer(Protocol):
    """What becomes of a stage that was asked for."""

    def result(self) -> Produced:
        """Wait for it; what it raised is raised."""

    def was_cached(self) -> bool:
        """Whether it was on record; to be asked when the result is there."""


class Stages(Protocol):
    """Who answers for stages: the runner of a flow, or what is on record."""

    def ask(self, stage: Stage, label: str, inputs: dict[str, Any], key: str, *, anew: bool) -> Answer:
        """Ask for a stage, whose key is given; with ``anew`` it is computed although it is on record."""


@dataclass(frozen=True, slots=True)
class Pending:
    """A stage that was asked for."""

    label: str
    identity: Identity
    started_at: datetime
    answer: Answer


@dataclass(frozen=True, slots=True)
class StageCalls:
    """The stages of one epoch of one run."""

    ledger: RunLedger
    epoch: str
    workspace: str
    stages: Stages
    on_behalf: str = ""
    """Stands before the label of every stage: of another epoch, whose stages this one needs."""

    def submit(self, stage: Stage, label: str, **inputs: Any) -> Pending:
        """Ask for a stage; it may run beside others."""
        label = f"{self.on_behalf}{label}"
        self.ledger.begin(self.epoch, label)
        inputs["workspace"] = self.workspace
        identity = identity_of(stage, inputs)
        started_at = datetime.now(UTC)
        self.ledger.asked(
            StageAsked(self.epoch, label, started_at, identity.cache_key, identity.code_version)
        )
        anew = self.ledger.wants_anew(identity.cache_key)
        answer = self.stages.ask(stage, label, inputs, identity.cache_key, anew=anew)
        return Pending(label, identity, started_at, answer)

    def finish(self, pending: Pending) -> Produced:
        """Wait for a stage and note it; a fault of the program is noted and raised again.

        A refusal that was raised is one like any other, but was not cached: the system was behind it.
        """
        try:
            produced = pending.answer.result()
        except InputError as refusal:
            self.ledger.passing.add(self.epoch)
            produced = Produced(Cost(0.0, None, None), refusal=str(refusal))
        except Exception as fault:
            self._note(pending, cached=False, produced=None, fault=f"{type(fault).__name__}: {fault}")
            raise
        self._note(pending, cached=pending.answer.was_cached(), produced=produced, fault=None)
        return produced

    def call(self, stage: Stage, label: str, **inputs: Any) -> Produced:
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
