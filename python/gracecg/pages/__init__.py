"""Pages of calibrations, Level-1 estimates, trends and histories, made of the JSON that `gracecg` writes.

    python3 -m gracecg.pages RESULT.json PAGE.html

One page stands for itself: style and figures are in it. The folder PAGE_files has each figure as SVG and each table of
numbers behind them as CSV. An older page goes before they change, and the new one comes last: a page and its folder belong
together, or there is no page.
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
from ..report import FIGURES as FIGURES_OF_REPORT, Report
from .findings import Findings, fixed, percent, whole_percent

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
}
MARKS = {"met": "✓", "partly": "⚠", "missed": "✗", "none": "•"}
COLOUR_NAMES = {colour: name for name, colour in plot.COLOURS.items()}
FOLDER = pathlib.Path(__file__).parent
MARKED = re.compile(r"[\^_]\{([^}]*)\}|(?<=[^\W_])[\^_](\d|[xyz](?![a-z]))")   # 10^{-9}, m/s^2, d_x in figures
PathLike = Union[str, "os.PathLike[str]"]


def make_page(source: PathLike, page: PathLike) -> str:
    """Makes the page of a command's JSON; returns what is to be said of it."""
    result = plot.load(source)
    page = pathlib.Path(page)
    if result.get("command") == "report":
        page.unlink(missing_ok=True)
        return _report_page(Report(source), page)
    if result.get("command") not in KINDS:
        raise ValueError(f"{source}: there is no page of {result.get('command', 'what is no result of gracecg')!r}")
    template, names = KINDS[result["command"]]
    folder = page.with_name((page.stem if page.suffix == ".html" and page.stem else page.name) + "_files")
    page.unlink(missing_ok=True)
    folder.mkdir(exist_ok=True)
    _clear(folder)
    tables = dict(result.get("tables", {}))
    if template != "calibration.html":
        tables[names[0]] = plot.rows_table(result)
    figures = {name: draw(result, name, folder) for name in names
               if tables and (name != "ellipses" or "refusal" not in result)}
    for name, columns in tables.items():
        write_csv(folder / f"{name}.csv", columns)
    _write(page, render(template, {"r": result, "figures": figures, "page": page, "folder": folder}))
    return ""


def _report_page(report: Report, page: pathlib.Path) -> str:
    """The page of the report, whose files stand beside it; returns the lines of its summary."""
    claims: list[dict[str, str]] = []

    def claim(source: str, anchor: str, said: str, found: str, kind: str, verdict: str) -> None:
        claims.append({"source": source, "anchor": anchor, "claim": said, "found": found, "kind": kind, "verdict": verdict})

    def draw_figure(name: str, title: str, description: str) -> Markup:
        return inline_svg(save(report.figure(name), report.folder / f"{name}.svg"), name, title, description)

    _write(page, render("report.html", {"r": report.result, "t": report, "found": Findings(report), "claims": claims,
                                        "claim": claim, "draw": draw_figure, "drawn": drawing,
                                        "figures": [f"{name}.svg" for name in FIGURES_OF_REPORT]}))
    return "\n".join(f"{line['source']:32}{line['verdict']}: {re.sub('[{}]', '', line['found'])}" for line in claims)


def _write(page: pathlib.Path, html: str) -> None:
    part = page.with_name(page.name + ".part")
    part.write_text(html, encoding="utf-8")
    part.replace(page)


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


def drawing(name: str, file: str) -> Markup:
    """A drawing fit to stand within a page, by the name of its file."""
    svg = (FOLDER / "drawings" / f"{file}.svg").read_text(encoding="utf-8")
    title, description = (re.search(rf"<{tag} [^>]*>(.*?)</{tag}>", svg, re.S)[1] for tag in ("title", "desc"))  # type: ignore[index]
    svg = re.sub(r"<title.*?</title>|<desc.*?</desc>", "", svg, flags=re.S)
    return inline_svg(svg, name, Markup(title), Markup(description))


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


def significant(value: Any, digits: int = 6) -> str:
    """A number with so many digits at most; a dash for none."""
    return "-" if value is None else f"{value:.{digits}g}"


def render(template: str, context: dict[str, Any]) -> str:
    """The whole page: the chapters of a template, with contents and style around them."""
    environment = Environment(loader=PackageLoader(__name__), autoescape=True, trim_blocks=True, lstrip_blocks=True,
                              undefined=StrictUndefined, extensions=["jinja2.ext.do"])
    environment.filters.update(t=typeset, f=fixed, pc=percent, wpc=whole_percent, g=significant, e=lambda value: "-" if value is None else f"{value:.2E}",
                               clock=lambda utc: utc.split("T")[1] if utc else "-", date=lambda utc: utc[:10])
    environment.globals.update(marks=MARKS, zip=zip)
    module = environment.get_template(template).make_module(context)
    chapters = str(module)
    contents = [(name, Markup(title)) for name, title in re.findall(r'<h2 id="([^"]+)">(.*?)</h2>', chapters)]
    style = (FOLDER / "style.css").read_text(encoding="utf-8")
    return environment.get_template("page.html").render(title=module.title, lead=module.lead, chapters=Markup(chapters),  # type: ignore[attr-defined]
                                                        contents=contents, style=Markup(style))
