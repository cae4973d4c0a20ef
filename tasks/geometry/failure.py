"""The answer of a fit that the data do not allow."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FitFailure:
    """Data that cannot be fitted: a result to be stored, not an exception.

    ``reason`` is one lower-case clause that says what was needed and what came.
    """

    reason: str
