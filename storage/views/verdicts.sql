-- what one limit of the campaign says of the axis of an epoch under a scheme and method
SELECT *
FROM data.verdicts
