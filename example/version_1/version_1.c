/*
 * A program of version 1 of the C interface. It stays as it is: every later version of the library has to compile and
 * run it with these numbers while GRACECG_INTERFACE_VERSION is 1.
 */
#include <gracecg.h>
#include <stdio.h>
#include <stdlib.h>

static void check(gracecg_status status, const gracecg_error *error)
{
    if (status != GRACECG_OK) {
        fprintf(stderr, "version_1: %s (%s)\n", error->message, gracecg_status_text(status));
        exit(EXIT_FAILURE);
    }
}

static void show(const gracecg_object *object, const char *item, size_t n)
{
    gracecg_error error;
    double values[16];
    size_t i;

    check(gracecg_get(object, item, 16, values, NULL, &error), &error);
    printf("%s", item);
    for (i = 0; i < n; ++i)
        printf(" %.12e", values[i]);
    printf("\n");
}

int main(void)
{
    gracecg_error error;
    gracecg_object *gravity = NULL, *the_case = NULL, *model = NULL, *simulator = NULL, *observations = NULL, *fit = NULL,
        *bound = NULL;
    const double position[3] = {4.0e6, -3.0e6, 4.6e6}, seconds = 0.0;
    double a[3], u, state[13], total[3];

    check(gracecg_gravity_open("egm96", 20, 20, &gravity, &error), &error);
    check(gracecg_gravity_evaluate(gravity, 1, position, a, &u, NULL, &error), &error);
    printf("gravity %.12e %.12e %.12e %.12e\n", a[0], a[1], a[2], u);
    check(gracecg_case_open("front-3", &the_case, &error), &error);
    check(gracecg_get(the_case, "state", 13, state, NULL, &error), &error);
    check(gracecg_force_model_open(the_case, &model, &error), &error);
    check(gracecg_force_model_evaluate(model, 1, &seconds, state, state + 3, state + 9, NULL, NULL, NULL, NULL, total,
                                       &error), &error);
    printf("total %.12e %.12e %.12e\n", total[0], total[1], total[2]);
    check(gracecg_case_bound(the_case, &bound, &error), &error);
    show(bound, "sigma", 3);
    check(gracecg_simulator_open(the_case, &simulator, &error), &error);
    check(gracecg_simulate(simulator, 1, 1, &observations, &error), &error);
    check(gracecg_estimate("assest-fde", observations, &fit, &error), &error);
    show(fit, "offset", 3);
    check(gracecg_free(&fit, &error), &error);
    check(gracecg_free(&observations, &error), &error);
    check(gracecg_free(&simulator, &error), &error);
    check(gracecg_free(&bound, &error), &error);
    check(gracecg_free(&model, &error), &error);
    check(gracecg_free(&the_case, &error), &error);
    check(gracecg_free(&gravity, &error), &error);
    return gracecg_interface_version() == GRACECG_INTERFACE_VERSION ? EXIT_SUCCESS : EXIT_FAILURE;
}
