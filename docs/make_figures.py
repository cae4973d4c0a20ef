"""Draw the pictures of docs/images that show the figures of the paper, small enough for a page.

Of ``tiltwatch demo --workspace W --epochs 1 --stations 8 --points 60000``: ``PYTHONPATH=. .venv/bin/python
docs/make_figures.py W/campaign/campaign.toml W``.
"""

import sys
import tempfile
from pathlib import Path

from PIL import Image

from flows.cli import main

HERE = Path(__file__).resolve().parent / "images"
COLORS = 96


def make(file: str, workspace: str) -> None:
    """Draw all figures of the newest epoch and keep them with few colours."""
    with tempfile.TemporaryDirectory() as folder:
        if main(["figures", file, "--workspace", workspace, "--out", folder]) != 0:
            sys.exit(1)
        for path in sorted(Path(folder).glob("*.png")):
            with Image.open(path) as image:
                small = image.convert("RGB").resize(
                    (image.width * 3 // 4, image.height * 3 // 4), Image.Resampling.LANCZOS
                )
                small.quantize(COLORS, dither=Image.Dither.NONE).save(HERE / path.name, optimize=True)


if __name__ == "__main__":
    make(*sys.argv[1:3])
