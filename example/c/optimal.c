/*
 * An estimate with physical weights, from C: what the estimator "optimal" finds beside the offset, and
 * how near its standard deviations are to the least that any estimate can have.
 *
 *     cc optimal.c $(pkg-config --cflags --libs gracecg) -o optimal
 *
 * The numbers are those of `gracecg simulate front-3`, `gracecg estimate --algorithm optimal` and
 * `gracecg bound front-3`.
 */
#include <gracecg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Ends the program after a failure. The library itself never does. */
static void check(gracecg_status status, const gracecg_error *error)
{
    if (status != GRACECG_OK) {
        fprintf(stderr, "optimal: %s (%s)\n", error->message, gracecg_status_text(status));
        exit(EXIT_FAILURE);
    }
}

int main(void)
{
    gracecg_error error;
    gracecg_object *the_case = NULL, *simulator = NULL, *observations = NULL, *fit = NULL, *bound = NULL;
    double offset[3], sigma[3], least[3], factor, value[16], value_sigma[16];
    char names[400], warnings[2000], *name;
    int i;

    check(gracecg_case_open("front-3", &the_case, &error), &error);
    check(gracecg_simulator_open(the_case, &simulator, &error), &error);
    check(gracecg_simulate(simulator, 1, 1, &observations, &error), &error);

    check(gracecg_estimate("optimal", observations, &fit, &error), &error);
    check(gracecg_get(fit, "offset", 3, offset, NULL, &error), &error);
    check(gracecg_get(fit, "sigma", 3, sigma, NULL, &error), &error);
    check(gracecg_case_bound(the_case, &bound, &error), &error);
    check(gracecg_get(bound, "sigma", 3, least, NULL, &error), &error);
    for (i = 0; i < 3; ++i)
        printf("d_%c = %12.7f mm +- %10.7f mm, at best %10.7f mm\n", "xyz"[i], 1e3 * offset[i], 1e3 * sigma[i],
               1e3 * least[i]);
    check(gracecg_get(fit, "variance_factor", 1, &factor, NULL, &error), &error);
    printf("variance factor %.4f\n", factor);
    check(gracecg_get(fit, "parameter_value", 16, value, NULL, &error), &error);
    check(gracecg_get(fit, "parameter_sigma", 16, value_sigma, NULL, &error), &error);
    check(gracecg_get_text(fit, "parameter_names", names, sizeof names, NULL, &error), &error);
    for (i = 0, name = strtok(names, "\n"); name != NULL; ++i, name = strtok(NULL, "\n"))
        printf("%-13s %12.4e +- %10.2e\n", name, value[i], value_sigma[i]);
    check(gracecg_get_text(fit, "warnings", warnings, sizeof warnings, NULL, &error), &error);
    printf("%s", warnings);

    check(gracecg_free(&bound, &error), &error);
    check(gracecg_free(&fit, &error), &error);
    check(gracecg_free(&observations, &error), &error);
    check(gracecg_free(&simulator, &error), &error);
    check(gracecg_free(&the_case, &error), &error);
    return EXIT_SUCCESS;
}
