"""A library that a hostile record may name in the place of json."""

import json
from pathlib import Path


def loads(text: str, **_how: object) -> object:
    """Do what its author likes, and then what is asked for."""
    found = json.loads(text)
    Path(found["canary"]).touch()
    return found
