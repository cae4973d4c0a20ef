"""What is wrong with a campaign file, said line by line: where, what, and what to do."""

import difflib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from types import UnionType
from typing import Annotated, Final, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from tasks.settings.section import PROBLEM

MOST_PROBLEMS: Final = 100
"""Told of one file; who mends these sees the others."""

Location = tuple[str | int, ...]

PLAIN: Final = {
    "missing": "is required",
    "timezone_aware": "needs an offset from UTC",
    "datetime_type": "needs a date and time with an offset from UTC, without quotes",
    "string_type": "needs a text in quotes",
    "float_type": "needs a number",
    "int_type": "needs a whole number",
    "bool_type": "needs true or false",
    "finite_number": "needs a finite number",
    "tuple_type": "needs an array",
    "model_type": "needs a table",
    "dict_type": "needs a table",
    "string_pattern_mismatch": "needs 1 to 64 letters, digits, dots, underscores and hyphens,"
    " a letter or digit first",
}
UNION_TAGS: Final = {"pair", "source", "sigma", "table"}
"""Members of unions in the models; pydantic puts them into the places of errors."""

TIME_HINT: Final = "write it as 2025-03-14T06:00:00+08:00"


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong with a campaign file."""

    where: str
    what: str
    hint: str = ""

    def line(self, file: str) -> str:
        """Say it as ``FILE: where: what; hint``."""
        parts = [file, self.where] if self.where else [file]
        return ": ".join([*parts, self.what]) + (f"; {self.hint}" if self.hint else "")


def problems_of(
    error: ValidationError, raw: Mapping[str, object], root: type[BaseModel]
) -> Iterator[Problem]:
    """List what pydantic found, in the words of the campaign file."""
    for details in error.errors(include_url=False)[:MOST_PROBLEMS]:
        location = _within(raw, _without_kind(details["loc"], root))
        yield _problem(details, location, raw, root)
    if error.error_count() > MOST_PROBLEMS:
        yield Problem("", f"has {error.error_count() - MOST_PROBLEMS} more problems")


def place(raw: object, location: Location) -> str:
    """Name a place in the file; items of lists by their id where they have one, else by their number."""
    return Places(raw).name(location)


class Places:
    """Names places in one file; the ids of a list are read once, for a file may have thousands of them."""

    def __init__(self, raw: object) -> None:
        self.raw = raw
        self._ids: dict[Location, Counter[str]] = {}

    def name(self, location: Location) -> str:
        """Name a place; items of lists by their id where they have one, else by their number."""
        words: list[str] = []
        here = self.raw
        for depth, step in enumerate(location):
            above, here = here, _step(here, step)
            if isinstance(step, int):
                words[-1] += f"[{self._label(location[:depth], above, step)}]"
            else:
                words.append(step)
        return ".".join(words)

    def _label(self, location: Location, items: object, number: int) -> str:
        """Id of an item; its number where it has none, and both where its neighbour has the same."""
        if location not in self._ids:
            ids = [_step(item, "id") for item in items] if isinstance(items, list) else []
            self._ids[location] = Counter(name for name in ids if isinstance(name, str))
        name = _step(_step(items, number), "id")
        if not isinstance(items, list) or not isinstance(name, str):
            return f"#{number + 1}"
        return name if self._ids[location][name] == 1 else f"#{number + 1} {name}"


def nearest(name: str, known: Sequence[str]) -> str:
    """Say which known name was probably meant, or which there are."""
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
    return f"did you mean {close[0]!r}?" if close else f"known: {', '.join(known)}"


def _problem(
    details: ErrorDetails, location: Location, raw: Mapping[str, object], root: type[BaseModel]
) -> Problem:
    kind, where = details["type"], place(raw, location)
    context = details.get("ctx", {})
    if kind == PROBLEM:
        return Problem(where, context["what"], context["hint"])
    if kind == "extra_forbidden":
        return Problem(where, "unknown key", _known_keys(root, location, raw))
    if kind in {"union_tag_invalid", "union_tag_not_found"}:
        return _unknown_kind(where, context, _kinds_at(root, location))
    what = PLAIN.get(kind) or details["msg"].replace("Input should", "should").replace(
        "String should", "should"
    )
    if kind != "missing":
        what += f", got {_shown(details['input'])}"
    if kind in {"timezone_aware", "datetime_type"}:
        return Problem(where, what, TIME_HINT)
    return Problem(where, what, _meaning(root, location, raw))


def _unknown_kind(where: str, context: Mapping[str, object], kinds: "_Kinds") -> Problem:
    where = f"{where}.{kinds.key}"
    if "tag" not in context:
        return Problem(where, "is required", f"known: {', '.join(kinds.models)}")
    return Problem(
        where, f"{context['tag']!r} is not known", nearest(str(context["tag"]), list(kinds.models))
    )


def _within(raw: object, location: Location) -> Location:
    """Drop the steps that pydantic adds for the members of a union: they are not in the file."""
    steps: list[str | int] = []
    for number, step in enumerate(location):
        below = _step(raw, step)
        if below is None and number < len(location) - 1:
            continue
        if below is None and step in UNION_TAGS:
            continue
        steps.append(step)
        raw = below
    return tuple(steps)


def _step(raw: object, step: str | int) -> object:
    if isinstance(raw, Mapping):
        return raw.get(step)
    if isinstance(raw, Sequence) and not isinstance(raw, str) and isinstance(step, int) and step < len(raw):
        return raw[step]
    return None


def _known_keys(root: type[BaseModel], location: Location, raw: object) -> str:
    *above, name = location
    model = _model_at(root, tuple(above), raw)
    known = list(model.model_fields) if model else []
    close = difflib.get_close_matches(str(name), known, n=1, cutoff=0.6)
    if close:
        return f"did you mean {close[0]!r}?"
    home = next((table for table, child in _tables(root) if name in child.model_fields), None)
    if home is not None:
        return f"{name!r} belongs to [{home}]"
    return f"known: {', '.join(known)}"


def _meaning(root: type[BaseModel], location: Location, raw: object) -> str:
    names = [step for step in location if isinstance(step, str)]
    if not names:
        return ""
    end = max(index for index, step in enumerate(location) if isinstance(step, str))
    model = _model_at(root, location[:end], raw)
    field = model.model_fields.get(names[-1]) if model else None
    return f"meaning: {field.description}" if field and field.description else ""


def _tables(model: type[BaseModel], above: str = "") -> Iterator[tuple[str, type[BaseModel]]]:
    for key, field in model.model_fields.items():
        child = _model_in(field.annotation)
        if child is not None:
            table = f"{above}{key}" + (".NAME" if get_origin(field.annotation) is dict else "")
            yield table, child
            yield from _tables(child, f"{table}.")


@dataclass(frozen=True, slots=True)
class _Kinds:
    """Tables of a list that come in kinds, as [[alarms]]: the key that tells them apart, and the models by its value."""

    key: str
    models: Mapping[str, type[BaseModel]]


NO_KINDS: Final = _Kinds("", {})


def _kinds_in(annotation: object) -> _Kinds:
    parts = get_args(annotation)
    if get_origin(annotation) is Annotated:
        key = next((key for part in parts[1:] if (key := getattr(part, "discriminator", None))), None)
        if isinstance(key, str):
            models = [model for model in get_args(parts[0]) if issubclass(model, BaseModel)]
            return _Kinds(key, {get_args(model.model_fields[key].annotation)[0]: model for model in models})
    if get_origin(annotation) in {tuple, Union, UnionType, Annotated}:
        return next((kinds for part in parts if (kinds := _kinds_in(part)).models), NO_KINDS)
    return NO_KINDS


def _kinds_at(root: type[BaseModel], location: Location) -> _Kinds:
    field = root.model_fields.get(str(location[0])) if location else None
    return NO_KINDS if field is None else _kinds_in(field.annotation)


def _without_kind(location: Location, root: type[BaseModel]) -> Location:
    """Drop the kind of a table, which pydantic puts behind its number."""
    if len(location) > 2 and location[2] in _kinds_at(root, location).models:
        return (*location[:2], *location[3:])
    return location


def _model_at(root: type[BaseModel], location: Location, raw: object) -> type[BaseModel] | None:
    kinds = _kinds_at(root, location)
    if kinds.models and len(location) > 1:
        kind = _step(_step(_step(raw, location[0]), location[1]), kinds.key)
        return kinds.models.get(str(kind))
    model: type[BaseModel] | None = root
    passed_table_of_tables = False
    for step in location:
        if isinstance(step, int) or model is None:
            continue
        if passed_table_of_tables:
            passed_table_of_tables = False
            continue
        field = model.model_fields.get(step)
        if field is None:
            return None
        passed_table_of_tables = get_origin(field.annotation) is dict
        model = _model_in(field.annotation)
    return model


def _model_in(annotation: object) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    if get_origin(annotation) in {tuple, dict, Union, UnionType, Annotated}:
        return next((model for part in get_args(annotation) if (model := _model_in(part))), None)
    return None


def _shown(value: object) -> str:
    text = repr(value)
    if isinstance(value, Mapping):
        text = "a table"
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, date):
        text = value.isoformat()
    return text if len(text) <= 60 else text[:57] + "..."
