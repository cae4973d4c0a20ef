-- a piece of the shaft's surface in an epoch, a height band and a sector: how far it is off its shape
SELECT *
FROM data.surface_map
