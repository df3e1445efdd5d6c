"""Pages of calibrations, Level-1 estimates, trends and histories, made of the JSON that `gracecg` writes.

    python3 -m gracecg.pages RESULT.json PAGE.html

One page stands for itself: style and figures are in it. The folder PAGE_files has each figure as SVG and each table of
numbers behind them as CSV. The page comes last: it is whole, or it is not there.
"""
from __future__ import annotations

import csv
import json
import os
import pathlib
import re
from typing import Any, Iterable, Union

from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib import rc_context
from markupsafe import Markup, escape

from .. import plot

FIGURES = {         # Name: what it shows, in words
    "manoeuvre": ("The manoeuvre", "Two panels over time: dipole moment of the rods, and angular acceleration"),
    "ellipses": ("Error ellipses", "Ellipses of one sigma and of 95 % in the planes xy, xz and yz"),
    "residuals": ("Residuals over time", "Three panels over time: residuals of accelerometer axes x, y, z"),
    "spectrum": ("Spectrum of the residuals", "Three panels over frequency: spectrum of the residuals, x, y, z"),
    "currents": ("Currents and spans", "A panel for each span: currents of the three rods over time"),
    "field": ("The field over the spans", "Three components over time"),
    "fit": ("Acceleration and fit", "Three panels over time: x, y, z"),
    "sources": ("Sources side by side", "Three panels: x, y, z; a line for each source"),
    "trend": ("The offset over time", "Three panels over the years: x, y, z"),
    "history": ("The CG offset over time", "Three panels, x, y and z, over the years"),
}
KINDS = {           # Of a command: its template, its figures where there is a fit
    "estimate": ("calibration.html", ("manoeuvre", "ellipses", "residuals", "spectrum")),
    "level1 estimate": ("level1.html", ("sources", "currents", "field", "fit", "spectrum", "ellipses")),
    "level1 trend": ("trend.html", ("trend",)),
    "history": ("history.html", ("history",)),
    "report": ("report.html", ()),
}
MARKS = {"met": "✓", "partly": "⚠", "missed": "✗", "none": "•"}
COLOUR_NAMES = {colour: name for name, colour in plot.COLOURS.items()}
FOLDER = pathlib.Path(__file__).parent
MARKED = re.compile(r"[\^_]\{([^}]*)\}|(?<=[^\W_])[\^_](\d|[xyz](?![a-z]))")   # 10^{-9}, m/s^2, d_x in figures
PathLike = Union[str, "os.PathLike[str]"]


def make_page(source: PathLike, page: PathLike) -> pathlib.Path:
    """Makes the page of a command's JSON; returns the folder with its figures and numbers."""
    result = plot.load(source)
    page = pathlib.Path(page)
    if result.get("command") not in KINDS:
        raise ValueError(f"{source}: there is no page of {result.get('command', 'what is no result of gracecg')!r}")
    template, names = KINDS[result["command"]]
    if template == "report.html":
        folder = page.parent        # its files stand beside it
        figures = draw_blocks(result["blocks"], folder)
        for block in result["blocks"]:
            if block["block"] == "table":
                block["heads_at"] = places_of(block["heads"])
    else:
        folder = page.with_name((page.stem if page.suffix == ".html" and page.stem else page.name) + "_files")
        folder.mkdir(exist_ok=True)
        _clear(folder)
        tables = {**result.get("tables", {}), **({names[0]: plot.rows_table(result)} if template != "calibration.html" else {})}
        figures = {name: draw(result, name, folder) for name in names if tables and (name != "ellipses" or "refusal" not in result)}
        for name, columns in tables.items():
            write_csv(folder / f"{name}.csv", columns)
    html = render(template, {"r": result, "figures": figures, "page": page, "folder": folder,
                             "drawn": [f"{block['id']}.svg" for block in result.get("blocks", []) if block["block"] == "figure"]})
    part = page.with_name(page.name + ".part")
    part.write_text(html, encoding="utf-8")
    part.replace(page)
    return folder


def _clear(folder: pathlib.Path) -> None:
    """Removes the files of an older page, which would be taken for those of this one."""
    for old in (*folder.glob("*.svg"), *folder.glob("*.csv")):
        if old.stem in (*FIGURES, "spectrum_bands", "trend_lines"):
            old.unlink()


