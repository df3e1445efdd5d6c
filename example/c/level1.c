/*
 * Reads a Level-1 file of GRACE or GRACE-FO: what it holds, and the mean of each of its fields. Compiles as C99
 * and as C++.
 *
 *     cc level1.c $(pkg-config --cflags --libs gracecg_level1) -o level1
 *     ./level1 MAG1A_2023-06-01_C_04.txt
 *
 * Without an argument it writes a small file of its own first, and reads that.
 */
#include <gracecg_level1.h>
#include <stdio.h>
#include <stdlib.h>

/* Ends the program after a failure. The library itself never does. */
static void check(gracecg_status status, const gracecg_error *error)
{
    if (status != GRACECG_OK) {
        fprintf(stderr, "level1: %s (%s)\n", error->message, gracecg_status_text(status));
        exit(EXIT_FAILURE);
    }
}

/* Two clock corrections. */
static const char *small_file(void)
{
    static const char *const name = "CLK1B_2020-02-01_C_04.txt";
    FILE *file = fopen(name, "w");

    if (file == NULL) {
        perror(name);
        exit(EXIT_FAILURE);
    }
    fputs("header:\n  global_attributes:\n    platform: GRACE C\n# End of YAML header\n"
          "633798000 C -1 -0.016667 1e-11 -1.5e-08 1e-12 00000000\n"
          "633798010 C -1 -0.01666715 1e-11 -1.5e-08 1e-12 00000000\n", file);
    fclose(file);
    return name;
}

int main(int argc, char **argv)
{
    gracecg_error error;
    gracecg_level1 *level1 = NULL;
    size_t records, fields, warnings, i, k, there;
    double *seconds, *values, sum;
    char text[256];

    check(gracecg_level1_read(argc > 1 ? argv[1] : small_file(), NULL, &level1, &error), &error);
    check(gracecg_level1_counts(level1, &records, &fields, &warnings, &error), &error);
    check(gracecg_level1_about(level1, text, sizeof text, NULL, &error), &error);
    printf("%s: %lu records\n", text, (unsigned long)records);
    for (i = 0; i < warnings; i++) {
        check(gracecg_level1_warning(level1, i, text, sizeof text, NULL, &error), &error);
        printf("warning: %s\n", text);
    }
    seconds = (double *)malloc((records + 1) * sizeof *seconds);
    values = (double *)malloc((records + 1) * sizeof *values);
    if (seconds == NULL || values == NULL) {
        fputs("level1: no memory\n", stderr);
        return EXIT_FAILURE;
    }
    check(gracecg_level1_times(level1, records, seconds, NULL, &error), &error);
    if (records > 0)
        printf("from %.0f to %.0f s past 2000-01-01 12:00:00\n", seconds[0], seconds[records - 1]);
    for (k = 0; k < fields; k++) {
        check(gracecg_level1_field(level1, k, text, sizeof text, NULL, &error), &error);
        check(gracecg_level1_values(level1, text, records, values, &error), &error);
        sum = 0.0;
        there = 0;
        for (i = 0; i < records; i++) {
            if (values[i] == values[i]) {       /* NaN: not in that record */
                sum += values[i];
                there++;
            }
        }
        if (there > 0)
            printf("%-16s %24.15e\n", text, sum / (double)there);
    }
    free(values);
    free(seconds);
    check(gracecg_level1_free(&level1, &error), &error);
    return EXIT_SUCCESS;
}
