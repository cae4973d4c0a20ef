-- points of an epoch that were removed for one reason
SELECT *
FROM data.removals
