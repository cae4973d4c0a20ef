-- something that happened to an alarm
SELECT *
FROM data.alarm_events
