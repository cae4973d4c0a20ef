"""Draw docs/images/demo.png from the demo's workspace: `make demo`, then `.venv/bin/python docs/make_picture.py`.

Left the shaft as scanned, in the middle where the top is seen from above in every epoch with its 95 % ellipse and
the simulated truth, on the right how far the top moved since the first epoch, with k = 2 bars.
"""

import json
import sys
from pathlib import Path

import laspy
import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse

from storage.records import TiltRow
from storage.views import tilt_rows
from storage.workspace import existing_workspace
from tasks.conventions import rotation_site_scanner
from tasks.settings import Campaign, load_campaign

INK, BLUE, ORANGE, GREY = "#222222", "#0072B2", "#D55E00", "#9A9A9A"
CHI2_95 = 5.991


def main(workspace: Path, picture: Path) -> None:
    """Read the demo's workspace and write the picture."""
    campaign = load_campaign(workspace / "campaign" / "campaign.toml")
    rows = [
        row
        for row in tilt_rows(existing_workspace(workspace), campaign.structure.id)
        if (row.scheme, row.method) == campaign.report.primary
    ]
    truths = [json.loads((campaign.folder / row.epoch / "truth.json").read_text()) for row in rows]
    leans = np.array([truth["lean_fit"] for truth in truths])
    plt.rcParams.update(
        {"font.size": 9, "axes.edgecolor": GREY, "axes.spines.top": False, "axes.spines.right": False}
    )
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 4.4), width_ratios=(0.62, 1, 1.15))
    draw_scan(left, campaign, rows[0])
    draw_plan(middle, rows, leans)
    draw_series(right, rows, leans)
    figure.tight_layout(w_pad=2.5)
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=150, metadata={"Software": None})


def draw_scan(axes: Axes, campaign: Campaign, row: TiltRow) -> None:
    """Show one station's cloud from the side, and the axis that was found."""
    station = campaign.epochs[0].stations[0]
    points = laspy.read(campaign.scan_path(station.scan)).xyz @ rotation_site_scanner(
        float(np.radians(station.heading_deg))
    ).T + np.array(station.position_m)
    across = (
        points
        @ np.array([-station.position_m[1], station.position_m[0], 0.0])
        / np.hypot(*station.position_m[:2])
    )
    near = (np.abs(across) < 16) & (np.hypot(points[:, 0], points[:, 1]) < 16)
    axes.scatter(across[near][::5], points[near][::5, 2], s=0.3, color=GREY, linewidths=0)
    z = np.array([0.0, 110.0])
    axis = np.column_stack([row.base_east_m + row.lean_east * z, row.base_north_m + row.lean_north * z])
    side = (
        axis @ np.array([-station.position_m[1], station.position_m[0]]) / np.hypot(*station.position_m[:2])
    )
    axes.plot(side, z, color=BLUE, lw=1.2)
    axes.plot([0, 0], [0, 110], color=INK, lw=0.8, ls=(0, (4, 3)))
    axes.set(aspect="equal", xlabel="m", ylabel="height (m)", title=f"{station.id}: scan, axis, plumb line")


def draw_plan(axes: Axes, rows: list[TiltRow], leans: np.ndarray) -> None:
    """Show the top from above, relative to the first epoch found."""
    height_mm = 1000 * rows[0].height_m
    origin = np.array([rows[0].lean_east, rows[0].lean_north])
    found = height_mm * (np.array([[row.lean_east, row.lean_north] for row in rows]) - origin)
    true = height_mm * (leans - origin)
    axes.plot(*true.T, "x", color=ORANGE, ms=7, mew=1.6, label="truth of the simulation")
    axes.plot(*found.T, "o-", color=BLUE, ms=4, lw=0.8, label="found")
    for row, place in zip(rows, found, strict=True):
        c = height_mm**2 * np.array(
            [[row.lean_cov_ee, row.lean_cov_en], [row.lean_cov_en, row.lean_cov_nn]], float
        )
        values, vectors = np.linalg.eigh(c)
        angle = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
        size = 2 * np.sqrt(CHI2_95 * values[::-1])
        axes.add_patch(
            Ellipse((float(place[0]), float(place[1])), *size, angle=angle, fill=False, color=BLUE, lw=0.8)
        )
        axes.annotate(row.epoch, place, textcoords="offset points", xytext=(9, 7), color=INK, fontsize=8)
    axes.set(aspect="equal", xlabel="east (mm)", ylabel="north (mm)", title="top from above, 95 % ellipses")
    axes.margins(0.18)
    axes.legend(frameon=False, loc="lower left", fontsize=8)


def draw_series(axes: Axes, rows: list[TiltRow], leans: np.ndarray) -> None:
    """Show the movement of the top along its true direction, with k = 2 bars."""
    height_mm = 1000 * rows[0].height_m
    direction = (leans[-1] - leans[0]) / np.linalg.norm(leans[-1] - leans[0])
    found = height_mm * np.array(
        [[row.lean_east - rows[0].lean_east, row.lean_north - rows[0].lean_north] for row in rows]
    )
    true = height_mm * (leans - leans[0]) @ direction
    covariances = [
        np.array([[r.lean_cov_ee, r.lean_cov_en], [r.lean_cov_en, r.lean_cov_nn]], float) for r in rows
    ]
    variance = np.array([direction @ c @ direction for c in covariances])
    # the reference itself has no bar: it is what the others are counted from
    sigma = height_mm * np.sqrt(variance + variance[0]) * (np.arange(len(rows)) > 0)
    days = [row.epoch_time for row in rows]
    axes.plot(days, true, "x", color=ORANGE, ms=7, mew=1.6)
    axes.errorbar(days, found @ direction, yerr=2 * sigma, fmt="o", color=BLUE, ms=4, capsize=3, lw=1)
    axes.axhline(0, color=GREY, lw=0.6)
    axes.set(
        ylabel="mm", title=f"movement of the top at {rows[0].height_m:g} m since {rows[0].epoch} (k = 2)"
    )
    axes.set_xticks(days, [row.epoch for row in rows])


if __name__ == "__main__":
    main(
        Path(sys.argv[1] if len(sys.argv) > 1 else "tiltwatch-demo"),
        Path(__file__).parent / "images" / "demo.png",
    )
