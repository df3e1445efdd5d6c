"""The terms of the nutation series IAU 2000B."""
from fortran_table import data_lines, module, parameter_array

NAME = "gracecg_environment_table_nutation"
MULTIPLES, AMPLITUDES = 5, 6


def generate(data):
    rows = [line.split() for line in data_lines(data / "nutation_iau2000b.txt")]
    multiples = [text for row in rows for text in row[:MULTIPLES]]
    amplitudes = [f"{text}.0_dp" for row in rows for text in row[MULTIPLES:]]
    body = f"    !> Number of terms\n    integer, parameter, public :: NUTATION_TERMS = {len(rows)}\n"
    body += "\n" + parameter_array("NUTATION_MULTIPLES", multiples, "integer",
                                   "Multiples of l, l', F, D and Om, five a term")
    body += "\n" + parameter_array("NUTATION_AMPLITUDES", amplitudes, comment="Longitude: sine, its change a century, cosine; "
                                   "obliquity: cosine, its change, sine; 0.1 microarcsecond")
    return {NAME: module(NAME, "Nutation IAU 2000B: the luni-solar terms.", "nutation_iau2000b.txt", body)}
