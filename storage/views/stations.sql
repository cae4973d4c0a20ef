-- a station of an epoch: its scan, its pose, and how well it is known
SELECT *
FROM data.stations
