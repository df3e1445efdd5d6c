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
    gracecg_case *the_case = NULL;
    gracecg_simulator *simulator = NULL;
    gracecg_observations *observations = NULL;
    gracecg_solution solution;
    gracecg_bound bound;
    char warnings[2000];
    int i;

    check(gracecg_case_open("front-3", &the_case, &error), &error);
    check(gracecg_simulator_open(the_case, &simulator, &error), &error);
    check(gracecg_observations_simulate(simulator, 1, 1, &observations, &error), &error);

    check(gracecg_estimate("optimal", observations, &solution, warnings, sizeof warnings, &error), &error);
    check(gracecg_case_bound(the_case, &bound, &error), &error);
    for (i = 0; i < 3; ++i)
        printf("d_%c = %12.7f mm +- %10.7f mm, at best %10.7f mm\n", "xyz"[i], 1e3 * solution.offset[i],
               1e3 * solution.sigma[i], 1e3 * bound.sigma[i]);
    printf("variance factor %.4f\n", solution.variance_factor);
    for (i = 0; i < solution.parameter_count; ++i)
        printf("%-13s %12.4e +- %10.2e\n", solution.parameter_name[i], solution.parameter_value[i],
               solution.parameter_sigma[i]);
    printf("%s", warnings);

    check(gracecg_observations_free(&observations, &error), &error);
    check(gracecg_simulator_free(&simulator, &error), &error);
    check(gracecg_case_free(&the_case, &error), &error);
    return EXIT_SUCCESS;
}
