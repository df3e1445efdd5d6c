"""The numbers that `gracecg report` leaves in a folder, and the figures of them.

>>> from gracecg.report import Report
>>> report = Report("report")
>>> report["windows"][0]["fill"]        # a table, NAME.csv: its rows, the columns as keys
>>> report.figure("figure_6_4")         # a figure of matplotlib, one of FIGURES
"""
from __future__ import annotations

import csv
import json
import math
import os
import pathlib
from typing import Any, Callable, Union

import numpy as np
from matplotlib.figure import Figure

from .plot import AXES, BLUE, GREEN, GREY, INK, OF_AXIS, ORANGE, PURPLE, Curve, Panel, panels

SATELLITES = ("front", "back")
ESTIMATORS = ("assest-fde", "assest-rde", "ascfest", "ascrest")     # Of the report
QUANTITIES = {"srp": "solar radiation", "erp": "Earth radiation", "non_gravitational": "non-gravitational", "a_vel": "a_{vel}",
              "a_gg": "a_{gg}", "a_acc": "a_{acc}", "a_total": "a_{total}", "torque_aero": "aerodynamic torque",
              "torque_solar": "solar torque", "torque_gravity": "gravity torque", "torque_magnetic": "magnetic torque",
              "torque_total": "total torque", "omega": "angular velocity", "omega_dot": "angular acceleration"}
PRINTED_AXIS = ("printed axis", GREY, "")                           # In a legend
GOAL_MM = 0.01                  # RMS error of every component that a designed manoeuvre is to reach
Row = dict[str, Any]


class Report:
    """The folder: `result` is result.json, report[NAME] the table NAME.csv."""

    def __init__(self, source: Union[str, "os.PathLike[str]"]) -> None:
        path = pathlib.Path(source)
        self.folder = path if path.is_dir() else path.parent
        self.result: Row = json.loads((self.folder / "result.json").read_text(encoding="utf-8"))
        self._tables: dict[str, list[Row]] = {}

    def __getitem__(self, name: str) -> list[Row]:
        if name not in self._tables:
            with (self.folder / f"{name}.csv").open(encoding="utf-8", newline="") as file:
                self._tables[name] = [{key: _value(text) for key, text in row.items()} for row in csv.DictReader(file)]
        return self._tables[name]

    def where(self, name: str, **wanted: Any) -> list[Row]:
        """The rows of a table whose columns have these values."""
        return [row for row in self[name] if all(row[column] == value for column, value in wanted.items())]

    def columns(self, name: str) -> dict[str, Any]:
        """The columns of a table of numbers."""
        return {key: np.array([row[key] for row in self[name]]) for key in self[name][0]}

    def printed(self, figure: str, panel: str, axis: str = "all", satellite: str = "front") -> tuple[float, float]:
        """The ends of an axis that the report prints: nT in Figure 6.1, rad/s^2 in 6.4, m in the others."""
        row, = self.where("printed_axes", figure=float(figure), satellite=satellite, panel=panel, axis=axis)
        return row["low"], row["high"]

    def figure(self, name: str) -> Figure:
        """One of FIGURES."""
        return FIGURES[name](self)


def _value(text: str) -> Any:
    """What a field of a table holds."""
    if text in ("", "true", "false"):
        return {"": None, "true": True, "false": False}[text]
    try:
        return float(text)
    except ValueError:
        return text


def exponent_of(window: Row) -> int:
    """The power of ten in whose multiples a printed axis is shown."""
    return math.floor(math.log10(max(abs(window["low"]), abs(window["high"]))*(1 + 1e-12)))


def _gradient(report: Report) -> Figure:
    table = report.columns("gravity_gradient")
    shown = [Panel(f"{title}, 10^{{{exponent}}} m/s^2",
                   [Curve(table["time_s"], table[f"{part}_{direction}_m_s2"]*10.0**-exponent, colour)
                    for direction, colour in zip("rtn", OF_AXIS)])
             for part, title, exponent in (("central", "central term", -9), ("others", "sum of all other terms", -11))]
    return panels(shown, [("radial", BLUE, ""), ("transverse", ORANGE, ""), ("normal", GREEN, "")], height=230,
                  x_label="time, s", x=(0, int(table["time_s"][-1])))


