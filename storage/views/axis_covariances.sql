-- the covariance of two parameters of an axis
SELECT *
FROM data.axis_covariances
