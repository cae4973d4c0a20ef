-- a piece of the shaft's surface in an epoch, a height band and a sector: its points and who saw it
SELECT *
FROM data.coverage
