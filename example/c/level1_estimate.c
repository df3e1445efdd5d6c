/*
 * The offset from a folder of Level-1 files of GRACE or GRACE-FO, by two sources of angular acceleration, and whether
 * to trust it. Compiles as C99 and as C++.
 *
 *     cc level1_estimate.c $(pkg-config --cflags --libs gracecg_level1) -o level1_estimate
 *     gracecg level1 simulate front-1 --out day
 *     ./level1_estimate day day/setup.nml
 */
#include <gracecg_level1.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    static const char *const sources[2] = {"torque+cal", "acc-cal"};
    static const char *const verdicts[3] = {"good", "to be used with care", "not to be used"};
    gracecg_error error;
    gracecg_level1_offset offset;
    gracecg_status status;
    char text[4096];
    int i, k;

    if (argc != 3) {
        fputs("usage: level1_estimate FOLDER SETUP\n", stderr);
        return 2;
    }
    for (i = 0; i < 2; i++) {
        status = gracecg_estimate_level1(argv[1], argv[2], NULL, 0, NULL, sources[i], &offset, text, sizeof text, NULL,
                                         &error);
        if (status != GRACECG_OK) {
            fprintf(stderr, "level1_estimate: %s (%s)\n", error.message, gracecg_status_text(status));
            return EXIT_FAILURE;
        }
        printf("%s: %s, %d spans, %d samples\n", sources[i], verdicts[offset.flag], (int)offset.spans,
               (int)offset.samples);
        if (text[0] != '\0')
            printf("%s\n", text);
        for (k = 0; k < 3; k++)
            printf("d%c %10.5f +- %.5f mm   rod %10.6f +- %.6f A m^2/mA\n", "xyz"[k], 1e3*offset.offset[k],
                   1e3*sqrt(offset.covariance[k][k]), offset.gain[k], offset.gain_sigma[k]);
    }
    return EXIT_SUCCESS;
}
