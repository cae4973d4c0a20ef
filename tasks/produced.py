"""What a cached stage returns: references to artifacts and a few facts, plain JSON all through."""

import json
from dataclasses import dataclass, field
from typing import TypeAlias

from storage.artifacts import ArtifactRef
from storage.errors import StorageError
from storage.sealed import is_true_record, json_digest

Json: TypeAlias = "bool | int | float | str | list[Json] | dict[str, Json] | None"


@dataclass(frozen=True, slots=True)
class Cost:
    """What it took to compute a stage; of a cached stage, what it took at the time."""

    seconds: float
    points: int | None
    peak_rss_mb: float | None


@dataclass(frozen=True, slots=True)
class Produced:
    """Outcome of a stage: artifacts by name, or the reason why the input was refused."""

    cost: Cost
    artifacts: dict[str, ArtifactRef] = field(default_factory=dict)
    facts: dict[str, Json] = field(default_factory=dict)
    refusal: str | None = None

    def to_json(self) -> dict[str, Json]:
        """Plain JSON for Prefect's result record, with the digest of it: a flipped digit is a number, too."""
        content: dict[str, Json] = {
            "artifacts": {name: dict(ref.to_json()) for name, ref in self.artifacts.items()},
            "facts": self.facts,
            "refusal": self.refusal,
            "cost": {
                "seconds": self.cost.seconds,
                "points": self.cost.points,
                "peak_rss_mb": self.cost.peak_rss_mb,
            },
        }
        return {**content, "digest": json_digest(content)}


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the body of a stage hands back: artifacts by name, facts, and how many points came in."""

    artifacts: dict[str, ArtifactRef] = field(default_factory=dict)
    facts: dict[str, Json] = field(default_factory=dict)
    points: int | None = None


def produced_from_json(value: object) -> Produced:
    """Read what ``Produced.to_json`` wrote.

    Raises
    ------
    ValueError
        If it is anything else: a torn, altered or foreign record.
    """
    if not is_true_record(value):
        raise ValueError("the record of a stage does not have the digest that it says")
    try:
        cost, artifacts = value["cost"], value["artifacts"]  # type: ignore[index]
        return Produced(
            cost=Cost(cost["seconds"], cost["points"], cost["peak_rss_mb"]),
            artifacts={name: ArtifactRef.from_json(ref) for name, ref in artifacts.items()},
            facts=value["facts"],  # type: ignore[index]
            refusal=value["refusal"],  # type: ignore[index]
        )
    except (KeyError, TypeError, AttributeError, StorageError) as fault:
        raise ValueError(f"not the record of a stage: {fault}") from fault


def record_result(text: bytes, key: str | None = None) -> Produced:
    """Read the outcome out of Prefect's result record (JSON serializer, no object hooks).

    Parameters
    ----------
    key : str, optional
        Under which it lies; a record that says another one of itself is not that stage's.

    Raises
    ------
    ValueError
        If the record is torn, foreign or that of another stage.
    """
    record = json.loads(text)
    try:
        payload, said = record["result"], record.get("metadata", {}).get("storage_key", key)
    except (KeyError, TypeError, AttributeError) as fault:
        raise ValueError("not a result record") from fault
    if key is not None and said != key:
        raise ValueError(f"it is the record of {said}")
    return produced_from_json(json.loads(payload) if isinstance(payload, str) else payload)
