"""The numbers that CSR-TM-00-01 prints: axis windows of its figures, its tables."""
import fortran_table as table


def text_array(name, values, comment):
    length = max(map(len, values))
    literals = [f"'{v}'" for v in values]
    return table.parameter_array(
        name, [literals[0].replace("'", f"character({length}) :: '", 1)] + literals[1:],
        kind=f"character({length})", comment=comment)


def rows_of(path):
    lines = list(table.data_lines(path))
    header = lines[0].split(",")
    return [dict(zip(header, line.split(","))) for line in lines[1:]]


def generate(data):
    windows = rows_of(data / "report_figure_windows.csv")
    body = (
        text_array("WINDOW_SATELLITE", [w["satellite"] for w in windows], "front or back")
        + text_array("WINDOW_FIGURE", [w["figure"] for w in windows], "Number of the figure")
        + text_array("WINDOW_QUANTITY", [w["quantity"] for w in windows], "Name of the curve")
        + text_array("WINDOW_AXIS", [w["axis"] for w in windows], "Body axis")
        + table.parameter_array("WINDOW_LOW", [table.real(w["low"]) for w in windows], comment="Lower limit, SI")
        + table.parameter_array("WINDOW_HIGH", [table.real(w["high"]) for w in windows], comment="Upper limit, SI")
        + table.parameter_array("WINDOW_STEP", [table.real(w["step"]) for w in windows],
                                comment="Distance of the tick marks, SI")
    )
    name = "gracecg_studies_table_figure_windows"
    title = "Axis windows of CSR-TM-00-01 Figures 5.2-5.8."
    files = {name: table.module(name, title, "report_figure_windows.csv", body)}

    rows = rows_of(data / "report_rms_tables.csv")
    algorithms = ["assest_fde", "assest_rde", "ascfest", "ascrest"]
    values = [table.real(r[a]) for a in algorithms for r in rows]
    body = (
        text_array("RMS_CASE", [f"{r['satellite']}-{r['case']}" for r in rows], "Case of each row")
        + text_array("RMS_ALGORITHM", [a.replace("_", "-") for a in algorithms], "Algorithm of each column")
        + table.parameter_array("RMS_VALUES", values, comment="RMS column after column, mm")
        + f"    !> RMS of the CG offset, mm: rows x algorithms\n    real(dp), parameter, public :: RMS_PUBLISHED"
        f"({len(rows)}, {len(algorithms)}) = reshape(RMS_VALUES, [{len(rows)}, {len(algorithms)}])\n"
    )
    name = "gracecg_studies_table_report_rms"
    title = "Tables 6.1 and 6.2 of CSR-TM-00-01: RMS of the CG offset over 15 runs."
    files[name] = table.module(name, title, "report_rms_tables.csv", body)

    limits = rows_of(data / "report_axis_limits.csv")
    body = (
        text_array("LIMIT_FIGURE", [r["figure"] for r in limits], "Number of the figure")
        + text_array("LIMIT_SATELLITE", [r["satellite"] for r in limits], "front or back")
        + text_array("LIMIT_PANEL", [r["panel"] for r in limits], "Algorithm, or what the panel shows")
        + text_array("LIMIT_AXIS", [r["axis"] for r in limits], "Body axis, or all")
        + table.parameter_array("LIMIT_LOW", [table.real(r["low"]) for r in limits], comment="Lower limit")
        + table.parameter_array("LIMIT_HIGH", [table.real(r["high"]) for r in limits], comment="Upper limit")
        + table.parameter_array("LIMIT_STEP", [table.real(r["step"]) for r in limits],
                                comment="Distance of the tick marks")
    )
    name = "gracecg_studies_table_axis_limits"
    title = "Limits of the axes of CSR-TM-00-01 Figures 6.1-6.6: nT, rad/s^2, m."
    files[name] = table.module(name, title, "report_axis_limits.csv", body)

    rows = rows_of(data / "report_com_budget.csv")
    body = text_array("BUDGET_TABLE", [r["table"] for r in rows], "Number of the table")
    body += text_array("BUDGET_EFFECT", [r["effect"] for r in rows], "Cause of the error, rss or requirement")
    for axis in "xyz":
        body += table.parameter_array(f"BUDGET_{axis.upper()}", [table.real(r[axis]) for r in rows],
                                      comment=f"Error along body {axis}, mm; -1: none is stated")
    name = "gracecg_studies_table_com_budget"
    title = "Tables 1.1 and 1.2 of CSR-TM-00-01: errors of the centre of mass."
    files[name] = table.module(name, title, "report_com_budget.csv", body)
    return files
