-- one quantity of an epoch against the reference epoch, with its test
SELECT *
FROM data.change_tests
