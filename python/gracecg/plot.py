"""Figures of calibrations, for notebooks and for the pages of `gracecg ... --report`.

Each function takes what a command of `gracecg` wrote with ``--format json`` (its path, or the object read from it), or
what the Python package made (`Solution`, `Fit`), and returns a figure of matplotlib.

>>> import gracecg
>>> fit = gracecg.Case("front-3").simulator().observe(seed=1, run=1).fit("optimal")
>>> gracecg.plot.ellipses(fit.solution)
>>> gracecg.plot.residuals("run1_files/result.json").savefig("residuals.pdf")
"""
from __future__ import annotations

import json
import os
import pathlib
from dataclasses import dataclass
from functools import wraps
from typing import Any, Callable, Mapping, Optional, Sequence, Union

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, MultipleLocator, NullFormatter

Result = Mapping[str, Any]                          #: The JSON of a command
Source = Union[Result, str, "os.PathLike[str]", Any]   #: That, its file, or a `Solution` or `Fit`

#: Told apart by colour-blind eyes too (after Okabe and Ito, and Tol); pages give each a brother on dark ground.
COLOURS = {"blue": "#0072b2", "orange": "#c85200", "green": "#008a64", "purple": "#aa3377", "grey": "#595959",
           "band": "#e6e6e6", "ink": "#1b1f24", "lines": "#bebebe", "paper": "#ffffff"}
BLUE, ORANGE, GREEN, PURPLE, GREY, BAND, INK, LINES, PAPER = COLOURS.values()
OF_AXIS = (BLUE, ORANGE, GREEN)
AXES = "xyz"
ELLIPSE_95 = 2.4477468          # sqrt(-2 ln 0.05): so many times one sigma hold 95 % of a normal distribution
WIDTH = 560                     # Points, of all figures: on a phone of 390 pixels letters of 16 have 11
STYLE: Any = {
    "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans"], "font.size": 16,
    "axes.titlesize": 16, "axes.labelsize": 16, "legend.fontsize": 16, "xtick.labelsize": 16, "ytick.labelsize": 16,
    "text.color": INK, "axes.labelcolor": INK, "xtick.labelcolor": INK, "ytick.labelcolor": INK, "axes.edgecolor": GREY,
    "xtick.color": GREY, "ytick.color": GREY, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "axes.grid.axis": "y", "grid.color": LINES, "grid.linewidth": 0.5, "legend.frameon": False, "legend.handlelength": 1.4,
    "legend.borderpad": 0, "legend.columnspacing": 1.2, "lines.linewidth": 1.5, "axes.axisbelow": True, "savefig.facecolor": PAPER,
    "svg.fonttype": "none", "svg.hashsalt": "gracecg"}


def load(source: Source) -> Result:
    """The JSON of a source, or as much of it as a `Solution` or `Fit` has."""
    if isinstance(source, Mapping):
        return source
    if isinstance(source, (str, os.PathLike)):
        found: Result = json.loads(pathlib.Path(source).read_text(encoding="utf-8"))
        return found
    if hasattr(source, "covariance") and hasattr(source, "offset"):
        return {"offset_m": source.offset, "covariance": {"matrix": source.covariance}}
    if hasattr(source, "series"):
        return _of_fit(source)
    raise TypeError(f"a figure is made of the JSON of a command, its path, a Solution or a Fit, not of {type(source).__name__}")


def _of_fit(fit: Any) -> Result:
    """The members that the figures use, of a `Fit`."""
    series, tests = fit.series(), fit.tests()
    time, residual = series["time"], series["residual"]
    interval = float(np.min(np.diff(time)))
    taper = np.hanning(len(time))
    power = np.abs(np.fft.rfft((residual - residual.mean(axis=0))*taper[:, None], axis=0))**2
    density = np.sqrt(2*interval*power/np.sum(taper**2))
    return {**load(fit.solution),
            "fit": {"residuals": [{"expected_rms_m_s2": rms} for rms in tests.expected_rms]},
            "tables": {"residuals": {"time_s": time, **_columns("{}_m_s2", residual)},
                       "manoeuvre": {"time_s": time, **_columns("wd{}_rad_s2", series["angular_acceleration"])},
                       "spectrum": {"frequency_hz": np.fft.rfftfreq(len(time), interval)[1:],
                                    **_columns("{}_m_s2_sqrt_hz", density[1:])}}}


