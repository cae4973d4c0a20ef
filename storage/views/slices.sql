-- a slice of an epoch under a scheme and method, with its part in the axis
SELECT *
FROM data.slices
