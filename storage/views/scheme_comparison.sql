-- a scheme and method of an epoch, or a reference measurement, against the primary: difference, workload, advice
SELECT *
FROM data.scheme_comparison