def _columns(name: str, values: Any) -> dict[str, Any]:
    return {name.format(axis): values[:, k] for k, axis in enumerate(AXES)}


def _table(result: Result, name: str) -> dict[str, Any]:
    """A table of numbers by columns."""
    return {column: np.asarray(values, dtype=float) for column, values in result["tables"][name].items()}


def rows_table(result: Result) -> dict[str, Any]:
    """The rows of a command's table, by columns."""
    rows = result["results"]
    return {column: np.asarray([row[column] for row in rows]) for column in (rows[0] if rows else ())}


def _gps_year(seconds: Any) -> Any:
    """Decimal years of seconds since 2000-01-01 12:00."""
    return 2000 + (np.asarray(seconds) + 43200)/(365.25*86400)


def _utc_year(times: Any) -> Any:
    """Decimal years of ISO dates."""
    dates = np.asarray(times, dtype="datetime64[s]")
    years = dates.astype("datetime64[Y]")
    length = (years + 1).astype("datetime64[s]") - years.astype("datetime64[s]")
    return 1970 + years.astype(int) + (dates - years.astype("datetime64[s]"))/length


def _figure(function: Callable[..., Figure]) -> Callable[..., Figure]:
    """A figure in the style of the pages, of any source."""
    @wraps(function)
    def styled(source: Source) -> Figure:
        with matplotlib.rc_context(STYLE):
            return function(load(source))
    return styled


