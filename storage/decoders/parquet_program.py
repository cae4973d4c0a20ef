"""What a decoder of Parquet scans does in its child process: pyarrow and NumPy.

It is run by its path (``storage/decoders``); nobody imports it for its functions.
"""

import math
import mmap
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

BUFFER_BYTES: Final = 1 << 20


class _Scan:
    """The scan that is being decoded."""

    file: Any = None
    source: Any = None
    batches: Any = None

    def open(
        self, _memory: mmap.mmap | None, path: str, footer_bytes: int, items: int
    ) -> tuple[list[str], list[dict[str, Any]]]:
        """Begin with a scan; tell the paths of its leaves, and of its columns what numbers they hold."""
        self.close(None)
        self.file = open(path.encode("latin-1"), "rb")  # noqa: PTH123, SIM115 - a place in bytes, closed by the next
        self.source = pq.ParquetFile(
            self.file,
            # streamed: otherwise Arrow reads whole column chunks, which may be as long as the file
            buffer_size=BUFFER_BYTES,
            pre_buffer=False,
            page_checksum_verification=True,
            thrift_string_size_limit=footer_bytes,
            thrift_container_size_limit=items,
        )
        schema = self.source.schema
        paths = [schema.column(leaf).path for leaf in range(len(schema))]
        return paths, [_told(field) for field in self.source.schema_arrow]

    def begin(self, _memory: mmap.mmap | None, names: list[str], piece_records: int) -> None:
        """Begin with the records of some columns."""
        self.batches = self.source.iter_batches(piece_records, columns=names, use_threads=False)

    def decode(self, memory: mmap.mmap, names: list[str]) -> tuple[int, int] | None:
        """Write the next records into the memory; tell how many, and how many lack a value, which is NaN there."""
        batch = next(self.batches, None)
        if batch is None:
            return None
        values = np.frombuffer(memory, np.float64, batch.num_rows * len(names)).reshape(-1, len(names))
        incomplete = np.zeros(batch.num_rows, dtype=np.bool_)
        for place, name in enumerate(names):
            column = batch.column(name)
            if column.null_count:
                incomplete |= column.is_null().to_numpy(zero_copy_only=False)
            values[:, place] = column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
        return batch.num_rows, int(np.count_nonzero(incomplete))

    def close(self, _memory: mmap.mmap | None) -> None:
        """Let go of the scan."""
        self.batches = self.source = None
        if self.file is not None:
            self.file.close()


def _told(field: pa.Field) -> dict[str, Any]:
    """Name and type of a column; the width of its floating-point numbers, or the step of its whole or decimal ones."""
    kind = field.type
    bits = kind.bit_width if pa.types.is_floating(kind) else None
    quantum = 1.0 if pa.types.is_integer(kind) else None
    if pa.types.is_decimal(kind):
        quantum = math.pow(10.0, -kind.scale)
    return {"name": field.name, "type_name": str(kind), "float_bits": bits, "quantum": quantum}


_SCAN: Final = _Scan()
HANDLERS: Final = {"open": _SCAN.open, "begin": _SCAN.begin, "decode": _SCAN.decode, "close": _SCAN.close}
