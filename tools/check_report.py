#!/usr/bin/env python3
"""Makes the report page with few runs and checks it.

    tools/check_report.py PROGRAM [FOLDER]    prints what is wrong; status 1 if anything is. With a FOLDER the
                                              page stays there, for tools/check_pages.py

The page: well-formed, self-contained, every table, figure and published value in it, figures with
title and description, headings in order, links that lead somewhere, the same whatever the number of threads. The files
beside it: columns, figures. The program's Python is that of tools/setup.sh pages; here the standard library does.
"""
import csv
import html.parser
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RUNS = "15"
VOID = {"meta", "link", "br", "img", "hr", "input"}
DRAWINGS = ["2_1", "2_2", "3_2", "4_1", "5_1"]
FIGURES = ["3_1", "5_2", "5_3", "5_4", "5_5", "5_6", "5_7", "5_8", "6_1", "6_2", "6_3", "6_4", "6_5", "6_6",
           "bound", "manoeuvre_map"]
TABLES = ["1_1", "1_2", "5_1", "6_1", "6_2"]
STATEMENTS = ["one-rod", "dominance", "arc-length", "weights", "accuracy", "curved-force", "condition", "two-steps", "stars"]
MORE_TABLES = ["bound_table", "designed_manoeuvres", "designed_reached"] + [f"statement_{s}" for s in STATEMENTS]
COLUMNS = {
    "montecarlo.csv": "case,algorithm,axis,runs,rms_mm,mean_error_mm,std_mm,predicted_mm,published_mm",
    "montecarlo_runs.csv": "case,algorithm,run,dx_mm,dy_mm,dz_mm,converged,normalised",
    "errors.csv": "source,axis,runs,rms_mm,predicted_mm",
    "statements.csv": "statement,case,setting,runs,rms_x_mm,rms_y_mm,rms_z_mm,predicted_x_mm,predicted_y_mm,"
                      "predicted_z_mm,condition,torque_ratio,stars,sigma_x_arcsec,sigma_y_arcsec,sigma_boresight_arcsec",
    "magnetometer_loss.csv": "case,algorithm,magnetometer,axis,runs,rms_mm,predicted_mm",
    "magnetometer_loss_runs.csv": "case,algorithm,magnetometer,run,dx_mm,dy_mm,dz_mm",
    "gravity_gradient.csv": "time_s,central_r_m_s2,central_t_m_s2,central_n_m_s2,"
                            "others_r_m_s2,others_t_m_s2,others_n_m_s2",
    "timing_front.csv": "time_s,utc,latitude_deg,longitude_deg,bx_nt,by_nt,bz_nt,alpha_x_rad_s2,"
                        "alpha_y_rad_s2,alpha_z_rad_s2,"
                        "sigma_x_mm,sigma_y_mm,sigma_z_mm",
}
COLUMNS["bound.csv"] = "case,algorithm,axis,runs,rms_mm,bound_mm,ratio,sampling_error,at_the_bound,not_converged"
COLUMNS["windows.csv"] = ("case,quantity,axis,unit,least,greatest,mean,figure,low,high,fill,inside,on_ticks,"
                          "attitude_only,excess,near_centre,centre_difference")
COLUMNS["com_budget.csv"] = "table,effect,dx_mm,dy_mm,dz_mm"
COLUMNS["designed_manoeuvres.csv"] = "satellite,rod,waveform,amplitude_a_m2,frequency_hz,phase_deg,start_s,stop_s"
COLUMNS["design.csv"] = "case,axis,bound_mm,runs,rms_mm,rms_after_trim_mm"
for satellite in ("front", "back"):
    COLUMNS[f"manoeuvre_map_{satellite}.csv"] = (
        "time_s,latitude_deg,longitude_deg,report_x_mm,report_y_mm,report_z_mm,report_worst_mm,"
        "designed_x_mm,designed_y_mm,designed_z_mm,designed_worst_mm")
