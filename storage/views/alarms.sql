-- an alarm: what its events have made of it
WITH told AS (
    SELECT
        *,
        CASE severity WHEN 'alarm' THEN 2 WHEN 'warning' THEN 1 ELSE 0 END AS grade
    FROM data.alarm_events
    WHERE action NOT IN ('delivered', 'delivery failed')
),

first AS (
    SELECT *
    FROM told
    QUALIFY row_number() OVER (PARTITION BY structure, alarm ORDER BY event) = 1
),

last AS (
    SELECT *
    FROM told
    QUALIFY row_number() OVER (PARTITION BY structure, alarm ORDER BY event DESC) = 1
),

-- what the rule found last
found AS (
    SELECT *
    FROM told
    WHERE action IN ('raised', 'updated', 'eased')
    QUALIFY row_number() OVER (PARTITION BY structure, alarm ORDER BY event DESC) = 1
),

-- the last word about it that is not the rule's
spoken AS (
    SELECT *
    FROM told
    WHERE action NOT IN ('raised', 'updated', 'eased')
    QUALIFY row_number() OVER (PARTITION BY structure, alarm ORDER BY event DESC) = 1
),

person AS (
    SELECT *
    FROM told
    WHERE person IS NOT NULL
    QUALIFY row_number() OVER (PARTITION BY structure, alarm ORDER BY event DESC) = 1
),

mute AS (
    SELECT *
    FROM told
    WHERE action IN ('muted', 'unmuted')
    QUALIFY row_number() OVER (PARTITION BY structure, alarm ORDER BY event DESC) = 1
),

mark AS (
    SELECT
        structure,
        alarm,
        bool_or(action = 'closed') AS is_closed,
        max(CASE WHEN action = 'acknowledged' THEN grade END) AS acknowledged_grade
    FROM told
    GROUP BY structure, alarm
)

SELECT
    found.structure,
    found.epoch,
    found.rule,
    found.severity,
    found.value,
    found.limit_value,
    CASE
        WHEN mark.is_closed THEN 'closed'
        WHEN mute.action = 'muted' THEN 'muted'
        -- one that has become graver since has to be acknowledged again
        WHEN mark.acknowledged_grade >= found.grade THEN 'acknowledged'
        ELSE 'new'
    END AS state,
    first.happened_at AS raised_at,
    found.alarm,
    last.happened_at AS changed_at,
    person.person,
    spoken.note,
    CASE WHEN mute.action = 'muted' THEN mute.until END AS muted_until,
    found.unit,
    found.note AS what,
    first.epoch AS raised_epoch,
    CASE WHEN found.action = 'eased' THEN found.happened_at END AS eased_at
FROM found
INNER JOIN first ON found.structure = first.structure AND found.alarm = first.alarm
INNER JOIN last ON found.structure = last.structure AND found.alarm = last.alarm
INNER JOIN mark ON found.structure = mark.structure AND found.alarm = mark.alarm
LEFT JOIN spoken ON found.structure = spoken.structure AND found.alarm = spoken.alarm
LEFT JOIN person ON found.structure = person.structure AND found.alarm = person.alarm
LEFT JOIN mute ON found.structure = mute.structure AND found.alarm = mute.alarm
