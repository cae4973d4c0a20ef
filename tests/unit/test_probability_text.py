"""How a probability is written."""

import pytest

from tasks.geometry.probability_text import p_text


@pytest.mark.parametrize(
    ("p", "text"),
    [(0.031, "p = 0.031"), (1e-4, "p = 0.0001"), (9e-5, "p < 0.0001"), (0.0, "p < 0.0001"), (1.0, "p = 1")],
)
def test_what_no_model_can_tell_from_nothing_is_written_as_less_than(p: float, text: str) -> None:
    assert p_text(p) == text
