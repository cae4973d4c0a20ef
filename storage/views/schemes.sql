-- a scheme and method of an epoch: whether it gave an axis, and if not, why
SELECT *
FROM data.schemes
