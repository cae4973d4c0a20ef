-- an epoch in the control chart of a scheme and method
SELECT *
FROM data.control_chart
