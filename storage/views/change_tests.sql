-- one quantity of an epoch against the reference epoch, with its test
-- Only of epochs as they are now: what was compared before one of the two was published anew is made anew by the next run.
SELECT tests.*
FROM data.change_tests AS tests
SEMI JOIN data.epochs AS here
    ON tests.structure = here.structure AND tests.epoch = here.epoch AND tests.run = here.run
SEMI JOIN data.epochs AS there
    ON
        tests.structure = there.structure
        AND tests.reference_epoch = there.epoch
        AND tests.reference_run = there.run
