"""Records of stages come into place whole: two stages under one key may run at once, as those of two equal scans do."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from prefect import flow

from flows.stage_records import StageRecords, keep_records
from storage.workspace import open_workspace
from tasks.produced import Cost, Produced, record_result

ROUNDS = 150


def test_a_reader_never_meets_half_of_a_record(tmp_path: Path) -> None:
    workspace = open_workspace(tmp_path)
    records = StageRecords(place=workspace.place)
    produced = Produced(Cost(0.1, 10, None), facts={"notes": ["a long list"] * 20_000})
    content = json.dumps({"metadata": {}, "result": json.dumps(produced.to_json())}).encode()
    records.write_path("ingest-1", content)

    def write(_round: int) -> bool:
        records.write_path("ingest-1", content)
        return True

    def read(_round: int) -> bool:
        return record_result(records.read_path("ingest-1")) == produced

    with ThreadPoolExecutor(4) as pool:
        done = [pool.submit(work, number) for number in range(ROUNDS) for work in (write, read)]
        assert all(future.result() for future in done)


def test_the_records_of_a_workspace_on_this_machine_are_kept_so_too(tmp_path: Path) -> None:
    @flow
    def epoch() -> None:
        """Nothing."""

    kept = keep_records(epoch, open_workspace(tmp_path))
    assert isinstance(kept.result_storage, StageRecords)
    assert kept.result_storage.place == str(tmp_path)
