-- the axis of an epoch under a scheme and method as it was published before
SELECT *
FROM data.version_tilt
