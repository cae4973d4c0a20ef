"""A marimo notebook: results of a catalog, and the numerics used from arrays.

In the browser: ``marimo edit docs/examples/notebook.py -- tiltwatch-data/catalog.duckdb``; as a plain program: ``python
docs/examples/notebook.py tiltwatch-data/catalog.duckdb``.
"""
# ruff: noqa: B018, PLC0415, PLR1711, T201 (cells are functions; their last value is shown)

import marimo

app = marimo.App(width="medium")


@app.cell
def _():
    import sys

    import duckdb
    import marimo as mo
    import matplotlib.pyplot as plt
    import numpy as np

    return duckdb, mo, np, plt, sys


@app.cell
def _(mo):
    mo.md(
        """
        # A chimney over time

        The catalog is opened read-only; a run may go on meanwhile. Columns: `docs/data-dictionary.md`.
        """
    )


@app.cell
def _(duckdb, sys):
    path = sys.argv[-1] if sys.argv[-1].endswith(".duckdb") else "tiltwatch-data/catalog.duckdb"
    with duckdb.connect(path, read_only=True) as catalog:
        tilt = catalog.sql(
            """
            SELECT t.* FROM tilt AS t
            JOIN scheme_comparison AS c USING (structure, epoch, scheme, method)
            WHERE c.compared = c.against AND t.structure = (SELECT min(structure) FROM epochs)
            ORDER BY t.epoch_time
            """
        ).df()
        if tilt.empty:  # nothing was compared yet: the first axis of every epoch
            tilt = catalog.sql(
                """
                SELECT * FROM tilt WHERE structure = (SELECT min(structure) FROM epochs)
                QUALIFY row_number() OVER (PARTITION BY epoch ORDER BY scheme DESC, method) = 1 ORDER BY epoch_time
                """
            ).df()
    print(tilt[["epoch", "scheme", "method", "deviation_m", "deviation_sigma_m", "verdict"]])
    return (tilt,)


@app.cell
def _(plt, tilt):
    series, axes = plt.subplots(figsize=(7, 3), layout="constrained")
    axes.errorbar(
        tilt["epoch_time"],
        1e3 * tilt["deviation_m"],
        yerr=2e3 * tilt["deviation_sigma_m"],
        fmt="o-",
        capsize=3,
    )
    axes.set_ylabel(f"deviation at {tilt['height_m'].iloc[0]:g} m (mm), ± U (k = 2)")
    axes.set_title(f"{tilt['structure'].iloc[0]}, {tilt['scheme'].iloc[0]}/{tilt['method'].iloc[0]}")
    series
    return


@app.cell
def _(mo):
    mo.md(
        """The top seen from above: every epoch with its 95 % ellipse, made of the covariance of the lean vector."""
    )


@app.cell
def _(np, plt, tilt):
    def ellipse(row):
        """Outline of the 95 % ellipse of the top, millimetres."""
        covariance = [[row.lean_cov_ee, row.lean_cov_en], [row.lean_cov_en, row.lean_cov_nn]]
        size, turn = np.linalg.eigh(np.array(covariance) * (1e3 * row.height_m) ** 2 * 5.991)
        angle = np.linspace(0.0, 2.0 * np.pi, 90)
        return turn @ (np.sqrt(size)[:, None] * [np.cos(angle), np.sin(angle)])

    plan, top = plt.subplots(figsize=(5, 5), layout="constrained")
    for row in tilt.itertuples():
        east, north = 1e3 * row.height_m * row.lean_east, 1e3 * row.height_m * row.lean_north
        (dot,) = top.plot(east, north, "o", label=row.epoch)
        if not np.isnan(row.lean_cov_ee):
            outline = ellipse(row)
            top.plot(east + outline[0], north + outline[1], color=dot.get_color(), lw=1)
    top.set(
        xlabel="east (mm)", ylabel="north (mm)", aspect="equal", title="the top above the foot, grid north up"
    )
    top.legend()
    plan
    return


@app.cell
def _(mo):
    mo.md("""The numerics work on arrays and know no files. A leaning cone with noise of 3 mm, measured:""")


@app.cell
def _(np):
    from tasks.measure import measure_lean
    from tasks.preprocessing import StructurePrior
    from tasks.registration import InstrumentSigmas

    rng = np.random.default_rng(1)
    z, angle = rng.uniform(2.0, 102.0, 60_000), rng.uniform(0.0, 2.0 * np.pi, 60_000)
    radius = 4.6 - 0.019 * (z - 2.0) + rng.normal(0.0, 0.003, z.size)
    points_m = np.column_stack([0.007 * z + radius * np.cos(angle), -0.005 * z + radius * np.sin(angle), z])

    prior = StructurePrior("chimney", shaft_z_m=(2.0, 102.0), base_xy_m=(0.0, 0.0), radius_m=(4.6, 2.7))
    sigmas = InstrumentSigmas(
        position_m=(0.015, 0.0225), heading_rad=np.radians(0.15), level_rad=np.radians(0.0008)
    )
    lean = measure_lean(points_m, prior, sigmas, scheme="A", method="robust")
    print(
        "lean east, north:", lean.lean, "true:", (0.007, -0.005), "sigma:", np.sqrt(np.diag(lean.covariance))
    )
    return


if __name__ == "__main__":
    app.run()
