"""The report as one web page that needs nothing beside it: no script, no font, no request."""

from pathlib import Path
from typing import Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from dashboard.report.blocks import Document
from dashboard.report.document import content_of

TEMPLATES: Final = Path(__file__).parent / "templates"

WIDE: Final = ("series", "plan", "profile", "slices", "schemes", "coverage")
"""Charts that a phone scrolls sideways rather than make too small to read."""


def html_of(document: Document) -> str:
    """Lay a report out as a web page; every text is escaped."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    css = (TEMPLATES / "report.css").read_text(encoding="utf-8")
    # ours, and drawn: the text in it is outlines
    charts = {name: Markup(svg) for name, svg in document.charts.items()}  # noqa: S704
    page = environment.get_template("report.html")
    return page.render(doc=content_of(document), charts=charts, css=Markup(css), wide=WIDE)  # noqa: S704
