-- an alarm: what its events have made of it
WITH told AS (
    SELECT
        *,
        row_number() OVER (PARTITION BY structure, alarm ORDER BY happened_at, event) AS from_first,
        row_number() OVER (PARTITION BY structure, alarm ORDER BY happened_at DESC, event DESC) AS from_last
    FROM data.alarm_events
    WHERE action NOT IN ('delivered', 'delivery failed')
)

SELECT
    last.structure,
    last.epoch,
    last.rule,
    last.severity,
    last.value,
    last.limit_value,
    CASE
        WHEN last.action = 'closed' THEN 'closed'
        WHEN last.action = 'muted' THEN 'muted'
        WHEN last.action = 'acknowledged' THEN 'acknowledged'
        ELSE 'new'
    END AS state,
    first.happened_at AS raised_at,
    last.alarm,
    last.happened_at AS changed_at,
    last.person,
    last.note,
    last.until AS muted_until
FROM told AS last
INNER JOIN told AS first ON last.structure = first.structure AND last.alarm = first.alarm
WHERE last.from_last = 1 AND first.from_first = 1
