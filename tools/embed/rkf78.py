"""The Runge-Kutta-Fehlberg 7(8) tableau."""
import fortran_table as table


def fraction(text):
    """p/q as a constant expression of kind dp."""
    if "/" in text:
        numerator, denominator = text.split("/")
        return f"{numerator}.0_dp/{denominator}"
    return f"{text}.0_dp"


def generate(data):
    stages = 13
    nodes, weights7, weights8 = ({i: "0" for i in range(stages)} for _ in range(3))
    rows = {i: {} for i in range(stages)}
    for line in table.data_lines(data / "rkf78.txt"):
        key, *fields = line.split()
        if key == "a":
            rows[int(fields[0])][int(fields[1])] = fields[2]
        else:
            {"c": nodes, "b7": weights7, "b8": weights8}[key][int(fields[0])] = fields[1]
    places, columns, values = [], [], []
    for i in range(stages):
        places.append(str(len(values) + 1))
        for j in sorted(rows[i]):
            columns.append(str(j + 1))
            values.append(fraction(rows[i][j]))
    places.append(str(len(values) + 1))
    ordered = lambda d: [fraction(d[i]) for i in range(stages)]
    body = (
        f"    integer, parameter, public :: STAGES = {stages}     !! Evaluations of the right-hand side a step\n"
        + table.parameter_array("NODES", ordered(nodes), comment="c_i")
        + table.parameter_array("WEIGHTS_7", ordered(weights7), comment="b_i of order 7")
        + table.parameter_array("WEIGHTS_8", ordered(weights8), comment="b_i of order 8")
        + "    !> The non-zero a_ij, row by row: stage i uses the entries FIRST(i) to FIRST(i+1) - 1\n"
        + table.parameter_array("FIRST", places, kind="integer")
        + table.parameter_array("STAGE_USED", columns, kind="integer", comment="j, counted from 1")
        + table.parameter_array("COEFFICIENTS", values, comment="a_ij")
    )
    name = "gracecg_base_table_rkf78"
    title = "Coefficients of the Runge-Kutta-Fehlberg method of order 7(8): NASA TR R-287 (1968), Table X."
    return {name: table.module(name, title, "rkf78.txt", body)}
