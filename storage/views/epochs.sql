-- an epoch: one measuring campaign of a structure
SELECT *
FROM data.epochs
