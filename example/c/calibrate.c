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
static void show_accelerations(const gracecg_object *the_case)
{
    gracecg_error error;
    gracecg_object *model = NULL;
    const double seconds = 0.0;
    double state[13], gravity[3], drag[3], total[3];

    check(gracecg_get(the_case, "state", 13, state, NULL, &error), &error);
    check(gracecg_force_model_open(the_case, &model, &error), &error);
    check(gracecg_force_model_evaluate(model, 1, &seconds, state, state + 3, state + 9, gravity, drag,
                                       NULL, NULL, total, &error), &error);
    show("gravity", gravity);
    show("drag", drag);
    show("total", total);
    check(gracecg_free(&model, &error), &error);
}

/* The numbers of an item of an object, in memory of their own. */
static double *item(const gracecg_object *object, const char *name, size_t *count)
{
    gracecg_error error;
    double *array;

    check(gracecg_get(object, name, 0, NULL, count, &error), &error);
    array = numbers(*count + 1);
    check(gracecg_get(object, name, *count, array, NULL, &error), &error);
    return array;
}

/* Estimates the offset and shows it. */
static void estimate(const gracecg_object *observations)
{
    gracecg_error error;
    gracecg_object *fit = NULL;
    double offset[3], sigma[3];
    char action[1000], warnings[2000];
    int axis;

    check(gracecg_estimate("assest-fde", observations, &fit, &error), &error);
    check(gracecg_get(fit, "offset", 3, offset, NULL, &error), &error);
    check(gracecg_get(fit, "sigma", 3, sigma, NULL, &error), &error);
    check(gracecg_get_text(fit, "action", action, sizeof action, NULL, &error), &error);
    check(gracecg_get_text(fit, "warnings", warnings, sizeof warnings, NULL, &error), &error);
    /* What to do comes first: numbers are there also when they are not to be used */
    printf("%s\n", action);
    for (axis = 0; axis < 3; ++axis)
        printf("d_%c = %12.7f mm +- %10.7f mm\n", "xyz"[axis], 1e3 * offset[axis], 1e3 * sigma[axis]);
    printf("%s", warnings);
    check(gracecg_free(&fit, &error), &error);
}

int main(void)
{
    gracecg_error error;
    gracecg_object *the_case = NULL;
    gracecg_object *simulator = NULL, *simulated = NULL, *setup = NULL, *observations = NULL;
    double *t_acc, *acceleration, *t_star, *head, *quaternion, *t_mag, *field, *t_orbit, *position;
    int32_t *heads;
    size_t n, p, r, s, count, i;

    printf("gracecg %s, case front-3\n", gracecg_version());
    check(gracecg_case_open("front-3", &the_case, &error), &error);
    show_accelerations(the_case);

    /* Observations: here simulated, with seed 1 and run 1, and copied into arrays, as they may come from anywhere */
    check(gracecg_simulator_open(the_case, &simulator, &error), &error);
    check(gracecg_simulate(simulator, 1, 1, &simulated, &error), &error);
    check(gracecg_setup_from(simulated, 0, NULL, NULL, &setup, &error), &error);
    t_acc = item(simulated, "accelerometer_time", &n);
    acceleration = item(simulated, "acceleration", &count);
    t_star = item(simulated, "star_camera_time", &p);
    head = item(simulated, "star_camera_head", &count);
    quaternion = item(simulated, "quaternion", &count);
    t_mag = item(simulated, "magnetometer_time", &r);
    field = item(simulated, "flux_density", &count);
    t_orbit = item(simulated, "orbit_time", &s);
    position = item(simulated, "orbit_position", &count);
    heads = (int32_t *)numbers(p);
    for (i = 0; i < p; ++i)
        heads[i] = (int32_t)head[i];

    /* With the orbit the magnetometer is compared with the field model: without it nothing tests its scale */
    check(gracecg_observations_create(setup, n, t_acc, acceleration, p, t_star, heads, quaternion, r, t_mag, field,
                                      s, t_orbit, position, &observations, &error), &error);
    estimate(observations);

    free(t_acc);
    free(acceleration);
    free(t_star);
    free(head);
    free(heads);
    free(quaternion);
    free(t_mag);
    free(field);
    free(t_orbit);
    free(position);
    check(gracecg_free(&observations, &error), &error);
    check(gracecg_free(&setup, &error), &error);
    check(gracecg_free(&simulated, &error), &error);
    check(gracecg_free(&simulator, &error), &error);
    check(gracecg_free(&the_case, &error), &error);

    /* What is wrong is said, and the program goes on */
    if (gracecg_case_open("front-9", &the_case, &error) != GRACECG_OK)
        printf("front-9: %s\n", error.message);
    return EXIT_SUCCESS;
}
