"""Coefficients of the DTM-77 thermosphere model."""
from fortran_table import data_lines, module, parameter_array, real

NAME = "gracecg_environment_table_dtm77"
COLUMNS = (
    ("DTM77_TEMPERATURE", "A(1..36) of the exospheric temperature; A(1) in K"),
    ("DTM77_HELIUM", "A(1..36) of helium; A(1) in 1/cm^3 at 120 km"),
    ("DTM77_OXYGEN", "A(1..36) of atomic oxygen; A(1) in 1/cm^3 at 120 km"),
    ("DTM77_NITROGEN", "A(1..36) of molecular nitrogen; A(1) in 1/cm^3 at 120 km"),
)


def generate(data):
    rows = [line.split() for line in data_lines(data / "dtm77.txt")]
    if [int(row[0]) for row in rows] != list(range(1, 37)):
        raise ValueError("dtm77.txt: the coefficients must be numbered 1 to 36")
    body = "\n".join(
        parameter_array(name, [real(row[column]) for row in rows], comment=comment)
        for column, (name, comment) in enumerate(COLUMNS, start=1))
    return {NAME: module(NAME, "Coefficients of the DTM-77 thermosphere model, as printed.",
                                  "dtm77.txt", body)}
