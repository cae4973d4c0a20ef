"""The rules of a campaign in words."""

from pathlib import Path

from flows.rule_words import rule_words
from tasks.alarms import RULES
from tasks.settings import load_campaign
from tasks.settings.alarms import DEFAULT_ALARMS
from tasks.simulated_campaign import write_simulated_campaign
from tasks.simulation.kinds import request_of_kind


def test_the_rules_that_hold_without_alarms_in_the_file_are_told_with_their_figures(tmp_path: Path) -> None:
    request = request_of_kind("silo", epochs=1, stations=3, points=200, seed=1)
    found = rule_words(load_campaign(write_simulated_campaign(tmp_path, request)))
    assert [words.rule for words in found] == [rule.id for rule in DEFAULT_ALARMS]
    first = found[0]
    assert first.settings == 'p = 0.05, quantity = "lean", confirm = false, clear_ratio = 0.9'
    assert (first.means, first.advice) == (RULES["moved"].description, RULES["moved"].advice)