def write_csv(path: pathlib.Path, columns: dict[str, Iterable[Any]]) -> None:
    """A table of equally long columns."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values()))


def draw(result: plot.Result, name: str, folder: pathlib.Path) -> Markup:
    """Draws a figure into the folder; returns it fit to stand within a page."""
    return inline_svg(save(getattr(plot, name)(result), folder / f"{name}.svg"), name, *FIGURES[name])


def draw_blocks(blocks: list[dict[str, Any]], folder: pathlib.Path) -> dict[str, Markup]:
    """The figures and drawings of the report page."""
    figures = {}
    for block in blocks:
        if block["block"] == "figure":
            svg = save(plot.panels(block["panels"], folder), folder / f"{block['id']}.svg")
            figures[block["id"]] = inline_svg(svg, block["id"], block["title"], block["description"])
        elif block["block"] == "drawing":
            svg = (FOLDER / "drawings" / f"{block['name']}.svg").read_text(encoding="utf-8")
            title, description = (re.search(rf"<{tag} [^>]*>(.*?)</{tag}>", svg, re.S)[1] for tag in ("title", "desc"))  # type: ignore[index]
            svg = re.sub(r"<title.*?</title>|<desc.*?</desc>", "", svg, flags=re.S)
            figures[block["id"]] = inline_svg(svg, block["id"], Markup(title), Markup(description))
    return figures


def places_of(heads: list[str]) -> list[dict[str, int]]:
    """First column and count of columns of each head that is not empty: an empty one belongs to that before it."""
    firsts = [i for i, head in enumerate(heads) if head]
    return [{"first": i, "columns": after - i} for i, after in zip(firsts, [*firsts[1:], len(heads)])]


def save(figure: Any, path: pathlib.Path) -> str:
    """Writes a figure as SVG, in which ^{a} is raised and _{a} lowered, in a font narrower than that it was set with."""
    with rc_context(plot.STYLE):
        figure.savefig(path, metadata={"Date": None, "Creator": None})
    svg = re.sub(r"(<text [^>]*>)([^<]*)(?=</text>)", lambda found: found[1] + MARKED.sub(_shifted, found[2]),
                 path.read_text(encoding="utf-8"))
    svg = svg.replace("'DejaVu Sans'", "'Liberation Sans', Arial, Helvetica")
    path.write_text(svg, encoding="utf-8")
    return svg


def _shifted(found: re.Match[str]) -> str:
    """A raised or lowered part of a text in SVG; a space of no width goes back to its line."""
    up, back = ("-.45em", ".34em") if found[0][0] == "^" else (".3em", "-.22em")
    return f'<tspan dy="{up}" font-size="75%">{found[1] or found[2]}</tspan><tspan dy="{back}">\u200b</tspan>'


def inline_svg(svg: str, name: str, title: str, description: str) -> Markup:
    """An SVG document within a page: with a title, names of its own, the page's font, and colours of the page's scheme."""
    box = re.search(r'viewBox="[^"]*"', svg)
    body = svg[svg.index(">", svg.index("<svg")) + 1:]
    body = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>|<!--.*?-->", "", body, flags=re.S)
    body = re.sub(r'<g id="[^"]*"', "<g", body)
    body = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}_", body)
    body = re.sub(r"font: (\d+)px [^;\"]*", r"font-size: \1px", body)         # of older matplotlib
    body = re.sub(r"font-family: [^;\"]*;? ?", "", body)
    body = re.sub("|".join(COLOUR_NAMES), lambda found: f"var(--{COLOUR_NAMES[found[0]]})", body)
    body = re.sub(r"\n\s*", "\n", body)
    return Markup(f'<svg role="img" aria-labelledby="{name}_title {name}_desc" {box[0] if box else ""}>'
                  f'<title id="{name}_title">{escape(title)}</title><desc id="{name}_desc">{escape(description)}</desc>{body}')


def typeset(text: str) -> Markup:
    """A text with its marks: ^{a} raised, _{a} lowered, code between back quotes; all else escaped."""
    html = str(escape(re.sub(r"[\x00-\x08\x0b-\x1f\x7f]", " ", text)))
    html = re.sub(r"`([^`]+)`", r"<code>\1</code>", html)
    html = re.sub(r"\^\{([^}]*)\}", r"<sup>\1</sup>", html)
    return Markup(re.sub(r"_\{([^}]*)\}", r"<sub>\1</sub>", html))


def fixed(value: Any, decimals: int = 4) -> str:
    """A number with so many decimals; with an exponent from a million on; a dash for none."""
    if value is None:
        return "-"
    text = f"{value:.3E}" if abs(value) >= 1e6 else f"{value:.{decimals}f}"
    return text[1:] if re.fullmatch(r"-[0.]+", text) else text


def significant(value: Any, digits: int = 6) -> str:
    """A number with so many digits at most; a dash for none."""
    return "-" if value is None else f"{value:.{digits}g}"


def render(template: str, context: dict[str, Any]) -> str:
    """The whole page: the chapters of a template, with contents and style around them."""
    environment = Environment(loader=PackageLoader(__name__), autoescape=True, trim_blocks=True, lstrip_blocks=True,
                              undefined=StrictUndefined)
    environment.filters.update(t=typeset, f=fixed, g=significant, e=lambda value: "-" if value is None else f"{value:.2E}",
                               clock=lambda utc: utc.split("T")[1] if utc else "-", date=lambda utc: utc[:10])
    environment.globals.update(marks=MARKS, zip=zip)
    module = environment.get_template(template).make_module(context)
    chapters = str(module)
    contents = [(name, Markup(title)) for name, title in re.findall(r'<h2 id="([^"]+)">(.*?)</h2>', chapters)]
    style = (FOLDER / "style.css").read_text(encoding="utf-8")
    return environment.get_template("page.html").render(title=module.title, lead=module.lead, chapters=Markup(chapters),  # type: ignore[attr-defined]
                                                        contents=contents, style=Markup(style))
