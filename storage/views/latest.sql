-- the newest epoch of a structure, whatever became of it
SELECT *
FROM data.epochs
QUALIFY row_number() OVER (PARTITION BY structure ORDER BY epoch_time DESC, epoch DESC) = 1

