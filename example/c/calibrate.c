/*
 * A calibration from C: the force model at the epoch, simulated observations, and the estimate from
 * arrays in memory. Compiles as C99 and as C++.
 *
 *     cc calibrate.c $(pkg-config --cflags --libs gracecg) -o calibrate
 *
 * The offset is that of `gracecg simulate front-3` and `gracecg estimate`.
 */
#include <gracecg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Ends the program after a failure. The library itself never does. */
static void check(gracecg_status status, const gracecg_error *error)
{
    if (status != GRACECG_OK) {
        fprintf(stderr, "calibrate: %s (%s)\n", error->message, gracecg_status_text(status));
        exit(EXIT_FAILURE);
    }
}

static double *numbers(size_t n)
{
    double *array = (double *)malloc(n * sizeof *array);
    if (array == NULL) {
        fputs("calibrate: no memory\n", stderr);
        exit(EXIT_FAILURE);
    }
    return array;
}

static void show(const char *what, const double a[3])
{
    printf("%-7s %20.12e %20.12e %20.12e m/s^2, inertial\n", what, a[0], a[1], a[2]);
}

/* The accelerations on the satellite of a case at its epoch. */
static void show_accelerations(const gracecg_case *the_case)
{
    gracecg_error error;
    gracecg_force_model *model = NULL;
    const double seconds = 0.0;
    double state[13], gravity[3], drag[3], total[3];

    check(gracecg_case_values(the_case, NULL, NULL, NULL, state, NULL, &error), &error);
    check(gracecg_force_model_open(the_case, &model, &error), &error);
    check(gracecg_force_model_evaluate(model, 1, &seconds, state, state + 3, state + 9, gravity, drag,
                                       NULL, NULL, total, &error), &error);
    show("gravity", gravity);
    show("drag", drag);
    show("total", total);
    check(gracecg_force_model_free(&model, &error), &error);
}

/* Estimates the offset from arrays of samples, as they may come from anywhere. */
static void estimate(const gracecg_setup *setup, const gracecg_samples *samples)
{
    gracecg_error error;
    gracecg_observations *observations = NULL;
    gracecg_solution solution;
    char warnings[2000];
    int axis;

    check(gracecg_observations_create(setup, samples, &observations, &error), &error);
    check(gracecg_estimate("assest-fde", observations, &solution, warnings, sizeof warnings, &error),
          &error);
    for (axis = 0; axis < 3; ++axis)
        printf("d_%c = %12.7f mm +- %10.7f mm\n", "xyz"[axis], 1e3 * solution.offset[axis],
               1e3 * solution.sigma[axis]);
    printf("%s", warnings);
    check(gracecg_observations_free(&observations, &error), &error);
}

int main(void)
{
    gracecg_error error;
    gracecg_case *the_case = NULL;
    gracecg_simulator *simulator = NULL;
    gracecg_observations *simulated = NULL;
    gracecg_setup *setup = NULL;
    size_t counts[4];

    printf("gracecg %s, case front-3\n", gracecg_version());
    check(gracecg_case_open("front-3", &the_case, &error), &error);
    show_accelerations(the_case);

    /* Observations: here simulated, with seed 1 and run 1, and copied into arrays */
    check(gracecg_simulator_open(the_case, &simulator, &error), &error);
    check(gracecg_observations_simulate(simulator, 1, 1, &simulated, &error), &error);
    check(gracecg_observations_setup(simulated, &setup, &error), &error);
    check(gracecg_observations_counts(simulated, counts, &error), &error);
    {
        const size_t n = counts[0], p = counts[1], r = counts[2];
        double *t_acc = numbers(n), *acceleration = numbers(3 * n);
        double *t_star = numbers(p), *quaternion = numbers(4 * p);
        int32_t *head = (int32_t *)numbers(p);
        double *t_mag = numbers(r), *field = numbers(3 * r);
        gracecg_samples samples;

        check(gracecg_observations_accelerometer(simulated, n, t_acc, acceleration, &error), &error);
        check(gracecg_observations_star_camera(simulated, p, t_star, head, quaternion, &error), &error);
        check(gracecg_observations_magnetometer(simulated, r, t_mag, field, &error), &error);

        memset(&samples, 0, sizeof samples);    /* what is not set is not there: the orbit */
        samples.accelerometer_count = n;
        samples.accelerometer_time = t_acc;
        samples.acceleration = acceleration;
        samples.star_camera_count = p;
        samples.star_camera_time = t_star;
        samples.star_camera_head = head;
        samples.quaternion = quaternion;
        samples.magnetometer_count = r;
        samples.magnetometer_time = t_mag;
        samples.flux_density = field;
        estimate(setup, &samples);

        free(t_acc);
        free(acceleration);
        free(t_star);
        free(head);
        free(quaternion);
        free(t_mag);
        free(field);
    }
    check(gracecg_setup_free(&setup, &error), &error);
    check(gracecg_observations_free(&simulated, &error), &error);
    check(gracecg_simulator_free(&simulator, &error), &error);
    check(gracecg_case_free(&the_case, &error), &error);

    /* What is wrong is said, and the program goes on */
    if (gracecg_case_open("front-9", &the_case, &error) != GRACECG_OK)
        printf("front-9: %s\n", error.message);
    return EXIT_SUCCESS;
}
