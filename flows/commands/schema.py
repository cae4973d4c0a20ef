"""``tiltwatch schema``: the JSON Schema of the campaign file."""
# ruff: noqa: PLC0415 (imports stand where they are needed: a start must be quick)

import json

from flows.terminal import say


def schema() -> int:
    """Print the JSON Schema of the campaign file, for editors and programs."""
    from tasks.settings import Campaign

    say(json.dumps(Campaign.model_json_schema(), indent=2))
    return 0
