-- two stations of an epoch whose scans were compared: how much they share and how well it fits
SELECT *
FROM data.pairs
