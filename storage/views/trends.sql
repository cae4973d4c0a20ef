-- the trend of a structure over its epochs, under one scheme and method
SELECT *
FROM data.trends
