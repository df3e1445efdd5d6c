"""The built-in star catalogue: the stars of data/bright_stars.txt with passA = 1, in the file's order."""
import fortran_table

NAME = "gracecg_environment_table_bright_stars"


def generate(data):
    stars = [line.split() for line in fortran_table.data_lines(data / "bright_stars.txt")]
    stars = [fields for fields in stars if fields[10] == "1"]

    def column(name, index, comment):
        literals = [fortran_table.real(fields[index]) for fields in stars]
        return fortran_table.parameter_array(name, literals, comment=comment)

    body = "\n".join(
        [
            column("RIGHT_ASCENSION", 2, "Right ascension, J2000 equator and equinox, epoch J2000.0, deg"),
            column("DECLINATION", 3, "Declination, J2000 equator and equinox, epoch J2000.0, deg"),
            column("VISUAL_MAGNITUDE", 6, "Johnson V, mag"),
        ]
    )
    title = "Bright stars 1.0 <= V <= 6.0 without a bright companion within 0.1 deg."
    return {NAME: fortran_table.module(NAME, title, "bright_stars.txt", body)}
