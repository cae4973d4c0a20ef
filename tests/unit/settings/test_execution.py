"""Where the stages run: what [execution] may say."""

from pathlib import Path

import pytest

from storage.errors import InputError
from tests.unit.settings.campaign_text import WHOLE, load


def executed(tmp_path: Path, *lines: str):
    return load(tmp_path, "\n".join([WHOLE, "[execution]", *lines, ""])).execution


def test_stages_run_here_where_nothing_is_said(tmp_path: Path) -> None:
    execution = load(tmp_path, WHOLE).execution
    assert (execution.engine, execution.address, execution.store) == ("local", None, None)


def test_memory_may_be_bounded(tmp_path: Path) -> None:
    assert executed(tmp_path).memory_gb is None
    assert executed(tmp_path, "memory_gb = 1.5").memory_gb == 1.5


def test_a_cluster_and_a_store_may_be_named(tmp_path: Path) -> None:
    address, store = 'address = "tcp://10.0.0.5:8786"', 'store = "s3://bucket/a/b/"'
    execution = executed(tmp_path, 'engine = "dask"', address, store, "epochs_at_once = 3")
    assert execution.address == "tcp://10.0.0.5:8786"
    assert execution.store == "s3://bucket/a/b"
    assert execution.epochs_at_once == 3


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (
            ('engine = "dask"',),
            r'engine = "dask" needs the address of its scheduler; add address = "tcp://host:8786"',
        ),
        (('address = "tcp://a:1"',), r"address tcp://a:1 is for dask only"),
        (
            ('engine = "dask"', 'address = "10.0.0.5:8786"'),
            r"is no address of a scheduler; as \"tcp://10.0.0.5:8786\"",
        ),
        (('engine = "ray"',), r"engine"),
        (('store = "bucket/x"',), r"names no bucket; as \"s3://bucket/prefix\""),
        (('store = "s3://key:secret@bucket/x"',), r"names no bucket"),
        (("epochs_at_once = 0",), r"epochs_at_once"),
        (("memory_gb = 0.1",), r"memory_gb"),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path: Path, lines: tuple[str, ...], told: str) -> None:
    with pytest.raises(InputError, match=told):
        executed(tmp_path, *lines)
