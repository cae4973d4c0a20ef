-- the axis of an epoch under a scheme and method; the lean vector is the primary result
SELECT *
FROM data.tilt