def _windows(figure: float) -> Callable[[Report], Figure]:
    """The printed panels stand side by side, x, y and z below each other; here two quantities do."""
    def drawn(report: Report) -> Figure:
        rows = report.where("windows", figure=figure)
        both = len({row["case"] for row in rows}) > 1
        places = [6*(i//6) + 2*(i % 3) + i//3 % 2 if i < 6*(len(rows)//6) else i for i in range(len(rows))]
        shown = [_window_panel(report, row, both) for _, row in sorted(zip(places, rows), key=lambda pair: pair[0])]
        return panels(shown, [("gracecg", BLUE, ""), PRINTED_AXIS], columns=2, x_label="time, s", x=(0, 60), x_step=20)
    return drawn


def _window_panel(report: Report, row: Row, both: bool) -> Panel:
    exponent, unit, quantity, axis = exponent_of(row), row["unit"], row["quantity"], row["axis"]
    factor = 10.0**-exponent
    title = f"{QUANTITIES.get(quantity, quantity)} {axis}"
    if both:                # a narrow title
        title = f"{row['case'][:-2]} " + (f"ω_{axis}" if quantity == "omega" else f"dω_{axis}/dt")
    table = report.columns(f"verify_{row['case']}")
    column = f"{quantity}_{axis}_{unit.lower().replace(' ', '_').replace('/', '_').replace('^', '')}"
    return Panel(f"{title}, 10^{{{exponent}}} {unit}", [Curve(table["time_s"], factor*table[column], BLUE)],
                 (factor*row["low"], factor*row["high"]), (factor*row["least"], factor*row["greatest"]))


def _revolutions(columns: str, factor: float, title: str, labels: str, y: tuple[float, float],
                 **options: Any) -> Callable[[Report], Figure]:
    """Two panels of three curves, the cases marked."""
    def drawn(report: Report) -> Figure:
        tables = [report.columns(f"timing_{satellite}") for satellite in SATELLITES]
        shown = [Panel(f"{satellite}: {title}", [Curve(table["time_s"], factor*table[columns.format(axis)], colour)
                                                 for axis, colour in zip(AXES, OF_AXIS)])
                 for satellite, table in zip(SATELLITES, tables)]
        return panels(shown, [(labels.format(axis), colour, "") for axis, colour in zip(AXES, OF_AXIS)], height=250,
                      x_label="time, s", x=(0, tables[0]["time_s"][-1]), x_step=1000, marks=_times(report), y=y, **options)
    return drawn


def _times(report: Report) -> list[float]:
    return [row["orbit_time_s"] for row in report["cases"][:3]]


def _field(report: Report) -> Figure:
    low, high = report.printed("6.1", "field")
    return _revolutions("b{}_nt", 1e-4, "field, 10^4 nT", "B_{}", (1e-4*low, 1e-4*high), y_step=2.5)(report)


def _acceleration(report: Report) -> Figure:
    low, high = report.printed("6.4", "acceleration")
    title = "angular acceleration, 10^{-5} rad/s^2"
    return _revolutions("alpha_{}_rad_s2", 1e5, title, "{}", (1e5*low, 1e5*high), y_step=0.5)(report)


def _points(report: Report, table: str, axis: str, colour: str, marker: str, shift: float = 0, **wanted: Any) -> Curve:
    """The estimates of the first runs, as many as the report has."""
    rows = [row for row in report.where(table, **wanted) if row["run"] <= report.result["report_runs"]]
    return Curve([row["run"] + shift for row in rows], [row[f"d{axis}_mm"] for row in rows], colour, marker)


def _estimates_panel(report: Report, figure: str, satellite: str, algorithm: str, axis: str, points: list[Curve]) -> Panel:
    """Points about the truth."""
    true = report.where("cases", case=f"{satellite}-3")[0][f"offset_{axis}_mm"]
    low, high = report.printed(figure, algorithm, axis, satellite)
    values = np.concatenate([curve.y for curve in points])
    return Panel(f"{algorithm}: d_{axis}, mm", [Curve(None, true, INK), *points], (1e3*low, 1e3*high),
                 (float(values.min()), float(values.max())))


def _all_estimates(report: Report, shown: list[Panel], legend: list[tuple[str, str, str]]) -> Figure:
    runs = report.result["report_runs"]
    return panels(shown, [*legend, ("truth", INK, ""), PRINTED_AXIS], columns=2, x_label="run", x=(0, runs + 1), x_step=5)


def _estimates(figure: str, satellite: str) -> Callable[[Report], Figure]:
    """Two algorithms side by side, x, y and z below each other."""
    def drawn(report: Report) -> Figure:
        looks = list(zip((1, 2, 3), OF_AXIS, "*DS"))        # of the cases; markers as in the report
        shown = [_estimates_panel(report, figure, satellite, algorithm, axis,
                                  [_points(report, "montecarlo_runs", axis, colour, marker, case=f"{satellite}-{number}",
                                           algorithm=algorithm) for number, colour, marker in looks])
                 for pair in (ESTIMATORS[:2], ESTIMATORS[2:]) for axis in AXES for algorithm in pair]
        return _all_estimates(report, shown, [(f"case {number}", colour, marker) for number, colour, marker in looks])
    return drawn


def _loss(report: Report) -> Figure:
    """Points with the model's field a little to the right."""
    looks = [("case 2", ORANGE, "measured", "D", 0), ("case 2 LM", ORANGE, "model", "d", 0.3),
             ("case 3", GREEN, "measured", "S", 0), ("case 3 LM", GREEN, "model", "s", 0.3)]
    shown = []
    for axis in AXES:
        for algorithm in ESTIMATORS[2:]:
            points = [_points(report, "magnetometer_loss_runs", axis, colour, marker, shift, case=f"front-{label[5]}",
                              algorithm=algorithm, magnetometer=field) for label, colour, field, marker, shift in looks]
            shown.append(_estimates_panel(report, "6.6", "front", algorithm, axis, points))
    return _all_estimates(report, shown, [(label, colour, marker) for label, colour, _, marker, _ in looks])


def _sources(report: Report) -> Figure:
    """Bars, and theory."""
    shown = []
    for axis in AXES:
        rows, end = report.where("errors", axis=axis), 1e3*report.printed("6.5", "ascfest", axis)[1]
        places = np.arange(1, len(rows) + 1)
        rms, theory = ([row[column] for row in rows] for column in ("rms_mm", "predicted_mm"))
        curves = [Curve(None, end, GREY), Curve(places, rms, BLUE, "bar"), Curve(places, theory, INK, "d", on_top=True)]
        shown.append(Panel(f"RMS error of d_{axis}, mm", curves, ends=(0, max(end, *rms, *theory))))
    legend = [(f"{report.result['runs']} runs", BLUE, "s"), ("theory", INK, "d"), ("end of printed axis", GREY, "")]
    names = ("all noise", "linear NG", "no ACC", "no SCA", "no MAG")
    return panels(shown, legend, height=150, x=(0.4, 5.6), x_names=names, from_zero=True)


def _bound(report: Report) -> Figure:
    """Groups of points: a group a case, a point an estimator."""
    cases = [row["case"] for row in report["cases"]]
    names = list(dict.fromkeys(row["algorithm"] for row in report["bound"]))
    colours = dict(zip(names, (*OF_AXIS, PURPLE, INK, GREY)))
    shown = []
    for axis in AXES:
        curves = []
        for k, name in enumerate(names):
            rows = report.where("bound", algorithm=name, axis=axis)
            places = np.arange(1.0, len(rows) + 1) + 0.135*(k - (len(names) - 1)/2)
            curves.append(Curve(places, [row["ratio"] for row in rows], colours[name], "o", [row["sampling_error"] for row in rows]))
        shown.append(Panel(f"RMS error of d_{axis} / bound", [*curves, Curve(None, 1, GREY)]))
    highest = 1.1*max(2, *(row["ratio"] for row in report["bound"]))
    return panels(shown, [(name, colours[name], "o") for name in names] + [("bound", GREY, "")], height=170,
                  x=(0.45, len(cases) + 0.55), x_names=cases, logarithmic=True, y=(0.5, highest))


def _maps(report: Report) -> Figure:
    """The report's and the designed manoeuvre of either satellite, below each other."""
    shown = []
    for satellite in SATELLITES:
        table = report.columns(f"manoeuvre_map_{satellite}")
        for manoeuvre, title in (("report", "report's"), ("designed", "designed")):
            curves = [Curve(table["time_s"], table[f"{manoeuvre}_{column}_mm"], colour)
                      for column, colour in zip(("worst", *AXES), (INK, *OF_AXIS))]
            shown.append(Panel(f"{satellite}, {title} manoeuvre: limit, mm", [Curve(None, GOAL_MM, GREY), *curves]))
    legend = [(axis, colour, "") for axis, colour in zip(AXES, OF_AXIS)] + [("worst direction", INK, ""), (f"{GOAL_MM:g} mm", GREY, "")]
    return panels(shown, legend, height=170, x_label="time, s", x=(0, table["time_s"][-1]), x_step=1000, marks=_times(report),
                  logarithmic=True, y=(1e-4, 10))


FIGURES: dict[str, Callable[[Report], Figure]] = {
    "figure_3_1": _gradient, **{f"figure_5_{k}": _windows(5 + k/10) for k in range(2, 9)}, "figure_6_1": _field,
    "figure_6_2": _estimates("6.2", "front"), "figure_6_3": _estimates("6.3", "back"), "figure_6_4": _acceleration,
    "figure_6_4_sigma": _revolutions("sigma_{}_mm", 1, "standard deviation, mm", "{}", (1e-4, 10), logarithmic=True),
    "figure_6_5": _sources, "figure_6_6": _loss, "figure_bound": _bound, "figure_manoeuvre_map": _maps}
