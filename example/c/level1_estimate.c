/*
 * The offset from a folder of Level-1 files of GRACE or GRACE-FO, and whether to trust it. Compiles as C99 and as C++.
 *
 *     cc level1_estimate.c $(pkg-config --cflags --libs gracecg_level1) -o level1_estimate
 *     gracecg level1 simulate front-1 --out day
 *     ./level1_estimate day day/setup.nml
 */
#include <gracecg_level1.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Ends the program after a failure. The library itself never does. */
static void check(gracecg_status status, const gracecg_error *error)
{
    if (status != GRACECG_OK) {
        fprintf(stderr, "level1_estimate: %s (%s)\n", error->message, gracecg_status_text(status));
        exit(EXIT_FAILURE);
    }
}

int main(int argc, char **argv)
{
    static const char *const verdicts[3] = {"good", "to be used with care", "not to be used"};
    gracecg_error error;
    gracecg_object *found = NULL;
    double offset[3], covariance[3][3], gain[3], gain_sigma[3], flag, spans, samples;
    char text[4096];
    int k;

    if (argc != 3) {
        fputs("usage: level1_estimate FOLDER SETUP\n", stderr);
        return 2;
    }
    check(gracecg_level1_estimate(argv[1], argv[2], NULL, NULL, 0, NULL, &found, &error), &error);
    check(gracecg_get(found, "offset", 3, offset, NULL, &error), &error);
    check(gracecg_get(found, "covariance", 9, covariance[0], NULL, &error), &error);
    check(gracecg_get(found, "gain", 3, gain, NULL, &error), &error);
    check(gracecg_get(found, "gain_sigma", 3, gain_sigma, NULL, &error), &error);
    check(gracecg_get(found, "flag", 1, &flag, NULL, &error), &error);
    check(gracecg_get(found, "spans", 1, &spans, NULL, &error), &error);
    check(gracecg_get(found, "samples", 1, &samples, NULL, &error), &error);
    check(gracecg_get_text(found, "text", text, sizeof text, NULL, &error), &error);
    check(gracecg_free(&found, &error), &error);
    printf("%s, %.0f spans, %.0f samples\n", verdicts[(int)flag], spans, samples);
    if (text[0] != '\0')
        printf("%s\n", text);
    for (k = 0; k < 3; k++)
        printf("d%c %10.5f +- %.5f mm   rod %10.6f +- %.6f A m^2/mA\n", "xyz"[k], 1e3*offset[k],
               1e3*sqrt(covariance[k][k]), gain[k], gain_sigma[k]);
    return EXIT_SUCCESS;
}
