"""A cloud as Parquet: all digits, the station of every point, what the coordinates are in the metadata."""

from typing import BinaryIO, Final

import pyarrow.parquet as pq

from storage.drawing.cloud_tables import schema_of_cloud, tables_of
from storage.drawing.content import DrawnCloud

NAME: Final = "parquet"


def write(cloud: DrawnCloud, file: BinaryIO) -> None:
    """Write a cloud as Parquet, a row group a piece."""
    schema = schema_of_cloud(cloud)
    with pq.ParquetWriter(file, schema, compression="zstd", write_page_checksum=True) as writer:
        for table in tables_of(cloud):
            writer.write_table(table)
