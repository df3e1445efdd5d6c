/*
 * The offset while the manoeuvre goes on, from C: an estimate that is fed sample by sample, as they come down, and asked every
 * ten seconds.
 *
 *     cc live.c $(pkg-config --cflags --libs gracecg) -lm -o live
 *
 * The samples are those of `gracecg simulate front-3`. The density wave is known from an earlier calibration: its period is
 * 19.9 s.
 */
#include <gracecg.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define ROOM 5000
#define PI 3.14159265358979323846

/* Ends the program after a failure. The library itself never does. */
static void check(gracecg_status status, const gracecg_error *error)
{
    if (status != GRACECG_OK) {
        fprintf(stderr, "live: %s (%s)\n", error->message, gracecg_status_text(status));
        exit(EXIT_FAILURE);
    }
}

static gracecg_error error;

/* The numbers of an item; how many there are. */
static size_t get(gracecg_object *object, const char *item, double *values)
{
    size_t count;

    check(gracecg_get(object, item, ROOM, values, &count, &error), &error);
    return count;
}

/* The first sample of an interval that ends at `time`, from `*next` on; -1: there is none. */
static int sample_at(const double *times, size_t count, double time, size_t *next)
{
    if (*next >= count || times[*next] > time + 1e-6)
        return -1;
    return (int)(*next)++;
}

int main(void)
{
    static double state[ROOM], rods[ROOM], kinds[ROOM], time[ROOM], acceleration[ROOM], star_time[ROOM], star_head[ROOM],
        quaternion[ROOM], field_time[ROOM], field[ROOM], orbit_time[ROOM], orbit[ROOM];
    gracecg_object *the_case = NULL, *simulator = NULL, *observations = NULL, *setup = NULL, *live = NULL;
    double moment[3][3], position[3], offset[3], sigma[3], interval, t, part;
    size_t samples, stars, fields, positions, rod_count, next_sample = 0, next_star = 0, next_field = 0, j, k, r;
    int s, b, a;
    int32_t head;

    check(gracecg_case_open("front-3", &the_case, &error), &error);
    check(gracecg_simulator_open(the_case, &simulator, &error), &error);
    check(gracecg_simulate(simulator, 1, 1, &observations, &error), &error);
    check(gracecg_setup_from(observations, 0, NULL, NULL, &setup, &error), &error);
    get(the_case, "state", state);                  /* the attitude that was planned */
    rod_count = get(the_case, "rods", rods) / 7;
    get(the_case, "rod_kinds", kinds);
    get(the_case, "interval", &interval);
    samples = get(observations, "accelerometer_time", time);
    get(observations, "acceleration", acceleration);
    stars = get(observations, "star_camera_time", star_time);
    get(observations, "star_camera_head", star_head);
    get(observations, "quaternion", quaternion);
    fields = get(observations, "magnetometer_time", field_time);
    get(observations, "flux_density", field);
    positions = get(observations, "orbit_time", orbit_time);
    get(observations, "orbit_position", orbit);

    check(gracecg_live_begin(setup, state + 9, state + 6, 1 / 19.9, &live, &error), &error);
    for (k = 0; k <= samples; ++k) {
        t = (double)k * interval;
        for (j = 0; j < 3; ++j) {
            moment[j][0] = moment[j][1] = moment[j][2] = 0;
            for (r = 0; r < rod_count; ++r)
                moment[j][(int)kinds[2 * r] - 1] +=
                    rods[7 * r] * sin(2 * PI * rods[7 * r + 1] * (t - (2 - (double)j) * interval / 2) + rods[7 * r + 2]);
        }
        for (j = 0; j + 2 < positions && orbit_time[j + 1] < t; ++j)
            ;
        part = (t - orbit_time[j]) / (orbit_time[j + 1] - orbit_time[j]);
        for (r = 0; r < 3; ++r)
            position[r] = (1 - part) * orbit[3 * j + r] + part * orbit[3 * j + 3 + r];
        a = sample_at(time, samples, t, &next_sample);
        s = sample_at(star_time, stars, t, &next_star);
        b = k == 0 ? 0 : sample_at(field_time, fields, t, &next_field);      /* the first one stands in before it */
        head = s < 0 ? 1 : (int32_t)star_head[s];
        check(gracecg_live_add(live, t, moment[0], a >= 0, a < 0 ? NULL : acceleration + 3 * a, b >= 0,
                               b < 0 ? NULL : field + 3 * b, 1, position, s >= 0, s < 0 ? NULL : star_time + s, &head,
                               s < 0 ? NULL : quaternion + 4 * s, &error), &error);
        if (k % 100 != 0 || k == 0)
            continue;
        get(live, "offset", offset);
        get(live, "sigma", sigma);
        printf("%3.0f s: d", t);
        for (r = 0; r < 3; ++r)
            printf("  %9.5f +- %8.5f", 1e3 * offset[r], 1e3 * sigma[r]);
        printf(" mm\n");
    }
    check(gracecg_free(&live, &error), &error);
    check(gracecg_free(&setup, &error), &error);
    check(gracecg_free(&observations, &error), &error);
    check(gracecg_free(&simulator, &error), &error);
    check(gracecg_free(&the_case, &error), &error);
    return EXIT_SUCCESS;
}
