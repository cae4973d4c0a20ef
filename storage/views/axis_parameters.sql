-- a number that says where the axis of an epoch is, how it bends, or how wide the shaft is
SELECT *
FROM data.axis_parameters
