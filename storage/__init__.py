"""The record: rows with units, Parquet, artifacts by digest, the catalog. Knows nothing of Prefect."""
