-- an alarm that was raised for an epoch
SELECT *
FROM data.alarms
