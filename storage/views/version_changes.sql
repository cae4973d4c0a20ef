-- an axis as it was published before, and what has become of it
-- d is the present lean minus the earlier one, of the same epoch: what code, method or settings make of the same scans.
WITH compared AS (
    SELECT
        before.*,
        now.scheme IS NULL AS is_gone,
        now.lean_east - before.lean_east AS d_lean_east,
        now.lean_north - before.lean_north AS d_lean_north,
        now.lean_cov_ee + now.lean_cov_nn AS trace_now,
        before.lean_cov_ee + before.lean_cov_nn AS trace_before,
        before.lean_cov_ee * before.lean_cov_nn - before.lean_cov_en * before.lean_cov_en AS determinant,
        now.verdict AS verdict_now,
        now.lean_east = before.lean_east AND now.lean_north = before.lean_north
        AND now.lean_cov_ee IS NOT DISTINCT FROM before.lean_cov_ee
        AND now.lean_cov_en IS NOT DISTINCT FROM before.lean_cov_en
        AND now.lean_cov_nn IS NOT DISTINCT FROM before.lean_cov_nn AS is_same
    FROM data.version_tilt AS before
    LEFT JOIN data.tilt AS now
        ON
            before.structure = now.structure
            AND before.epoch = now.epoch
            AND before.scheme = now.scheme
            AND before.method = now.method
)

SELECT
    structure,
    epoch,
    epoch_time,
    version,
    scheme,
    method,
    CASE WHEN is_gone THEN 'gone' WHEN is_same THEN 'unchanged' ELSE 'changed' END AS outcome,
    height_m,
    d_lean_east,
    d_lean_north,
    height_m * sqrt(d_lean_east * d_lean_east + d_lean_north * d_lean_north) AS d_top_m,
    -- a covariance that is not positive definite measures nothing
    CASE
        WHEN determinant > 0 AND lean_cov_ee > 0
            THEN sqrt(
                (
                    lean_cov_nn * d_lean_east * d_lean_east
                    - 2 * lean_cov_en * d_lean_east * d_lean_north
                    + lean_cov_ee * d_lean_north * d_lean_north
                ) / determinant
            )
    END AS d_sigmas,
    CASE WHEN trace_before > 0 THEN sqrt(trace_now / trace_before) END AS sigma_ratio,
    verdict AS verdict_before,
    verdict_now,
    verdict_now <> verdict AS verdict_changed
FROM compared
