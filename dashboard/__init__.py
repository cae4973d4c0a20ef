"""Everything people look at: web pages, the report, the figures of the paper. It reads the catalog and nothing else."""
