"""How many slices are enough follows from the figures, and the reason says so."""

import pytest

from tasks.accuracy import SchemeSigma, best_of, judge_slices, recommended_of
from tasks.geometry.failure import FitFailure

A = SchemeSigma("A/robust", "robust", 101, 101, 2.00e-3)
C = SchemeSigma("C/robust", "robust", 11, 11, 2.16e-3)
D = SchemeSigma("D/robust", "robust", 6, 6, 2.60e-3)
E = SchemeSigma("E/robust", "robust", 2, 2, 2.06e-3)
S = SchemeSigma("S/surface", "surface", 20, 20, 1.95e-3)


def recommended(*schemes: SchemeSigma, differs: bool | None = False) -> str | FitFailure:
    best = best_of(schemes)
    assert isinstance(best, SchemeSigma)
    return recommended_of(schemes, [judge_slices(scheme, best, differs) for scheme in schemes])


def test_the_fewest_slices_within_a_tenth_of_the_best_sigma_are_recommended() -> None:
    assert recommended(A, C, D) == "C/robust"


def test_two_centres_are_never_enough_however_small_their_sigma() -> None:
    tiny = SchemeSigma("E/paper", "paper", 2, 2, 1e-4)
    assert best_of([A, tiny]) == A
    judged = judge_slices(E, A, False)
    assert (judged.is_enough, judged.reason) == (
        False,
        "2 centres: a bad slice would go unnoticed; sigma 3 % above that of A/robust",
    )


def test_a_scheme_that_differs_significantly_is_not_enough() -> None:
    judged = judge_slices(C, A, True)
    assert judged.is_enough is False
    assert judged.reason == "differs significantly from A/robust; sigma 8 % above that of A/robust"


def test_a_sigma_of_twice_the_best_and_more_is_told_as_a_multiple() -> None:
    coarse = SchemeSigma("D/robust", "robust", 6, 6, 9.00e-3)
    assert judge_slices(coarse, A, False).reason == "sigma 4.5 times that of A/robust"


def test_what_cannot_be_told_is_neither_enough_nor_not() -> None:
    assert judge_slices(C, A, None).is_enough is None
    assert judge_slices(D, A, None).is_enough is False


def test_the_whole_surface_may_be_the_best_and_is_no_slicing() -> None:
    assert best_of([A, S]) == S
    assert recommended(A, C, S) == "A/robust"
    assert recommended(S) == FitFailure("needs a sliced scheme whose slices are enough; there is none")


def test_of_equal_slices_the_smaller_sigma_wins() -> None:
    paper = SchemeSigma("C/paper", "paper", 11, 11, 2.19e-3)
    assert recommended(A, paper, C) == "C/robust"


@pytest.mark.parametrize("schemes", [[], [E]])
def test_without_an_axis_of_three_centres_nothing_is_said(schemes: list[SchemeSigma]) -> None:
    assert best_of(schemes) == FitFailure(
        "needs an axis of at least 3 centres with a known sigma; there is none"
    )
