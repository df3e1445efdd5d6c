"""Solar flux and geomagnetic activity of 1989 (the report's epoch) and of 2000."""
import datetime

from fortran_table import data_lines, module, parameter_array, real

NAME = "gracecg_environment_table_space_weather"
MJD_ZERO = datetime.date(1858, 11, 17)


def generate(data):
    rows = [line.split() for year in (1989, 2000)
            for line in data_lines(data / f"space_weather_{year}.txt")]
    days = [str((datetime.date.fromisoformat(row[0]) - MJD_ZERO).days) for row in rows]
    body = parameter_array("SPACE_WEATHER_MJD", days, "integer", "Modified Julian day of each row")
    body += "\n" + parameter_array("SPACE_WEATHER_F107", [real(row[1]) for row in rows],
                                   comment="F10.7 as observed, sfu")
    body += "\n" + parameter_array("SPACE_WEATHER_F107_MEAN", [real(row[3]) for row in rows],
                                   comment="Centred 81-day mean of F10.7 as observed, sfu")
    body += "\n" + parameter_array("SPACE_WEATHER_KP_TENTHS", [k for row in rows for k in row[6:14]],
                                   "integer", "Ten times Kp, eight three-hourly values a day")
    return {NAME: module(NAME, "Solar flux and geomagnetic activity, daily.",
                                  "space_weather_1989.txt and _2000.txt", body)}
