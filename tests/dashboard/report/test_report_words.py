"""Both languages say the same things."""

import re
import string
from pathlib import Path

import pytest

import dashboard.report as package
from dashboard.report.blocks import Document
from dashboard.report.paper import pdf_of
from dashboard.report.words import LANGUAGES, words_of
from storage.errors import UsageError
from storage.workspace import Workspace
from tests.dashboard.report.reported import document, text_of

SOURCES = Path(package.__file__).parent


def places(text: str) -> set[str]:
    """Names in braces."""
    return {name for _, name, _, _ in string.Formatter().parse(text) if name}


def test_both_languages_have_the_same_keys_with_the_same_places() -> None:
    english, chinese = (words_of(lang).said for lang in LANGUAGES)
    assert set(english) == set(chinese)
    assert [key for key in english if places(english[key]) != places(chinese[key])] == []


def test_every_key_that_is_said_exists() -> None:
    sources = "\n".join(path.read_text() for path in SOURCES.rglob("*.py"))
    asked = set(re.findall(r'words\(\s*"([a-z_]+\.[a-z_]+)"', sources))
    assert len(asked) > 100
    assert asked - set(words_of("en").said) == set()


def test_chinese_is_set_in_chinese_with_the_same_numbers(published: Workspace, english: Document) -> None:
    chinese = document(published, lang="zh")
    assert (chinese.first.word, chinese.first.measured) == ("超限", english.first.measured)
    text = text_of(pdf_of(chinese))
    for term in ("倾斜", "垂直度", "方位角", "测站", "不确定度", "限值", "残差"):
        assert term in text
    assert set(chinese.charts) == set(english.charts)


def test_an_unknown_language_is_refused() -> None:
    with pytest.raises(UsageError, match="no report in language 'fr'; known: en, zh"):
        words_of("fr")


def test_a_stored_word_without_a_translation_is_said_as_it_is_stored() -> None:
    assert words_of("zh").named("state", "degraded") == "不完整"
    assert words_of("zh").named("state", "quite new") == "quite new"
