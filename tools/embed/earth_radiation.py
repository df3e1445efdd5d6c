"""data/earth_radiation.txt -> src/environment/tables/table_earth_radiation.f90"""
from fortran_table import data_lines, module, parameter_array, real

ALBEDO = ("a0", "c0", "c1", "c2", "a2")
EMISSIVITY = ("e0", "k0", "k1", "k2", "e2")
ORDER = "degree 0; degree 1 constant, cosine and sine of the year; degree 2"


def generate(data):
    report, knocke, irradiance = {}, {}, None
    for line in data_lines(data / "earth_radiation.txt"):
        name, first, second = line.split()[:3]
        if name == "sun_orekit":
            irradiance = first
        elif not name.startswith("sun_"):
            report[name], knocke[name] = first, second

    body = ""
    for title, column in (("report", report), ("Knocke", knocke)):
        for quantity, names in (("albedo", ALBEDO), ("emissivity", EMISSIVITY)):
            body += parameter_array(
                f"{title}_{quantity}".upper(),
                [real(column[name]) for name in names],
                comment=f"{quantity.capitalize()}, column {title}: {ORDER}",
            )
    for name, text, comment in (
        ("PERIOD_DAYS", report["period"], "Period of the seasonal terms, days"),
        ("EPOCH_JD", report["t0_jd"], "Epoch t0 of the seasonal terms, Julian date"),
        ("SOLAR_IRRADIANCE_1AU", irradiance, "Solar irradiance at 1 au, W/m^2: 4.5606e-6 N/m^2 times c"),
    ):
        body += f"    real(dp), parameter, public :: {name} = {real(text)}\n    !! {comment}\n"
    name = "gracecg_environment_table_earth_radiation"
    title = "Knocke's second-degree zonal albedo and emissivity of the Earth."
    return {name: module(name, title, "earth_radiation.txt", body)}
