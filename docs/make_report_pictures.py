"""Draw the pages of docs/images that show the report, small enough for a page.

Of ``tiltwatch demo --workspace W --epochs 6 --stations 8 --points 60000``: ``PYTHONPATH=. .venv/bin/python
docs/make_report_pictures.py W/campaign/campaign.toml W``.
"""

import io
import sys
from pathlib import Path

from PIL import Image

from dashboard.report.paper import pictures_of
from flows.commands.options import load_with_workspace
from flows.commands.report import reported

HERE = Path(__file__).resolve().parent / "images"
COLORS = 128
DOTS_PER_INCH = 75.0
PAGES = {
    "report-1-verdict": ("en", 0),
    "report-3-course": ("en", 2),
    "report-4-shape": ("en", 3),
    "report-1-zh": ("zh", 0),
}
"""Name of the picture: language and page, from 0."""


def make(file: str, workspace: str) -> None:
    """Draw the pages of the newest epoch and keep them with few colours."""
    campaign = load_with_workspace(Path(file), Path(workspace))
    documents = {lang: reported(campaign, Path(workspace), None, lang)[1] for lang in ("en", "zh")}
    pages = {lang: pictures_of(document, DOTS_PER_INCH) for lang, document in documents.items()}
    for name, (lang, page) in PAGES.items():
        with Image.open(io.BytesIO(pages[lang][page])) as image:
            few = image.convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)
            few.save(HERE / f"{name}.png", optimize=True)


if __name__ == "__main__":
    make(*sys.argv[1:3])
