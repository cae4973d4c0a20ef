-- a piece of the shaft's surface in an epoch against the reference epoch of its structure
-- The reference is that of the view changes. Pieces are the same where the height bands are, that is with the same
-- shaft_z_m in both epochs. The level of detection is that of Lague, Brodu & Leroux 2013 (M3C2): the points of two
-- epochs err independently, the poses move many pieces together, so their part is added and not squared.
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
        epochs.epoch_time,
        base.epoch AS reference_epoch,
        later.z_low_m,
        later.z_high_m,
        later.z_m,
        later.azimuth_deg,
        later.deviation_m - base.deviation_m AS change_m,
        1.96 * sqrt(
            later.deviation_sigma_m * later.deviation_sigma_m + base.deviation_sigma_m * base.deviation_sigma_m
        )
        + 1.96 * sqrt(
            later.placing_sigma_m * later.placing_sigma_m + base.placing_sigma_m * base.placing_sigma_m
        ) AS lod95_m,
        later.radius_m - base.radius_m AS radius_change_m,
        later.design_deviation_m - base.design_deviation_m AS design_change_m,
        1.96 * sqrt(
            later.design_sigma_m * later.design_sigma_m + base.design_sigma_m * base.design_sigma_m
        ) AS design_lod95_m
    FROM data.surface_map AS later
    INNER JOIN data.epochs AS epochs ON later.structure = epochs.structure AND later.epoch = epochs.epoch
    INNER JOIN reference ON later.structure = reference.structure AND later.epoch <> reference.epoch
    INNER JOIN data.surface_map AS base
        ON
            reference.structure = base.structure
            AND reference.epoch = base.epoch
            AND later.z_low_m = base.z_low_m
            AND later.z_high_m = base.z_high_m
            AND later.azimuth_deg = base.azimuth_deg
)

SELECT
    structure,
    epoch,
    epoch_time,
    reference_epoch,
    z_low_m,
    z_high_m,
    z_m,
    azimuth_deg,
    change_m,
    lod95_m,
    abs(change_m) > lod95_m AS significant,
    radius_change_m,
    design_change_m,
    design_lod95_m
FROM difference
