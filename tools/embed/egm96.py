"""EGM96 to degree and order 70: src/environment/tables/table_egm96.f90."""
from fortran_table import data_lines, module, parameter_array, real

SOURCE = "egm96_deg70.gfc"


def generate(data):
    head, rows = {}, []
    for line in data_lines(data / SOURCE):
        words = line.split()
        if words[0] == "gfc":
            rows.append((int(words[1]), int(words[2]), real(words[3]), real(words[4])))
        elif len(words) == 2:
            head[words[0]] = words[1]
    degree = int(head["max_degree"])
    rows.sort()
    assert [row[:2] for row in rows] == [(n, m) for n in range(degree + 1) for m in range(n + 1)]

    body = (
        f"    integer, parameter, public :: EGM96_DEGREE = {degree}   !! Highest degree and order\n"
        f"    real(dp), parameter, public :: EGM96_GM = {real(head['earth_gravity_constant'])}    !! m^3/s^2\n"
        f"    real(dp), parameter, public :: EGM96_RADIUS = {real(head['radius'])}     !! m\n\n"
    )
    for name, column, function in (("EGM96_C", 2, "cos"), ("EGM96_S", 3, "sin")):
        comment = f"Fully normalised coefficients of {function}(m longitude): m = 0..n for each n = 0..{degree}"
        body += parameter_array(name, [row[column] for row in rows], comment=comment)
    title = f"The geopotential EGM96 (Lemoine et al. 1998) to degree and order {degree}, tide-free."
    return {"gracecg_environment_table_egm96": module("gracecg_environment_table_egm96", title, SOURCE, body)}
