"""What a page shows stands in its address."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dashboard.address import MOST_CHARACTERS, Address, address_of
from storage.errors import UsageError

texts = st.text(min_size=1, max_size=20)
some = st.one_of(st.none(), texts)
# a page's own choices have names of their own
own = st.dictionaries(st.from_regex(r"[a-z]{1,3}", fullmatch=True), texts, max_size=3)


@given(some, some, some, some, some, own)
def test_an_address_is_read_back_from_its_link(
    structure: str | None,
    epoch: str | None,
    reference: str | None,
    scheme: str | None,
    method: str | None,
    more: dict[str, str],
) -> None:
    address = Address("profile", structure, epoch, reference, scheme, method, more)
    path, _, query = address.href.partition("?")
    assert address_of(path, query) == address


def test_the_root_is_the_overview() -> None:
    assert address_of("/", "").page == "overview"


def test_another_page_keeps_what_is_chosen_but_not_the_choices_of_this_page() -> None:
    address = Address("slice", "chimney", "e1", more={"slice": "7"})
    assert address.at("profile") == Address("profile", "chimney", "e1")
    assert address.with_more(k="3").more == {"slice": "7", "k": "3"}


def test_an_endless_address_is_refused() -> None:
    with pytest.raises(UsageError, match="the address has"):
        address_of("/overview", "?x=" + "a" * MOST_CHARACTERS)