COLUMNS["timing_back.csv"] = COLUMNS["timing_front.csv"]
CURVES = ["drag", "srp", "erp", "non_gravitational", "a_vel", "a_gg", "a_acc", "a_total", "torque_aero",
          "torque_solar", "torque_gravity", "torque_magnetic", "torque_total", "omega", "omega_dot"]


def unit_of(curve):
    """As the names of columns end."""
    if curve.startswith("omega"):
        return "rad_s2" if curve == "omega_dot" else "rad_s"
    return "n_m" if curve.startswith("torque") else "m_s2"


for case in ("front-1", "back-1"):
    COLUMNS[f"verify_{case}.csv"] = ",".join(["time_s"] + [f"{c}_{a}_{unit_of(c)}" for c in CURVES for a in "xyz"])
ROWS = {"verify_front-1.csv": 601, "verify_back-1.csv": 601, "montecarlo.csv": 72, "montecarlo_runs.csv": 24 * int(RUNS),
        "errors.csv": 15, "statements.csv": 106, "bound.csv": 108, "design.csv": 18, "manoeuvre_map_front.csv": 94, "manoeuvre_map_back.csv": 94,
        "windows.csv": 90, "com_budget.csv": 21, "designed_manoeuvres.csv": 6, "magnetometer_loss.csv": 24, "magnetometer_loss_runs.csv": 8 * int(RUNS)}

problems = []


def wrong(message):
    problems.append(message)


