-- an epoch against the reference epoch of its structure, under one scheme and method
-- The reference is the epoch marked as such (the earliest, should there be several), else the earliest that did
-- not fail. d is the change of the lean vector and C its covariance: from change_tests where the two epochs as they
-- are now were compared, with what they have in common cancelled; else the plain difference and the sum of both
-- covariances. Significant: chance alone does so in 1 of 100 comparisons, as far as both covariances hold.
WITH reference AS (
    SELECT structure, epoch
    FROM data.epochs
    QUALIFY row_number() OVER (
        PARTITION BY structure ORDER BY is_reference DESC, state = 'failed', epoch_time, epoch
    ) = 1
),

difference AS (
    SELECT
        later.structure,
        later.epoch,
        later.epoch_time,
        base.epoch AS reference_epoch,
        base.epoch_time AS reference_time,
        later.scheme,
        later.method,
        later.height_m,
        coalesce(compared.basis, 'sum of both') AS basis,
        coalesce(compared.d_east, later.lean_east - base.lean_east) AS d_lean_east,
        coalesce(compared.d_north, later.lean_north - base.lean_north) AS d_lean_north,
        if(compared.basis IS NULL, later.lean_cov_ee + base.lean_cov_ee, compared.d_cov_ee) AS d_cov_ee,
        if(compared.basis IS NULL, later.lean_cov_en + base.lean_cov_en, compared.d_cov_en) AS d_cov_en,
        if(compared.basis IS NULL, later.lean_cov_nn + base.lean_cov_nn, compared.d_cov_nn) AS d_cov_nn
    FROM data.tilt AS later
    INNER JOIN reference ON later.structure = reference.structure AND later.epoch <> reference.epoch
    INNER JOIN data.tilt AS base
        ON
            reference.structure = base.structure
            AND reference.epoch = base.epoch
            AND later.scheme = base.scheme
            AND later.method = base.method
    INNER JOIN data.epochs AS here ON later.structure = here.structure AND later.epoch = here.epoch
    INNER JOIN data.epochs AS there ON base.structure = there.structure AND base.epoch = there.epoch
    LEFT JOIN data.change_tests AS compared
        ON
            later.structure = compared.structure
            AND later.epoch = compared.epoch
            AND base.epoch = compared.reference_epoch
            AND later.scheme = compared.scheme
            AND later.method = compared.method
            AND compared.quantity = 'lean'
            AND here.run = compared.run
            AND there.run = compared.reference_run
),

measured AS (
    SELECT
        *,
        d_lean_east * d_lean_east + d_lean_north * d_lean_north AS d_squared,
        -- d' C d, whose ratio to d' d is the variance along the change
        d_cov_ee * d_lean_east * d_lean_east
        + 2 * d_cov_en * d_lean_east * d_lean_north
        + d_cov_nn * d_lean_north * d_lean_north AS d_c_d,
        -- the larger eigenvalue of C
        (d_cov_ee + d_cov_nn) / 2
        + sqrt(((d_cov_ee - d_cov_nn) / 2) * ((d_cov_ee - d_cov_nn) / 2) + d_cov_en * d_cov_en) AS largest,
        d_cov_ee * d_cov_nn - d_cov_en * d_cov_en AS determinant
    FROM difference
),

tested AS (
    SELECT
        *,
        -- d' C^-1 d; a covariance that is not positive definite tests nothing
        CASE
            WHEN determinant > 0 AND d_cov_ee > 0
                THEN (
                    d_cov_nn * d_lean_east * d_lean_east
                    - 2 * d_cov_en * d_lean_east * d_lean_north
                    + d_cov_ee * d_lean_north * d_lean_north
                ) / determinant
        END AS chi2
    FROM measured
)

SELECT
    structure,
    epoch,
    epoch_time,
    reference_epoch,
    reference_time,
    scheme,
    method,
    height_m,
    d_lean_east,
    d_lean_north,
    d_cov_ee,
    d_cov_en,
    d_cov_nn,
    height_m * sqrt(d_squared) AS d_top_m,
    CASE
        WHEN chi2 IS NULL THEN NULL
        WHEN d_squared > 0 THEN height_m * sqrt(d_c_d / d_squared)
        ELSE height_m * sqrt(largest)
    END AS sigma_top_m,
    chi2,
    -- exact for two degrees of freedom
    exp(-chi2 / 2) AS p_value,
    exp(-chi2 / 2) < 0.01 AS significant,
    -- 3.7257 = sqrt(13.8807): the noncentrality that a 1 % test of two degrees of freedom finds in 80 % of cases
    CASE WHEN chi2 IS NOT NULL THEN height_m * 3.7257 * sqrt(largest) END AS smallest_detectable_m,
    basis
FROM tested
