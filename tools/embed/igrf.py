"""The IGRF: src/environment/tables/table_igrf.f90.

Each set of coefficients is a list g(1,0), g(1,1), h(1,1), g(2,0), g(2,1), h(2,1), ... in nT.
"""
from fortran_table import data_lines, module, parameter_array, real

ALL_EPOCHS = "igrf_1900_2030.txt"
ORIGINAL_1995 = "igrf95_original.txt"


def order_of_list(degree):
    for n in range(1, degree + 1):
        for m in range(n + 1):
            yield "g", n, m
            if m > 0:
                yield "h", n, m


def generation_14(path):
    """Epochs, and the columns of the table: the models of the epochs and the secular variation."""
    rows = {}
    for line in data_lines(path):
        kind, n, m, *values = line.split()
        rows[kind, int(n), int(m)] = values
    degree = max(n for _, n, _ in rows)
    keys = list(order_of_list(degree))
    assert sorted(rows) == sorted(keys)
    with open(path, encoding="utf-8") as stream:
        head = next(line for line in stream if line.startswith("# epochs"))
    epochs = [word for word in head.split()[2:] if not word.startswith("sv")]
    columns = list(zip(*(rows[key] for key in keys)))
    assert len(columns) == len(epochs) + 1
    return degree, epochs, columns


def original_1995(path):
    """The model of 1995.0 and its secular variation, as issued in 1995."""
    field, rate = {}, {}
    for line in data_lines(path):
        n, m, g, h, g_rate, h_rate = line.split()
        key = int(n), int(m)
        field["g", *key], field["h", *key] = g, h
        rate["g", *key], rate["h", *key] = g_rate, h_rate
    degree = max(n for _, n, _ in field)
    keys = list(order_of_list(degree))
    return degree, [field[key] for key in keys], [rate[key] for key in keys]


def generate(data):
    degree, epochs, columns = generation_14(data / ALL_EPOCHS)
    degree_95, field_95, rate_95 = original_1995(data / ORIGINAL_1995)

    def table(name, values, comment):
        return parameter_array(name, [real(value) for value in values], comment=comment)

    body = (
        f"    integer, parameter, public :: IGRF14_DEGREE = {degree}  !! Highest degree\n"
        f"    integer, parameter, public :: IGRF95_DEGREE = {degree_95}  !! Highest degree\n\n"
        "    ! Every list of coefficients is in the order g(1,0), g(1,1), h(1,1), g(2,0), g(2,1), h(2,1), ...\n\n"
    )
    body += table("IGRF14_EPOCHS", epochs, "Epochs of the 14th generation, decimal years")
    body += table(
        "IGRF14_FIELDS", [v for column in columns[:-1] for v in column], "The lists of all epochs one after the other, nT"
    )
    body += table("IGRF14_RATE", columns[-1], f"Secular variation after {epochs[-1]}, nT/year")
    body += table("IGRF95_FIELD", field_95, "IGRF 1995.0 as issued in 1995, nT")
    body += table("IGRF95_RATE", rate_95, "Secular variation 1995.0-2000.0 as issued in 1995, nT/year")
    title = "Coefficients of the International Geomagnetic Reference Field, Schmidt semi-normalised."
    source = f"{ALL_EPOCHS} and data/{ORIGINAL_1995}"
    return {"gracecg_environment_table_igrf": module("gracecg_environment_table_igrf", title, source, body)}