def _new(height: float, *, rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    layout = ConstrainedLayoutEngine(w_pad=0.04, h_pad=0.06, hspace=0.02, wspace=0.02)
    figure = Figure(figsize=(WIDTH/72, height/72), dpi=72, layout=layout)
    return figure, figure.subplots(rows, columns, **options)


def _legend(figure: Figure, items: Sequence[tuple[str, Mapping[str, Any]]], columns: Optional[int] = None) -> None:
    """A legend above all panels."""
    columns = columns or len(items)
    known = matplotlib.__version_info__ >= (3, 7)       # Debian 12 has an older one, that leaves no room for a legend
    figure.legend(handles=[Line2D([], [], label=label, **look) for label, look in items], ncols=columns,
                  loc="outside upper left" if known else "upper left")
    if not known:
        layout: Any = figure.get_layout_engine()
        layout.set(rect=(0, 0, 1, 1 - 24*-(-len(items)//columns)/figure.bbox.height))


def _three_axes(figure: Figure) -> None:
    _legend(figure, [(axis, {"color": colour}) for axis, colour in zip(AXES, OF_AXIS)])


def _logarithmic(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True, axis="both")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0e}".replace("e-0", "e-")))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_minor_formatter(NullFormatter())


def _offset_and_covariance(result: Result) -> tuple[Any, Any]:
    """mm and mm^2, of a calibration or of Level-1 data."""
    if "offset_mm" in result:
        return np.asarray(result["offset_mm"]), np.asarray(result["covariance_mm2"])
    return 1e3*np.asarray(result["offset_m"]), 1e6*np.asarray(result["covariance"]["matrix"])[:3, :3]


@_figure
def ellipses(result: Result) -> Figure:
    """The error ellipsoid cast on the planes of the body axes, one sigma and 95 %."""
    offset, covariance = _offset_and_covariance(result)
    figure, panels = _new(540, rows=2, columns=2)
    turn = np.linspace(0, 2*np.pi, 181)
    for axes, (i, j) in zip(panels.flat, ((0, 1), (0, 2), (1, 2))):
        block = covariance[np.ix_([i, j], [i, j])]
        values, vectors = np.linalg.eigh(block)
        curve = vectors @ (np.sqrt(np.maximum(values, 0))[:, None]*np.array([np.cos(turn), np.sin(turn)]))
        axes.plot(offset[i] + ELLIPSE_95*curve[0], offset[j] + ELLIPSE_95*curve[1], color=ORANGE)
        axes.plot(offset[i] + curve[0], offset[j] + curve[1], color=BLUE)
        axes.plot(offset[i], offset[j], "o", color=INK, markersize=5)
        axes.grid(True, axis="both")
        axes.xaxis.set_major_locator(MaxNLocator(3))
        axes.yaxis.set_major_locator(MaxNLocator(4))
        axes.ticklabel_format(useOffset=False, style="plain")
        axes.set(xlabel=f"d {AXES[i]}, mm", ylabel=f"d {AXES[j]}, mm")
    panels[1, 1].set_axis_off()
    panels[1, 1].legend(handles=[Line2D([], [], marker="o", linestyle="", color=INK, label="estimate"),
                                 Line2D([], [], color=BLUE, label="one sigma"), Line2D([], [], color=ORANGE, label="95 %")],
                        loc="center")
    return figure


@_figure
def manoeuvre(result: Result) -> Figure:
    """Dipole moment of the rods, or torque of torquers, where it is known, and the angular acceleration of the fit over time."""
    table = _table(result, "manoeuvre")
    driven = next((form for form in ("m{}_a_m2", "t{}_n_m") if form.format("x") in table), None)
    both = driven is not None
    figure, panels = _new(540 if both else 300, rows=1 + both, sharex=True, squeeze=False)
    for k, axis in enumerate(AXES):
        look = {"color": OF_AXIS[k], "linestyle": (0, (4, 4)) if k == 2 else "-"}
        if both:        # the moments of two rods may lie on each other
            panels[0, 0].plot(table["time_s"], table[driven.format(axis)], linewidth=3, **look)
        panels[-1, 0].plot(table["time_s"], 1e6*table[f"wd{axis}_rad_s2"], color=OF_AXIS[k])
    if both:
        panels[0, 0].set_ylabel("moment, A m²" if driven.startswith("m") else "torque, N m")
    panels[-1, 0].set(xlabel="time, s", ylabel="dω/dt, µrad/s²", xlim=(0, table["time_s"][-1]))
    _three_axes(figure)
    return figure


@_figure
def residuals(result: Result) -> Figure:
    """Residuals of the accelerometer over time, with two standard deviations of the setup's noise."""
    table = _table(result, "residuals")
    figure, panels = _new(680, rows=3, sharex=True)
    for k, axis in enumerate(AXES):
        panels[k].plot(table["time_s"], 1e9*table[f"{axis}_m_s2"], color=OF_AXIS[k], linewidth=1)
        expected = result["fit"]["residuals"][k].get("expected_rms_m_s2")
        for side in (-2, 2) if expected else ():
            panels[k].axhline(side*1e9*expected, color=GREY, linestyle="--")
        panels[k].set_ylabel(f"{axis}, nm/s²")
    panels[2].set(xlabel="time, s", xlim=(0, table["time_s"][-1]))
    figure.align_ylabels()
    return figure


@_figure
def spectrum(result: Result) -> Figure:
    """Amplitude spectrum of the residuals, one-sided, beside that of the setup's noise."""
    table = _table(result, "spectrum")
    bands = _table(result, "spectrum_bands") if "spectrum_bands" in result["tables"] else None
    figure, panels = _new(820, rows=3, sharex=True)
    items = [("residuals", {"color": GREY, "linewidth": 0.8})]
    frequency = table["frequency_hz"]
    for k, axis in enumerate(AXES):
        axes = panels[k]
        _logarithmic(axes)
        for rod in {rod["frequency_hz"] for rod in result.get("manoeuvre", {}).get("rods", [])} - {0}:
            axes.axvline(rod, color=GREY, linestyle="--", linewidth=1)
        axes.plot(frequency, table[f"{axis}_m_s2_sqrt_hz"], color=GREY, linewidth=0.8)
        expected = table.get(f"expected_{axis}_m_s2_sqrt_hz", np.zeros(1))
        if expected[0] > 0:
            axes.plot(frequency, expected, color=ORANGE, linewidth=2)
        if bands is not None:
            axes.plot(bands["frequency_hz"], bands[f"{axis}_m_s2_sqrt_hz"], color=BLUE, marker="o", markersize=4)
        axes.set(ylabel=f"{axis}, m/s²/√Hz", xlim=(0.9*frequency[0], 1.05*frequency[-1]))
    if any(table.get(f"expected_{axis}_m_s2_sqrt_hz", [0])[0] > 0 for axis in AXES):
        items.append(("noise of setup", {"color": ORANGE, "linewidth": 2}))
    if bands is not None:
        items.append(("band means", {"color": BLUE, "marker": "o", "markersize": 4}))
    panels[2].set_xlabel("frequency, Hz")
    figure.align_ylabels()
    _legend(figure, items)
    return figure


@_figure
def currents(result: Result) -> Figure:
    """Net currents of the rods, a panel for each of the first spans."""
    table = _table(result, "currents")
    spans = sorted(set(table["span"].astype(int)))
    figure, panels = _new(90 + 125*len(spans), rows=len(spans), sharex=True, squeeze=False)
    for axes, number in zip(panels.flat, spans):
        here = table["span"] == number
        for k, axis in enumerate(AXES):
            axes.plot(table["time_s"][here], table[f"rod_{axis}_ma"][here], color=OF_AXIS[k])
        used = result["spans"][number - 1]["used"]
        axes.set_title(f"span {number}{'' if used else ', not used'}, mA", loc="center")
    panels[-1, 0].set_xlabel("time from the begin of the span, s")
    _three_axes(figure)
    return figure


@_figure
def field(result: Result) -> Figure:
    """Field of the Earth in SRF over the spans."""
    table = _table(result, "field")
    figure, axes = _new(330)
    for k, axis in enumerate(AXES):
        axes.plot(table["time_min"], table[f"{axis}_nt"]/1000, "o", markersize=3, color=OF_AXIS[k])
    axes.set(xlabel="minutes from the begin of the first", ylabel="field in SRF, µT")
    _three_axes(figure)
    return figure


@_figure
def fit(result: Result) -> Figure:
    """Acceleration in one arc: samples, and what the fit leaves of them."""
    table = _table(result, "fit")
    figure, panels = _new(640, rows=3, sharex=True)
    for k, axis in enumerate(AXES):
        for name, look in (("observed", {"color": GREY, "marker": "o", "markersize": 1.5, "linestyle": ""}),
                           ("residual", {"color": ORANGE})):
            panels[k].plot(table["time_s"], 1e9*table[f"{name}_{axis}_m_s2"], **look)
        panels[k].set_ylabel(f"{axis}, nm/s²")
    panels[2].set(xlabel="time from the begin of the span, s", xlim=(0, table["time_s"][-1]))
    figure.align_ylabels()
    _legend(figure, [("samples", {"color": GREY, "marker": "o", "markersize": 4, "linestyle": ""}),
                     ("residuals", {"color": ORANGE})])
    return figure


@_figure
def sources(result: Result) -> Figure:
    """The offset by all instruments, and without some less that by all, with one sigma."""
    rows = result["results"]
    first, places = rows[0], -np.arange(len(rows))
    figure, panels = _new(75 + 3*(26*len(rows) + 75), rows=3)
    for k, axis in enumerate(AXES):
        panels[k].axvline(0, color=GREY, linestyle="--")
        panels[k].errorbar([1e3*(row[f"d{axis}_mm"] - first[f"d{axis}_mm"]) for row in rows], places,
                           xerr=[1e3*row[f"sigma_{axis}_mm"] for row in rows], fmt="o", color=OF_AXIS[k], markersize=5)
        panels[k].set_yticks(places, [row["source"] for row in rows])
        panels[k].set(xlabel=f"d {axis} less that by {first['source']}, µm", ylim=(0.6 - len(rows), 0.6))
        panels[k].grid(True, axis="x")
        panels[k].grid(False, axis="y")
    return figure


@_figure
def trend(result: Result) -> Figure:
    """Offsets of several dates with their lines, and the limit where it is near."""
    points, lines = rows_table(result), _table(result, "trend_lines")
    limit = result["limit_um"]
    figure, panels = _new(640, rows=3, sharex=True)
    for k, axis in enumerate(AXES):
        value, sigma = 1e3*points[f"d{axis}_mm"], 1e3*points[f"sigma_{axis}_mm"]
        panels[k].plot(_gps_year(lines["time_gps_s"]), lines[f"d{axis}_um"], color=BLUE)
        panels[k].errorbar(_gps_year(points["time_gps_s"]), value, yerr=sigma, fmt="o", color=ORANGE, markersize=5)
        for side in (-1, 1):
            if np.max(side*value + sigma) > limit/2:
                panels[k].axhline(side*limit, color=GREY, linestyle="--")
        panels[k].set_ylabel(f"d {axis}, µm")
    _years(panels[2])
    figure.align_ylabels()
    _legend(figure, [("line", {"color": BLUE}), ("result, one sigma", {"color": ORANGE, "marker": "o", "linestyle": ""}),
                     (f"{limit:.0f} µm", {"color": GREY, "linestyle": "--"})])
    return figure


@_figure
def history(result: Result) -> Figure:
    """The offset over time: one sigma about what was known, what all calibrations say, and the calibrations."""
    table = rows_table(result)
    limit, here, year = result["limit_mm"], table["calibration"], _utc_year(table["time_utc"])
    figure, panels = _new(640, rows=3, sharex=True)
    for k, axis in enumerate(AXES):
        mean, sigma = table[f"d{axis}_mm"], table[f"sigma_{axis}_mm"]
        panels[k].fill_between(year, mean - sigma, mean + sigma, color=BAND, linewidth=0)
        panels[k].plot(year, table[f"smoothed_{axis}_mm"], color=BLUE)
        panels[k].errorbar(year[here], mean[here], yerr=sigma[here], fmt="o", color=ORANGE, markersize=5)
        for side in (-1, 1):
            panels[k].axhline(side*limit, color=GREY, linestyle="--")
        panels[k].set_ylabel(f"d {axis}, mm")
    _years(panels[2])
    figure.align_ylabels()
    return figure


def _years(axes: Axes) -> None:
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.ticklabel_format(axis="x", useOffset=False, style="plain")
    axes.set_xlabel("year")


@dataclass
class Curve:
    """A line or points of a panel."""
    x: Any                  #: None: a level, at y
    y: Any
    colour: str             #: Of `COLOURS`; what is grey is dashed
    marker: str = ""        #: Points in the place of a line, as matplotlib has them; a capital: open; "bar": bars from 0
    error: Any = None       #: Standard deviations of y
    on_top: bool = False


@dataclass
class Panel:
    """A panel of a figure of the report."""
    title: str              #: Quantity and unit
    curves: Sequence[Curve]
    printed: Optional[tuple[float, float]] = None       #: Ends of the axis that the report prints
    ends: Optional[tuple[float, float]] = None          #: Least and greatest of what is to be seen; None: as it comes


def panels(shown: Sequence[Panel], legend: Sequence[tuple[str, str, str]], *, x: tuple[float, float], columns: int = 1,
           height: int = 130, x_label: str = "", x_step: float = 0, x_names: Sequence[str] = (), marks: Sequence[float] = (),
           y: Optional[tuple[float, float]] = None, y_step: float = 0, logarithmic: bool = False,
           from_zero: bool = False) -> Figure:
    """A figure of panels with one abscissa, row after row; `legend`: text, colour, marker; `marks`: where the cases are."""
    with matplotlib.rc_context(STYLE):
        rows, legend_rows = -(-len(shown)//columns), -(-sum(len(text) + 6 for text, _, _ in legend)//58)
        figure, grid = _new(rows*(height + (58 if marks else 34)) + 62 + 26*legend_rows, rows=rows, columns=columns, sharex=True,
                            squeeze=False)
        for axes, panel in zip(grid.flat, shown):
            if panel.printed is not None:
                axes.axhspan(*panel.printed, color=BAND, linewidth=0)
                for end in panel.printed:
                    axes.axhline(end, **_look(GREY))
            for curve in panel.curves:
                _curve(axes, curve)
            for number, mark in enumerate(marks, 1):
                axes.axvline(mark, color=GREY, linestyle="--", linewidth=1)
                axes.text(mark, 1.02, f"case {number}", transform=axes.get_xaxis_transform(), va="bottom")
            axes.set_title(panel.title, loc="left", pad=28 if marks else 7)
            _ordinate(axes, panel, y, y_step, logarithmic, from_zero)
            axes.set_xlim(*x)
            if x_step:
                axes.xaxis.set_major_locator(MultipleLocator(x_step))
            if x_names:
                axes.set_xticks(range(1, len(x_names) + 1), x_names)
        for axes in grid.flat[len(shown):]:
            axes.set_axis_off()
        for axes in grid[-1]:
            axes.set_xlabel(x_label)
        _legend(figure, [(text, _look(colour, marker)) for text, colour, marker in legend],
                columns=-(-len(legend)//legend_rows))
        return figure


def _look(colour: str, marker: str = "") -> dict[str, Any]:
    """Of a line, or of points."""
    if marker:
        return {"color": colour, "marker": marker.lower(), "markersize": 6, "linestyle": "",
                "markerfacecolor": "none" if marker.isupper() else colour}
    return {"color": colour, "linestyle": "--" if colour == GREY else "-", "linewidth": 1 if colour == INK else 1.5}


def _ordinate(axes: Axes, panel: Panel, y: Optional[tuple[float, float]], y_step: float, logarithmic: bool,
              from_zero: bool) -> None:
    """Scale, ends and ticks of the ordinate: both what is drawn and the printed axis are to be seen."""
    low, high = y or panel.ends or (0, 0)
    if logarithmic:
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 50*low else (1,), numticks=12))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())
    if y is None and high > low:
        printed = panel.printed or (low, high)
        low, high = min(low, printed[0]), max(high, printed[1])
        margin = 0.07*(high - low)
        low, high = (0 if from_zero else low - margin), high + margin
    if high > low:
        axes.set_ylim(low, high)
    if y_step:
        axes.yaxis.set_major_locator(MultipleLocator(y_step))
    elif not logarithmic:
        axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
        axes.ticklabel_format(axis="y", useOffset=False, style="plain")


def _curve(axes: Axes, curve: Curve) -> None:
    look = _look(curve.colour, curve.marker.replace("bar", ""))
    if curve.x is None:
        axes.axhline(curve.y, **look)
    elif curve.marker == "bar":
        axes.bar(curve.x, curve.y, width=0.5, color=curve.colour)
    elif curve.error is not None:
        axes.errorbar(curve.x, curve.y, yerr=curve.error, fmt="o", color=curve.colour, markersize=4, linewidth=1)
    else:
        axes.plot(curve.x, curve.y, zorder=3 if curve.on_top else None, **look)
