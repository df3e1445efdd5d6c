/*
 * The library in two threads at once: each propagates the orbit and attitude of a case, evaluates its
 * force model along the arc, and estimates offsets, with models that both share. The numbers must be
 * those of one thread after the other, to the last bit, and so must the messages of wrong calls.
 *
 *     cc threads.c $(pkg-config --cflags --libs gracecg) -pthread -o threads
 */
#include <gracecg.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEPS 600           /* of 0.1 s: the calibration */
#define RUNS 3              /* estimates a thread */
#define MISTAKES 5000       /* wrong calls a thread, with a message each */
#define TURNS 4             /* how often it is tried */

/* Models that all threads use. */
static gracecg_object *the_case, *model, *simulator;

/* One thread's work and its results. */
typedef struct work {
    int32_t seed;
    double state[STEPS + 1][13];            /* m, m/s, rad/s, quaternion */
    double acceleration[STEPS + 1][3];      /* m/s^2, inertial */
    double offset[RUNS][3];                 /* m */
    char message[GRACECG_MESSAGE_SIZE];     /* of a wrong call */
    int other_messages;                     /* how often the same wrong call got another one */
    gracecg_error error;                    /* status GRACECG_OK when all went well */
} work;

static gracecg_status estimate(const work *mine, int32_t run, double offset[3], gracecg_error *error)
{
    gracecg_object *observations = NULL, *fit = NULL;
    gracecg_status status = gracecg_simulate(simulator, mine->seed, run, &observations, error);

    if (status == GRACECG_OK)
        status = gracecg_estimate("assest-fde", observations, &fit, error);
    if (status == GRACECG_OK)
        status = gracecg_get(fit, "offset", 3, offset, NULL, error);
    gracecg_free(&fit, NULL);
    gracecg_free(&observations, NULL);
    return status;
}

/* Asks for a degree that does not exist, again and again: the message is always the same. */
static void make_mistakes(work *mine)
{
    gracecg_object *gravity = NULL;
    gracecg_error error;
    int k;

    mine->other_messages = 0;
    for (k = 0; k < MISTAKES; ++k) {
        gracecg_gravity_open("egm96", mine->seed == 1 ? 99 : 1234567, 0, &gravity, &error);
        if (k == 0)
            strcpy(mine->message, error.message);
        else
            mine->other_messages += strcmp(mine->message, error.message) != 0;
    }
}

static void *run(void *argument)
{
    work *mine = (work *)argument;
    gracecg_status status;
    double initial[13];
    int32_t k;

    status = gracecg_get(the_case, "state", 13, initial, NULL, &mine->error);
    initial[6] += 1e-5 * mine->seed;    /* rad/s: each thread has an arc of its own */
    if (status == GRACECG_OK)
        status = gracecg_force_model_propagate(model, initial, 0, 0.1, STEPS, 0.0, mine->state[0],
                                               &mine->error);
    for (k = 0; status == GRACECG_OK && k <= STEPS; ++k) {
        const double seconds = 0.1 * k, *state = mine->state[k];
        status = gracecg_force_model_evaluate(model, 1, &seconds, state, state + 3, state + 9, NULL, NULL,
                                              NULL, NULL, mine->acceleration[k], &mine->error);
    }
    for (k = 0; status == GRACECG_OK && k < RUNS; ++k)
        status = estimate(mine, k + 1, mine->offset[k], &mine->error);
    make_mistakes(mine);
    return NULL;
}

static void must(int well, const char *what)
{
    if (!well) {
        fprintf(stderr, "threads: %s\n", what);
        exit(EXIT_FAILURE);
    }
}

static int alike(const work *a, const work *b)
{
    return memcmp(a->state, b->state, sizeof a->state) == 0 &&
           memcmp(a->acceleration, b->acceleration, sizeof a->acceleration) == 0 &&
           memcmp(a->offset, b->offset, sizeof a->offset) == 0 && strcmp(a->message, b->message) == 0 &&
           a->other_messages == b->other_messages;
}

int main(void)
{
    static work alone[2], together[2];
    gracecg_error error;
    int turn, i;

    must(gracecg_case_open("front-3", &the_case, &error) == GRACECG_OK, error.message);
    must(gracecg_force_model_open(the_case, &model, &error) == GRACECG_OK, error.message);
    must(gracecg_simulator_open(the_case, &simulator, &error) == GRACECG_OK, error.message);

    for (i = 0; i < 2; ++i) {
        alone[i].seed = together[i].seed = i + 1;
        run(&alone[i]);
        must(alone[i].error.status == GRACECG_OK, alone[i].error.message);
        must(alone[i].other_messages == 0, "the message of a wrong call changes");
    }
    must(!alike(&alone[0], &alone[1]), "the two threads' work should differ");

    for (turn = 0; turn < TURNS; ++turn) {
        pthread_t thread[2];
        for (i = 0; i < 2; ++i)
            must(pthread_create(&thread[i], NULL, run, &together[i]) == 0, "no thread");
        for (i = 0; i < 2; ++i)
            must(pthread_join(thread[i], NULL) == 0, "a thread was lost");
        for (i = 0; i < 2; ++i) {
            must(together[i].error.status == GRACECG_OK, together[i].error.message);
            must(alike(&alone[i], &together[i]), "two threads at once give other results than one");
        }
    }
    printf("two threads at once, %d times: the numbers of one\n", TURNS);
    for (i = 0; i < 2; ++i)
        printf("seed %d: d = %.7f %.7f %.7f mm\n", i + 1, 1e3 * alone[i].offset[0][0],
               1e3 * alone[i].offset[0][1], 1e3 * alone[i].offset[0][2]);

    gracecg_free(&simulator, NULL);
    gracecg_free(&model, NULL);
    gracecg_free(&the_case, NULL);
    return EXIT_SUCCESS;
}
