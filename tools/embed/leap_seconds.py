"""TAI-UTC since 1972."""
from fortran_table import data_lines, module, parameter_array

NAME = "gracecg_environment_table_leap_seconds"


def generate(data):
    rows = [line.split() for line in data_lines(data / "leap_seconds.txt")]
    days = [str(int(float(row[1]))) for row in rows]
    offsets = [row[2] for row in rows]
    body = parameter_array("LEAP_SECOND_MJD", days, "integer",
                           "First day (modified Julian day, 0 h UTC) of each value of TAI-UTC")
    body += "\n" + parameter_array("LEAP_SECOND_TAI_MINUS_UTC", offsets, "integer",
                                   "TAI-UTC from that day on, s")
    return {NAME: module(NAME, "TAI-UTC since 1972.", "leap_seconds.txt", body, uses="")}
