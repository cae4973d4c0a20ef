"""The schema says of every key what it means, in which unit and within which bounds."""

import re
from collections.abc import Iterator

import pytest

from tasks.settings import Campaign

SCHEMA = Campaign.model_json_schema()
UNITS = {"_m": "[m]", "_deg": "[deg]", "_gb": "[GB]"}


def _keys() -> Iterator[tuple[str, dict[str, object]]]:
    for name, table in {**SCHEMA["$defs"], "Campaign": SCHEMA}.items():
        for key, definition in table.get("properties", {}).items():
            yield f"{name}.{key}", definition


KEYS = dict(_keys())


@pytest.mark.parametrize("key", KEYS)
def test_every_key_has_a_meaning(key: str) -> None:
    assert len(str(KEYS[key].get("description", ""))) > 5


@pytest.mark.parametrize("key", [key for key in KEYS if re.search("_(m|deg|gb)$", key)])
def test_every_length_and_angle_states_its_unit(key: str) -> None:
    unit = next(unit for ending, unit in UNITS.items() if key.endswith(ending))
    assert unit in str(KEYS[key]["description"])


def test_no_table_takes_unknown_keys() -> None:
    tables = [SCHEMA, *SCHEMA["$defs"].values()]
    assert all(table["additionalProperties"] is False for table in tables if "properties" in table)


def test_what_the_contract_demands_is_required() -> None:
    assert set(SCHEMA["required"]) == {"schema_version", "structure", "frame", "epochs"}
    assert "axes" in SCHEMA["$defs"]["Frame"]["required"]
