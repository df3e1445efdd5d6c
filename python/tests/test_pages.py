"""Pages and figures of what the program writes: complete, standing for themselves, honest about what is missing.

GRACECG_PROGRAM names the program; without it only the tests that need no result of it run.
"""
import csv
import html.parser
import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("jinja2")
pytest.importorskip("matplotlib")

from gracecg import pages, plot
from gracecg.pages.findings import Findings
from gracecg.report import Report

PROGRAM = os.environ.get("GRACECG_PROGRAM")
needs_program = pytest.mark.skipif(PROGRAM is None, reason="GRACECG_PROGRAM is not set")
CHAPTERS = ["result", "observed", "manoeuvre", "ellipsoid", "dependence", "residuals-chapter", "verdict", "provenance"]
VOID = {"meta", "link", "br", "path", "use", "rect"}


def run(folder, *words, status=0):
    ended = subprocess.run([PROGRAM, *words], cwd=folder, capture_output=True, text=True, check=False,
                           env={**os.environ, "GRACECG_PYTHON": sys.executable})
    assert ended.returncode == status, ended.stderr
    return ended.stdout


class Reader(html.parser.HTMLParser):
    """Tags in balance, each id once, links within the page that lead somewhere."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links = [], [], []
        self.feed(text)
        assert not self.open
        assert len(self.ids) == len(set(self.ids))
        assert all(link[1:] in self.ids for link in self.links if link.startswith("#"))
        assert not [link for link in self.links if not link.startswith(("#", "data:"))]

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.ids += [attributes["id"]] if "id" in attributes else []
        self.links += [attributes[name] for name in ("href", "xlink:href", "src") if name in attributes]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def front(tmp_path_factory):
    """A folder with the page of a calibration, front.html."""
    folder = tmp_path_factory.mktemp("front")
    run(folder, "simulate", "front-1", "--out", "run")
    run(folder, "estimate", "run", "--algorithm", "optimal", "--report", "front.html")
    return folder


@needs_program
def test_page_of_a_calibration(front):
    text = (front / "front.html").read_text()
    page, result = Reader(text), json.loads((front / "front_files/result.json").read_text())
    assert all(name in page.ids for name in CHAPTERS)
    assert text.count("<svg") == 4 and "<script" not in text and "NaN" not in text and "None" not in text
    assert f"{1e3*result['offset_m'][0]:.4f}" in text and result["action"]["text"][1:] in text
    for finding in result["verdict"]["findings"]:
        assert str(pages.typeset(finding["text"])) in text
    assert "moments_of_inertia" in text and "gracecg estimate run --algorithm optimal --report front.html" in text
    for name in ("--blue", "--orange", "--green"):
        assert f"var({name})" in text
    assert "#0072b2" not in text[text.index("<main>"):]


@needs_program
def test_files_of_a_page(front):
    result = json.loads((front / "front_files/result.json").read_text())
    for name, columns in result["tables"].items():
        with (front / f"front_files/{name}.csv").open() as file:
            rows = list(csv.reader(file))
        assert rows[0] == list(columns)
        assert np.array_equal(np.array(rows[1:], dtype=float), np.array(list(columns.values())).T)
    assert {path.stem for path in (front / "front_files").glob("*.svg")} == {"manoeuvre", "ellipses", "residuals", "spectrum"}


@needs_program
def test_same_page_again(front, monkeypatch):
    first = (front / "front.html").read_bytes()
    monkeypatch.chdir(front)
    pages.make_page("front_files/result.json", "front.html")
    assert (front / "front.html").read_bytes() == first


@needs_program
def test_no_page_beside_the_folder_of_another(front, tmp_path, monkeypatch):
    """Where the making ends half-way, an older page does not stand beside newer figures."""
    shutil.copy(front / "front_files/result.json", tmp_path / "result.json")
    for part in ("save", "render"):
        pages.make_page(tmp_path / "result.json", tmp_path / "a.html")
        assert (tmp_path / "a.html").exists()
        with monkeypatch.context() as broken, pytest.raises(KeyboardInterrupt):
            broken.setattr(pages, part, lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
            pages.make_page(tmp_path / "result.json", tmp_path / "a.html")
        assert not (tmp_path / "a.html").exists()


@needs_program
def test_refused_and_unread(front):
    setup = front / "run/setup.nml"
    known = setup.read_text()
    setup.write_text(known.replace("amplitude = 30 ", "amplitude = 14 "))
    run(front, "estimate", "run", "--algorithm", "assest-fde", "--report", "bad.html", status=1)
    text = (front / "bad.html").read_text()
    Reader(text)
    assert "refused</h1>" in text and "did the rods fire as the setup says?" in text and text.count("<svg") == 3
    assert "Offset of the centre of gravity" not in text and (front / "bad_files/residuals.csv").exists()
    setup.unlink()      # and what the older page had is gone
    run(front, "estimate", "run", "--algorithm", "assest-fde", "--report", "bad.html", status=1)
    text = (front / "bad.html").read_text()
    Reader(text)
    assert "no residuals to show" in text and "<svg" not in text
    assert [path.name for path in (front / "bad_files").iterdir()] == ["result.json"]
    setup.write_text(known)


@needs_program
def test_history(front):
    run(front, "history", "front_files/result.json", "--today", "1989-06-01", "--limit-mm", "1", "--report", "history.html")
    text = (front / "history.html").read_text()
    Reader(text)
    assert "It will hardly leave 1 mm within 20 years" in text and "Calibrate by" not in text
    run(front, "history", "front_files/result.json", "--today", "1989-06-01", "--limit-mm", "0.6", "--walk-um", "60", "--report",
        "history.html")
    assert "It will leave 0.6 mm on" in (front / "history.html").read_text()
    assert text.count("<svg") == 1 and (front / "history_files/history.csv").exists()


@needs_program
def test_level1(tmp_path):
    dates = ("2020-02-01", "2020-11-20")
    for date in dates:
        (tmp_path / "level1.nml").write_text(f"&level1_simulation\n spans = 2, epoch = '{date}'\n/\n")
        run(tmp_path, "level1", "simulate", "front-1", "--level1", "level1.nml", "--out", date)
        run(tmp_path, "level1", "estimate", date, "--setup", f"{date}/setup.nml", "--report", f"{date}.html")
    text = (tmp_path / f"{dates[0]}.html").read_text()
    Reader(text)
    assert text.count("<svg") == 6 and "no-gyros" in text and "None" not in text
    unseen = json.loads((tmp_path / f"{dates[0]}_files/result.json").read_text())["beliefs"]["undetected_as_stated_mm"]
    assert "unseen by up to " + ", ".join(f"{1000*value:.0f}" for value in unseen) + " micrometres" in text
    run(tmp_path, "level1", "trend", *(f"{date}_files/result.json" for date in dates), "--report", "trend.html")
    text = (tmp_path / "trend.html").read_text()
    Reader(text)
    assert text.count("<svg") == 1 and "2020-11-20" in text


@needs_program
def test_figures_in_a_notebook(front):
    result = json.loads((front / "front_files/result.json").read_text())
    axes = plot.ellipses(front / "front_files/result.json").axes[0]
    one_sigma = axes.lines[1].get_xydata()
    middle, sigma = 1e3*np.array(result["offset_m"][:2]), 1e3*np.sqrt(np.diag(result["covariance"]["matrix"])[:2])
    assert np.allclose(one_sigma.max(axis=0), middle + sigma, rtol=1e-3)
    assert np.allclose(one_sigma.min(axis=0), middle - sigma, rtol=1e-3)
    assert 1 - np.exp(-plot.ELLIPSE_95**2/2) == pytest.approx(0.95, abs=1e-8)
    line = plot.residuals(result).axes[1].lines[0].get_ydata()
    assert np.allclose(line, 1e9*np.array(result["tables"]["residuals"]["y_m_s2"]))


def test_figures_of_the_package():
    try:
        from gracecg import calibration as gracecg
    except (ImportError, OSError):
        pytest.skip("the package is not built: there is no shared library beside it")
    fit = gracecg.Case("front-3").simulator().observe(seed=1, run=1).fit("optimal")
    shown = plot.spectrum(fit).axes[1].lines[0].get_xydata()
    residual = fit.series()["residual"][:, 1]
    step = shown[1, 0] - shown[0, 0]
    assert np.isclose(np.sum(shown[:, 1]**2)*step, np.var(residual), rtol=0.1)       # Parseval
    for figure in (plot.ellipses(fit.solution), plot.ellipses(fit), plot.residuals(fit), plot.manoeuvre(fit)):
        assert figure.axes


def test_texts_are_escaped():
    assert pages.typeset("a < `b & c` m^{2} d_{x}\x07") == "a &lt; <code>b &amp; c</code> m<sup>2</sup> d<sub>x</sub> "
    assert pages.fixed(-0.00001, 3) == "0.000" and pages.percent(0.1838) == "18.4 %" and pages.fixed(None) == "-" and pages.fixed(2e6, 1) == "2.000E+06"


def test_what_is_no_result(tmp_path):
    (tmp_path / "x.json").write_text('{"command": "design"}')
    with pytest.raises(ValueError, match="there is no page of 'design'"):
        pages.make_page(tmp_path / "x.json", tmp_path / "x.html")
    assert not (tmp_path / "x.html").exists()
    ended = subprocess.run([sys.executable, "-m", "gracecg.pages", "nowhere.json", "x.html"], capture_output=True, text=True,
                           check=False, cwd=tmp_path, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    assert ended.returncode == 1 and "nowhere.json" in ended.stderr and "Traceback" not in ended.stderr


def test_pages_do_without_the_library():
    code = "import sys, gracecg.pages; sys.exit('gracecg._library' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_report_tables(tmp_path):
    (tmp_path / "result.json").write_text('{"command": "report", "runs": 15}')
    (tmp_path / "printed_axes.csv").write_text("figure,satellite,panel,axis,low,high,step\n" + "".join(
        f"6.5,front,ascfest,{axis},0,1.5e-4,5e-5\n" for axis in "xyz"))
    (tmp_path / "errors.csv").write_text("source,axis,runs,rms_mm,predicted_mm\nall-noise,x,15,0.18,\n")
    report = Report(tmp_path / "result.json")
    assert report.result["runs"] == 15 and report["errors"] == [
        {"source": "all-noise", "axis": "x", "runs": 15, "rms_mm": 0.18, "predicted_mm": None}]
    assert report.where("errors", axis="y") == [] and report.printed("6.5", "ascfest", "x") == (0, 1.5e-4)
    bars = Findings(report).bars()
    assert bars.beyond == 1 and bars.of == 1 and bars.excess == pytest.approx(0.2) and bars.ends == pytest.approx([0.15]*3)


def test_losses_and_slips(tmp_path):
    (tmp_path / "result.json").write_text('{"command": "report", "allowed_band": [0.646, 1.354], "centre_tolerance": 0.15}')
    (tmp_path / "magnetometer_loss.csv").write_text("case,algorithm,magnetometer,axis,runs,rms_mm,predicted_mm\n" + "".join(
        f"front-2,{algorithm},{field},{axis},0,,{0.1*loss if field == 'model' and axis == 'z' else 0.1}\n"
        for algorithm, loss in (("ascfest", 1.05), ("ascrest", 1.3)) for field in ("measured", "model") for axis in "xyz"))
    (tmp_path / "com_budget.csv").write_text("table,effect,dx_mm,dy_mm,dz_mm\n1.1,a,3,3,3\n1.1,rss,3.00,4,3.2\n"
                                             "1.1,rss of the effects,3.001,3,3\n1.1,requirement,5,5,5\n")
    found = Findings(Report(tmp_path / "result.json"))
    everything, large = found.losses()
    assert len(everything) == 3 and [(row.axis, row.algorithm) for row in large] == [("z", "ascrest")]
    assert [slip.axis for slip in found.budget_slips(1.1, 0.005)] == ["y", "z"]
    assert found.allowed(1.3, 1) and not found.allowed(1.4, 1) and not found.allowed(0.6, 1)
    outside = {"inside": False, "attitude_only": False, "near_centre": True, "excess": 0.4}
    assert found.window_words(outside) == "outside, leaves by 40.0 %; mean within 15 %"
    assert found.window_words({**outside, "near_centre": False, "centre_difference": 0.926}).endswith("mean off by 92.6 %")
    inside = {"inside": True, "attitude_only": True, "on_ticks": False, "excess": 0.02}
    assert found.window_words(inside) == "inside, leaves by 2.0 %; not on the ticks"


def test_report_judgements():
    inside = {"inside": True, "attitude_only": True, "on_ticks": False, "excess": 0.02}
    outside = {"inside": False, "attitude_only": False, "near_centre": True, "excess": 0.4}
    assert Findings.kind_of_window(inside) == Findings.kind_of_window(outside) == "partly"
    assert Findings.first_section("sections 4.1 and 7.1(1)") == "4.1" and Findings.of_the_order(3e-9, 1e-9)


def test_panels(tmp_path):
    points = [plot.Curve(None, 0.5, plot.INK), plot.Curve([1.5, 2.5], [1, 2], plot.BLUE, "D")]
    bars = [plot.Curve([1, 2], [0.1, 5], plot.ORANGE, "bar")]
    figure = plot.panels([plot.Panel("d_x, 10^{-9} m/s^2", points, printed=(-1, 1), ends=(-0.5, 2)), plot.Panel("bars", bars)],
                         [("case 1", plot.BLUE, "D"), ("truth", plot.INK, "")], x=(0, 4), columns=2, marks=[1, 2])
    axes = figure.axes
    assert axes[0].lines[3].get_xydata().tolist() == [[1.5, 1.0], [2.5, 2.0]]          # after two printed ends and the truth
    assert axes[0].get_ylim() == pytest.approx((-1.21, 2.21))
    assert [bar.get_height() for bar in axes[1].patches] == [0.1, 5]
    text = pages.inline_svg(pages.save(figure, tmp_path / "x.svg"), "x", "Title", "What")
    assert '10<tspan dy="-.45em" font-size="75%">-9</tspan>' in text and 'd<tspan dy=".3em" font-size="75%">x</tspan>' in text
    assert pages.drawing("figure_2_1", "frames").startswith('<svg role="img" aria-labelledby="figure_2_1_title')
