"""Coefficients of the thermosphere models DTM-77, DTM-78 as CNES has it, and DTM-94."""
from fortran_table import data_lines, module, parameter_array, real

MEANINGS = {
    "TEMPERATURE": "of the exospheric temperature; the first in K",
    "HYDROGEN": "of hydrogen; the first in 1/cm^3 at 120 km",
    "HELIUM": "of helium; the first in 1/cm^3 at 120 km",
    "OXYGEN": "of atomic oxygen; the first in 1/cm^3 at 120 km",
    "NITROGEN": "of molecular nitrogen; the first in 1/cm^3 at 120 km",
}
# file, edition, coefficients, columns, what the module holds
TABLES = (
    ("dtm77.txt", "DTM77", 36, ("TEMPERATURE", "HELIUM", "OXYGEN", "NITROGEN"), "the DTM-77 thermosphere model, as printed"),
    ("dtm78_cnes.txt", "DTM78", 36, ("TEMPERATURE", "HELIUM", "OXYGEN", "NITROGEN", "HYDROGEN"),
     "the DTM-78 thermosphere model, as CNES has it"),
    ("dtm94.txt", "DTM94", 39, ("TEMPERATURE", "HYDROGEN", "HELIUM", "OXYGEN", "NITROGEN"),
     "the DTM-94 thermosphere model, as printed"),
)


def generate(data):
    modules = {}
    for file, edition, count, columns, what in TABLES:
        rows = [line.split() for line in data_lines(data / file)]
        if [int(row[0]) for row in rows] != list(range(1, count + 1)):
            raise ValueError(f"{file}: the coefficients must be numbered 1 to {count}")
        body = "\n".join(
            parameter_array(f"{edition}_{column}", [real(row[i]) for row in rows],
                            comment=f"A(1..{count}) {MEANINGS[column]}")
            for i, column in enumerate(columns, start=1))
        name = f"gracecg_environment_table_{edition.lower()}"
        modules[name] = module(name, f"Coefficients of {what}.", file, body)
    return modules
