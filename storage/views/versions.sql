-- an epoch as it was published before, kept when it was processed anew
SELECT *
FROM data.versions
