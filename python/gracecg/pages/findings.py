"""What the page of `gracecg report` finds in its numbers: counts, extremes, and whether they agree with what is printed."""
from __future__ import annotations

import math
import re
import statistics
from types import SimpleNamespace
from typing import Any, Iterable

from ..plot import AXES
from ..report import ESTIMATORS, GOAL_MM, QUANTITIES, Report, Row, exponent_of

Counts = SimpleNamespace
USUAL_ALLOWED = 70          # Published values that a right theory leaves inside, the median; and so many or more in 96 of
LEAST_ALLOWED = 66          # 100 reports drawn with their correlations (tools/wave_likelihood.py)
SMALL_LOSS = 0.1            # Relative, of an error


def fixed(value: Any, decimals: int = 4) -> str:
    """A number with so many decimals; with an exponent from a million on; a dash for none."""
    if value is None:
        return "-"
    text = f"{value:.3E}" if abs(value) >= 1e6 else f"{value:.{decimals}f}"
    return text[1:] if re.fullmatch(r"-[0.]+", text) else text


def percent(part: float) -> str:
    """A part of 1 in percent."""
    return f"{fixed(100*part, 1)} %"


def whole_percent(part: float) -> str:
    """The same without decimals."""
    return f"{fixed(100*part, 0)} %"


def _magnitude(row: Row, columns: Iterable[str]) -> float:
    return max(abs(float(row[column])) for column in columns)


