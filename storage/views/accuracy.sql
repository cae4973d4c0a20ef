-- one quantity of one scheme and method against the control scheme or a control measurement
SELECT *
FROM data.accuracy
