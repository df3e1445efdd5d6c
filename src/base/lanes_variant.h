/* The loops of lanes.c for vectors of WIDTH numbers (every_width.h). */

/* A Kalman filter of `lanes` series side by side: innovations by their deviations in place of the samples. `count`
   vectors hold a number of each; poles: every state with its own transition, and 1 as output.

   What the machine does. The innovation is a chain of as many differences as there are states, 4 cycles each on Zen 4.
   Three vectors of 8 numbers give it three chains beside each other. */
TARGET INLINE void VARIANT(filter_lanes)(const struct filter *filter, const int poles, const int states, const int count,
                                         int samples, int carried, const int32_t *role, double *state_of_lanes, double *series)
{
    const VECTOR zero = {0};
    const int lanes = count*WIDTH;
    VECTOR state[states][count], innovation[count];

    for (int j = 0; j < states; j++)
        for (int v = 0; v < count; v++) state[j][v] = READ(&state_of_lanes[j*lanes + v*WIDTH]);
    for (int i = 0; i < samples; i++, series += lanes) {
        const double *gain = &filter->gain[i*states], *on = &filter->on[i*states];
        for (int v = 0; v < count; v++) innovation[v] = READ(&series[v*WIDTH]);
        for (int j = 0; j < states; j++)
            for (int v = 0; v < count; v++)
                if (poles) innovation[v] -= state[j][v];
                else innovation[v] -= filter->output[j]*state[j][v];
        if (role[i] == LEFT_OUT) for (int v = 0; v < count; v++) innovation[v] = zero;
        for (int v = 0; v < count; v++) AT(&series[v*WIDTH]) = innovation[v]*filter->inverse_deviation[i];
        if (role[i] == PREDICTED) for (int v = 0; v < count; v++) innovation[v] = zero;
        if (i >= carried) break;
        if (poles) {
            for (int j = 0; j < states; j++)
                for (int v = 0; v < count; v++) state[j][v] = on[j]*(state[j][v] + gain[j]*innovation[v]);
            continue;
        }
        const double *below = &filter->below[i*states], *above = &filter->above[i*states];
        VECTOR before[count];
        for (int j = 0; j < states; j++)
            for (int v = 0; v < count; v++) {
                const VECTOR now = state[j][v] + gain[j]*innovation[v];
                VECTOR next = on[j]*now;
                if (filter->coupled[j] && below[j] != 0) next += below[j]*before[v];
                if (filter->coupled[j] && above[j] != 0) next += above[j]*(state[j + 1][v] + gain[j + 1]*innovation[v]);
                before[v] = now;
                state[j][v] = next;
            }
    }
    for (int j = 0; j < states; j++)
        for (int v = 0; v < count; v++) AT(&state_of_lanes[j*lanes + v*WIDTH]) = state[j][v];
}

TARGET INLINE void VARIANT(filter_by)(const struct filter *filter, const int poles, const int states, int lanes, int samples,
                                      int carried, const int32_t *role, double *state, double *series)
{
    if (lanes == LANES)
        VARIANT(filter_lanes)(filter, poles, states, LANES/WIDTH, samples, carried, role, state, series);
    else if (lanes == 2*LANES)
        VARIANT(filter_lanes)(filter, poles, states, 2*LANES/WIDTH, samples, carried, role, state, series);
    else
        VARIANT(filter_lanes)(filter, poles, states, MOST_LANES/WIDTH, samples, carried, role, state, series);
}

TARGET static void VARIANT(whiten)(const struct filter *filter, int lanes, int samples, int carried, const int32_t *role,
                                   double *state, double *series)
{
    VARIANT(filter_by)(filter, 1, POLES, lanes, samples, carried, role, state, series);
}

TARGET static void VARIANT(filter)(const struct filter *filter, int states, int lanes, int samples, int carried,
                                   const int32_t *role, double *state, double *series)
{
    VARIANT(filter_by)(filter, 0, states, lanes, samples, carried, role, state, series);
}

/* The products of four observations are added to an element between its load and its store: 10 instructions a vector.
   A column is added to up to the vector of its diagonal. */
TARGET static void VARIANT(add_products)(int n, int stride, int m, const double *rows, const double *observed, double *normal,
                                         double *rhs)
{
    for (int k = 0; k < m; k += 4) {
        const double *a = &rows[k*stride], *b = a + stride, *c = b + stride, *d = c + stride;
        for (int i = 0; i < n; i++) {
            double *column = &normal[i*stride];
            for (int j = 0; j <= i; j += WIDTH)
                AT(&column[j]) = (((AT(&column[j]) + READ(&a[j])*a[i]) + READ(&b[j])*b[i]) + READ(&c[j])*c[i]) +
                                 READ(&d[j])*d[i];
        }
        for (int j = 0; j < n; j += WIDTH)
            AT(&rhs[j]) = (((AT(&rhs[j]) + READ(&a[j])*observed[k]) + READ(&b[j])*observed[k + 1]) +
                           READ(&c[j])*observed[k + 2]) + READ(&d[j])*observed[k + 3];
    }
}
