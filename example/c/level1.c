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
#include <string.h>

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

/* A text of a file: its fields or warnings, a line each. */
static char *text_of(const gracecg_object *level1, const char *name)
{
    gracecg_error error;
    size_t length;
    char *text;

    check(gracecg_get_text(level1, name, NULL, 0, &length, &error), &error);
    text = (char *)malloc(length + 1);
    if (text == NULL) {
        fputs("level1: no memory\n", stderr);
        exit(EXIT_FAILURE);
    }
    check(gracecg_get_text(level1, name, text, length + 1, NULL, &error), &error);
    return text;
}

int main(int argc, char **argv)
{
    gracecg_error error;
    gracecg_object *level1 = NULL;
    size_t records, i, there;
    double *values, sum;
    char *text, *field;

    check(gracecg_level1_open(argc > 1 ? argv[1] : small_file(), NULL, &level1, &error), &error);
    check(gracecg_get(level1, "time_seconds", 0, NULL, &records, &error), &error);
    text = text_of(level1, "about");
    printf("%s: %lu records\n", text, (unsigned long)records);
    free(text);
    text = text_of(level1, "warnings");
    printf("%s", text);
    free(text);
    values = (double *)malloc((records + 1) * sizeof *values);
    if (values == NULL) {
        fputs("level1: no memory\n", stderr);
        return EXIT_FAILURE;
    }
    check(gracecg_get(level1, "time_seconds", records, values, NULL, &error), &error);
    if (records > 0)
        printf("from %.0f to %.0f s past 2000-01-01 12:00:00\n", values[0], values[records - 1]);
    text = text_of(level1, "fields");
    for (field = strtok(text, "\n"); field != NULL; field = strtok(NULL, "\n")) {
        check(gracecg_get(level1, field, records, values, NULL, &error), &error);
        sum = 0.0;
        there = 0;
        for (i = 0; i < records; i++) {
            if (values[i] == values[i]) {       /* NaN: not in that record */
                sum += values[i];
                there++;
            }
        }
        if (there > 0)
            printf("%-16s %24.15e\n", field, sum / (double)there);
    }
    free(text);
    free(values);
    check(gracecg_free(&level1, &error), &error);
    return EXIT_SUCCESS;
}
