"""Horizontal wind at the report's epoch."""
from fortran_table import data_lines, module, parameter_array, real

NAME = "gracecg_environment_table_wind"
SOURCE = "wind_hwm93_1989-01-02.txt"


def generate(data):
    rows = [line.split() for line in data_lines(data / SOURCE)]
    latitudes = sorted({float(row[0]) for row in rows})
    hours = sorted({float(row[1]) for row in rows})
    places = [(float(row[0]), float(row[1])) for row in rows]
    if places != [(latitude, hour) for latitude in latitudes for hour in hours]:
        raise ValueError(SOURCE + ": rows must go by latitude, then by local time, none left out")
    if latitudes != [5.0 * i - 90 for i in range(37)] or hours != list(range(24)):
        raise ValueError(SOURCE + ": the grid must be -90 to 90 by 5 deg and 0 to 23 by 1 h")
    body = f"    integer, parameter, public :: WIND_LATITUDES = {len(latitudes)}\n"
    body += "    !! From -90 to 90 deg, equally spaced\n"
    body += f"    integer, parameter, public :: WIND_LOCAL_TIMES = {len(hours)}\n"
    body += "    !! From 0 h on, equally spaced; the fastest index of the arrays\n"
    for name, column in (("NORTH", 2), ("EAST", 3)):
        body += "\n" + parameter_array(f"WIND_{name}", [real(row[column]) for row in rows],
                                       comment=f"{name.capitalize()}ward wind, m/s")
    return {NAME: module(NAME, "Horizontal wind of HWM93 at the report's epoch, 466 km.",
                                  SOURCE, body)}
