-- a stage of a run: whether it was computed or found in the cache, and what it took
SELECT *
FROM data.runs
