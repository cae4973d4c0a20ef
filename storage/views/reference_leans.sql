-- a lean of an epoch that was measured by other means: total station, plumb line, inclinometer, GNSS at the top
SELECT *
FROM data.reference_leans