class Page(html.parser.HTMLParser):
    """Tags in balance, ids, links, headings, and what each table and svg has."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links, self.headings, self.outside = [], [], [], [], []
        self.svgs, self.language, self.values = [], None, []
        self.in_value = False
        self.feed(text)
        self.close()
        if self.open:
            wrong(f"not closed: {self.open}")

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag not in VOID:
            self.open.append(tag)
        if "id" in attributes:
            self.ids.append(attributes["id"])
        for name in ("href", "src", "xlink:href", "srcset", "action"):
            if name in attributes:
                self.links.append(attributes[name])
        if tag in ("script", "iframe", "object", "embed", "img") or (tag == "link" and attributes.get("href") != "data:,"):
            self.outside.append(tag)
        if re.fullmatch("h[1-6]", tag):
            self.headings.append(int(tag[1]))
        if tag == "html":
            self.language = attributes.get("lang")
        if tag == "th" and "scope" not in attributes:
            wrong("a th without scope")
        if tag == "svg":
            self.svgs.append(attributes)
        self.in_value = tag == "span" and attributes.get("class") == "value"

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if not self.open or self.open[-1] != tag:
            wrong(f"</{tag}> closes {self.open[-1:]} at line {self.getpos()[0]}")
        else:
            self.open.pop()

    def handle_data(self, data):
        if self.in_value:
            self.values.append(data)
        self.in_value = False


def run(program, folder, *options):
    return subprocess.run([program, "report", "--out", str(folder), "--runs", RUNS, *options],
                          capture_output=True, text=True, check=False)


def published_values():
    """As the page shows them: five decimals, the misprint mended."""
    lines = [l for l in (ROOT / "data/report_rms_tables.csv").read_text().splitlines() if not l.startswith("#")]
    values = []
    for row in csv.DictReader(lines):
        for algorithm in ("assest_fde", "assest_rde", "ascfest", "ascrest"):
            value = "0.1112" if row[algorithm] == "0.01112" else row[algorithm]
            values.append(f"{float(value):.5f}")
    return values


def check_page(folder):
    text = (folder / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    if page.language != "en":
        wrong("no language")
    if len(page.ids) != len(set(page.ids)):
        wrong(f"ids twice: {sorted({i for i in page.ids if page.ids.count(i) > 1})[:5]}")
    for name in [f"figure_{f}" for f in DRAWINGS + FIGURES] + [f"table_{t}" for t in TABLES] + MORE_TABLES:
        if name not in page.ids:
            wrong(f"{name} is not on the page")
    for link in page.links:
        if link == "data:,":
            continue
        if link.startswith("#"):
            if link[1:] not in page.ids:
                wrong(f"{link} leads nowhere")
        elif "/" in link or ":" in link or not (folder / link).is_file():
            wrong(f"the link {link} leads out of the folder or nowhere")
    if page.outside:
        wrong(f"not self-contained: {page.outside}")
    if re.search(r"https?://(?!www\.w3\.org/)|@import|url\((?!#)", text):
        wrong("an address outside of the page")
    if page.headings[0] != 1 or page.headings.count(1) != 1:
        wrong("not one h1 at the beginning")
    if any(after > before + 1 for before, after in zip(page.headings, page.headings[1:])):
        wrong("headings leave a level out")
    if len(page.svgs) < len(DRAWINGS + FIGURES):
        wrong(f"{len(page.svgs)} figures drawn")
    for svg in page.svgs:
        names = svg.get("aria-labelledby", "").split()
        if svg.get("role") != "img" or len(names) != 2 or not set(names) <= set(page.ids) or "viewbox" not in svg:
            wrong(f"a figure without role, title, description or viewBox: {svg}")
        if "width" in svg or "height" in svg:
            wrong("a figure with a fixed size")
    values = list(page.values)
    for value in published_values():
        if value in values:
            values.remove(value)
        else:
            wrong(f"the published value {value} is not on the page")
    if re.search(r"NaN|Infinity|\*\*\*", re.sub(r"<svg.*?</svg>", "", text, flags=re.S)):
        wrong("a number that is none")
    if "71 of 72" not in text or "54 of 54" not in text:
        wrong("the verdicts are others")
    return text


def check_files(folder):
    for name, header in COLUMNS.items():
        lines = [l for l in (folder / name).read_text().splitlines() if not l.startswith("#")]
        if lines[0] != header:
            wrong(f"{name}: the columns are {lines[0]}")
        if name in ROWS and len(lines) - 1 != ROWS[name]:
            wrong(f"{name}: {len(lines) - 1} rows")
        if any(line.count(",") != header.count(",") for line in lines):
            wrong(f"{name}: rows of different length")
    rows = [l.split(",") for l in (folder / "bound.csv").read_text().splitlines() if not l.startswith("#")][1:]
    if {r[1] for r in rows} != {"assest-fde", "assest-rde", "ascfest", "ascrest", "optimal", "sequential"}:
        wrong("bound.csv: the algorithms are others")
    for satellite in ("front", "back"):
        if "waveform = 'square'" not in (folder / f"designed_{satellite}.nml").read_text():
            wrong(f"designed_{satellite}.nml: no square waves")
    left = [p.name for p in folder.iterdir() if ".part" in p.name or p.suffix == ".log"]
    if left:
        wrong(f"left behind: {left}")


def check_figures(folder):
    """Each figure is a file of its own, too, with curves and without what is no number."""
    for name in FIGURES:
        drawn = (folder / f"figure_{name}.svg").read_text(encoding="utf-8")
        if "NaN" in drawn or ">nan<" in drawn or drawn.count("<path") < 5:
            wrong(f"figure_{name}.svg: no curves, or not a number")


def main():
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        done = run(program, folder / "report")
        said = [line for line in done.stderr.splitlines() if not re.match(r"\d+/\d+ parts, ", line)]   # progress
        if done.returncode != 0 or said:
            print(f"status {done.returncode}: {done.stderr}")
            return 1
        text = check_page(folder / "report")
        check_files(folder / "report")
        if len(sys.argv) > 2:
            shutil.rmtree(sys.argv[2], ignore_errors=True)
            shutil.copytree(folder / "report", sys.argv[2])
        check_figures(folder / "report")
        strange = folder / "it's \"another\" $folder"
        run(program, strange, "--threads", "1")
        if (strange / "index.html").read_text(encoding="utf-8") != text:
            wrong("another number of threads or another folder gives another page")
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