class Findings:
    """Of one report."""
    estimators, quantities, goal_mm = ESTIMATORS, QUANTITIES, GOAL_MM
    usual_allowed, least_allowed, small_loss = USUAL_ALLOWED, LEAST_ALLOWED, SMALL_LOSS
    exponent_of = staticmethod(exponent_of)

    def __init__(self, report: Report) -> None:
        self.report = report

    def largest_gradients(self) -> tuple[float, float]:
        """The largest component by the central term, and that by all others, m/s^2."""
        return self._largest_gradient("central"), self._largest_gradient("others")

    def _largest_gradient(self, part: str) -> float:
        columns = [f"{part}_{axis}_m_s2" for axis in "rtn"]
        return max(_magnitude(row, columns) for row in self.report["gravity_gradient"])

    @staticmethod
    def of_the_order(value: float, order: float) -> bool:
        """Within a factor of the square root of ten."""
        return abs(math.log10(value/order)) <= 0.5

    def count_windows(self) -> Counts:
        """The curves of Figures 5.2 to 5.8 that meet their printed axes."""
        attitude, surface = (self.report.where("windows", attitude_only=only) for only in (True, False))
        return Counts(attitude=len(attitude), surface=len(surface), attitude_fill=min(row["fill"] for row in attitude),
                      **{f"attitude_{name}": sum(row[name] for row in attitude) for name in ("inside", "on_ticks")},
                      surface_inside=sum(row["inside"] for row in surface), surface_near=sum(row["near_centre"] for row in surface))

    @staticmethod
    def kind_of_window(row: Row) -> str:
        """How a curve meets its printed axis."""
        well = row["on_ticks"] if row["attitude_only"] else row["near_centre"]
        if row["inside"] and well:
            return "met"
        return "partly" if row["inside"] or well and not row["attitude_only"] else "missed"

    def window_words(self, row: Row) -> str:
        """The same in words."""
        text = ("inside" if row["inside"] else "outside") + (f", leaves by {percent(row['excess'])}" if row["excess"] > 0 else "")
        if row["attitude_only"]:
            return text + ("; not on the ticks" if row["inside"] and not row["on_ticks"] else "")
        return text + (f"; mean within {whole_percent(self.report.result['centre_tolerance'])}" if row["near_centre"]
                       else f"; mean off by {percent(row['centre_difference'])}")

    def count_points(self, figure: float) -> Counts:
        """The estimates of a figure within its printed axes."""
        rows = self.report.where("estimate_windows", figure=figure)
        points, inside, on_ticks = (int(sum(row[column] for row in rows)) for column in ("points", "inside", "on_ticks"))
        return Counts(panels=len(rows), points=points, inside=inside, on_ticks=on_ticks, fill=min(row["fill"] for row in rows))

    def allowed(self, published: float, theory: float) -> bool:
        """Whether 15 runs allow a published RMS when theory is right."""
        low, high = self.report.result["allowed_band"]
        return low*theory < published < high*theory

    def scatter_of_the_report(self) -> float:
        """One sigma of the RMS of the report's runs, relative."""
        return 1/math.sqrt(2*self.report.result["report_runs"])

    def accuracy_rows(self, satellite: str) -> tuple[list[Counts], bool]:
        """Table 6.1 or 6.2 by case and axis, and whether the algorithms agree in all digits shown."""
        tables = {"here": ("montecarlo", "rms_mm"), "first": ("montecarlo_first_runs", "rms_mm"),
                  "theory": ("montecarlo", "predicted_mm"), "published": ("montecarlo", "published_mm")}
        rows = [Counts(case=f"{satellite}-{number}", axis=axis, **{
            name: {row["algorithm"]: row[column] for row in self.report.where(table, case=f"{satellite}-{number}", axis=axis)}
            for name, (table, column) in tables.items()}) for number in (1, 2, 3) for axis in AXES]
        return rows, all(len({fixed(value, 5) for value in getattr(row, name).values()}) == 1
                         for row in rows for name in ("here", "first", "theory"))

    def least_without(self, source: str) -> int:
        """In how many axes theory gives the least error without one source."""
        least = [min(self.report.where("errors", axis=axis), key=lambda row: row["predicted_mm"]) for axis in AXES]
        return sum(row["source"] == source for row in least)

    def errors_without(self, source: str) -> str:
        """The errors by theory without one source, as parts of those with everything on: x, y and z in words."""
        parts = [self.report.where("errors", axis=axis, source=source)[0]["predicted_mm"]
                 / self.report.where("errors", axis=axis, source="all-noise")[0]["predicted_mm"] for axis in AXES]
        return "{}, {} and {}".format(*(whole_percent(part) for part in parts))

    def bars(self) -> Counts:
        """The bars of Figure 6.5 and their printed axes: how many top them, by how much at most (relative), the ends in mm."""
        ends = {axis: 1e3*self.report.printed("6.5", "ascfest", axis)[1] for axis in AXES}
        excess = [float(row["rms_mm"])/ends[row["axis"]] - 1 for row in self.report["errors"]]
        return Counts(of=len(excess), beyond=sum(value > 0 for value in excess), excess=max(0.0, *excess), ends=list(ends.values()))

    def losses(self) -> tuple[list[Counts], list[Counts]]:
        """What the components lose without magnetometer by theory, relative, the algorithm that loses most: all, and those that
        lose more than SMALL_LOSS."""
        rows = self.report["magnetometer_loss"]
        pairs = [(rows[i + k], rows[i + 3 + k]) for i in range(0, len(rows), 6) for k in range(3)]     # Measured, modelled
        most: dict[tuple[str, str], Counts] = {}
        for measured, model in pairs:
            change = Counts(**model, change=model["predicted_mm"]/measured["predicted_mm"] - 1)
            place = change.case, change.axis
            if place not in most or change.change > most[place].change:
                most[place] = change
        return list(most.values()), [row for row in most.values() if row.change > SMALL_LOSS]

    def budget_slips(self, table: float, tolerance: float) -> list[Counts]:
        """The axes of Table 1.1 or 1.2 whose printed RSS is not that of the printed effects, to a tolerance in mm."""
        printed, rss = self.report.where("com_budget", table=table)[-3:-1]
        return [Counts(axis=axis, printed=printed[f"d{axis}_mm"], rss=rss[f"d{axis}_mm"]) for axis in AXES
                if abs(printed[f"d{axis}_mm"] - rss[f"d{axis}_mm"]) > tolerance]

    @staticmethod
    def first_section(place: str) -> str:
        """4.1 of 'sections 4.1 and 7.1(1)'."""
        return re.search(r"\d\S*", place)[0]        # type: ignore[index]

    def bound_rows(self) -> tuple[list[Counts], bool, list[str]]:
        """The bound and every estimator by case and axis, whether the report's agree in all digits, and the heads."""
        names = list(dict.fromkeys(row["algorithm"] for row in self.report["bound"]))
        rows = []
        for case in dict.fromkeys(row["case"] for row in self.report["bound"]):
            for axis in AXES:
                of = self.report.where("bound", case=case, axis=axis)
                rows.append(Counts(case=case, axis=axis, bound=of[0]["bound_mm"],
                                   rms=[f"{fixed(row['rms_mm'], 5)} ({fixed(row['ratio'], 2)})" for row in of]))
        agree = all(len(set(row.rms[:len(ESTIMATORS)])) == 1 for row in rows)
        if agree:
            names[:len(ESTIMATORS)] = ["the report's"]
            for row in rows:
                del row.rms[1:len(ESTIMATORS)]
        return rows, agree, names

    def bound_counts(self) -> dict[str, Counts]:
        """By estimator: how many errors are at the bound, and their ratios to it."""
        counts = {}
        for name in dict.fromkeys(row["algorithm"] for row in self.report["bound"]):
            rows = self.report.where("bound", algorithm=name)
            ratios = [row["ratio"] for row in rows]
            counts[name] = Counts(reached=sum(row["at_the_bound"] for row in rows), of=len(rows), least=min(ratios),
                                  greatest=max(ratios), median=statistics.median(ratios),
                                  missing=sum(row["not_converged"] for row in rows if row["axis"] == "x"))
        return counts

    def worst_axis(self, satellite: str) -> tuple[float, float]:
        """The limit of the worst axis, mm: where it is least with the report's manoeuvre, and greatest with the designed one."""
        rows = self.report[f"manoeuvre_map_{satellite}"]
        return (min(_magnitude(row, (f"report_{axis}_mm" for axis in AXES)) for row in rows),
                max(_magnitude(row, (f"designed_{axis}_mm" for axis in AXES)) for row in rows))

    def goals(self) -> tuple[Counts, Counts]:
        """The cases in which the designed manoeuvre reaches the goal in every axis, at once and after one trim; the worst axis, mm."""
        found = []
        for column in ("rms_mm", "rms_after_trim_mm"):
            worst = [max(row[column] for row in self.report.where("design", case=case["case"]))
                     for case in self.report["cases"]]
            found.append(Counts(met=sum(value <= GOAL_MM for value in worst), worst=max(worst)))
        return found[0], found[1]
