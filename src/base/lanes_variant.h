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
    VECTOR state[states > 0 ? states : 1][count], innovation[count];      /* white noise has no state, C no array of none */

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

/* du/dt = w - omega x u, dw/dt = A u + B w + f; A and B by columns, f lies `lanes` numbers apart */
TARGET INLINE void VARIANT(slope)(const double *omega, const double *a, const double *b, const double *f, int lanes,
                                  const VECTOR *u, const VECTOR *w, VECTOR *u_rate, VECTOR *w_rate)
{
    u_rate[0] = w[0] - (omega[1]*u[2] - omega[2]*u[1]);
    u_rate[1] = w[1] - (omega[2]*u[0] - omega[0]*u[2]);
    u_rate[2] = w[2] - (omega[0]*u[1] - omega[1]*u[0]);
    for (int i = 0; i < 3; i++)
        w_rate[i] = (a[i]*u[0] + a[3 + i]*u[1] + a[6 + i]*u[2]) + (b[i]*w[0] + b[3 + i]*w[1] + b[6 + i]*w[2]) +
                    READ(&f[i*lanes]);
}

TARGET static void VARIANT(carry)(int lanes, int steps, double interval, const double *omega, const double *a, const double *b,
                                  const double *f, double *columns)
{
    for (int l = 0; l < lanes; l += WIDTH) {
        VECTOR u[3], w[3];

        for (int i = 0; i < 3; i++) {
            u[i] = READ(&columns[l + i*lanes]);
            w[i] = READ(&columns[l + (3 + i)*lanes]);
        }
        for (int k = 0; k <= steps; k++) {
            VECTOR u_rate[4][3], w_rate[4][3], u_stage[3], w_stage[3];
            double *kept = &columns[l + 9*k*lanes];

            VARIANT(slope)(&omega[6*k], &a[18*k], &b[18*k], &f[l + 6*k*lanes], lanes, u, w, u_rate[0], w_rate[0]);
            for (int i = 0; i < 3; i++) {
                AT(&kept[i*lanes]) = u[i];
                AT(&kept[(3 + i)*lanes]) = w[i];
                AT(&kept[(6 + i)*lanes]) = w_rate[0][i];
            }
            if (k == steps) break;
            for (int s = 1; s < 4; s++) {
                const int half = 2*k + (s + 1)/2;
                const double step = s == 3 ? interval : interval/2;
                for (int i = 0; i < 3; i++) {
                    u_stage[i] = u[i] + step*u_rate[s - 1][i];
                    w_stage[i] = w[i] + step*w_rate[s - 1][i];
                }
                VARIANT(slope)(&omega[3*half], &a[9*half], &b[9*half], &f[l + 3*half*lanes], lanes, u_stage, w_stage,
                               u_rate[s], w_rate[s]);
            }
            for (int i = 0; i < 3; i++) {
                u[i] += interval/6*((u_rate[0][i] + u_rate[3][i]) + 2*(u_rate[1][i] + u_rate[2][i]));
                w[i] += interval/6*((w_rate[0][i] + w_rate[3][i]) + 2*(w_rate[1][i] + w_rate[2][i]));
            }
        }
    }
}

/* `count` combinations at once: a column is loaded once for their products. Columns from `first` on are added to what
   there is. */
TARGET INLINE void VARIANT(combine_few)(const int count, int lanes, int stride, int first, int last, int m,
                                        const double *columns, const double *weights, double *combined)
{
    int l = 0;

    for (; l + WIDTH <= lanes; l += WIDTH) {
        VECTOR sum[count];
        for (int i = 0; i < count; i++) {
            if (first == 0) sum[i] = READ(&columns[l])*weights[i];
            else sum[i] = READ(&combined[l + i*lanes]);
        }
        for (int j = first == 0 ? 1 : first; j < last; j++) {
            const VECTOR column = READ(&columns[l + (long)j*stride]);
            for (int i = 0; i < count; i++) sum[i] += column*weights[j*m + i];
        }
        for (int i = 0; i < count; i++) AT(&combined[l + i*lanes]) = sum[i];
    }
    for (; l < lanes; l++)
        for (int i = 0; i < count; i++) {
            double sum = first == 0 ? columns[l]*weights[i] : combined[l + i*lanes];
            for (int j = first == 0 ? 1 : first; j < last; j++) sum += columns[l + (long)j*stride]*weights[j*m + i];
            combined[l + i*lanes] = sum;
        }
}

/* BLOCK columns at a time: they stay in the first cache for all combinations */
TARGET static void VARIANT(combine)(int lanes, int stride, int n, int m, const double *columns, const double *weights,
                                    double *combined)
{
    for (int first = 0; first < n; first += BLOCK) {
        const int last = first + BLOCK < n ? first + BLOCK : n;
        int i = 0;
        for (; i + 4 <= m; i += 4)
            VARIANT(combine_few)(4, lanes, stride, first, last, m, columns, weights + i, combined + i*lanes);
        if (m - i == 3) VARIANT(combine_few)(3, lanes, stride, first, last, m, columns, weights + i, combined + i*lanes);
        if (m - i == 2) VARIANT(combine_few)(2, lanes, stride, first, last, m, columns, weights + i, combined + i*lanes);
        if (m - i == 1) VARIANT(combine_few)(1, lanes, stride, first, last, m, columns, weights + i, combined + i*lanes);
    }
}

/* The vector of `column` takes some elements before it along, which are and stay 0, and its own, which are set at the end. */
TARGET static void VARIANT(reflect)(int lanes, int column, int n, double *row, double *others)
{
    double element[MOST_ROWS], length = row[column]*row[column];

    for (int i = 0; i < n; i++) {
        element[i] = others[i*lanes + column];
        length += element[i]*element[i];
    }
    length = sqrt(length);
    if (!(length > fabs(row[column]))) return;
    if (row[column] > 0) length = -length;
    const double leading = row[column] - length;        /* first element of the reflecting vector */
    const double scale = -1/(length*leading);           /* 2 over the square of its length */
    for (int l = column - column%WIDTH; l < lanes; l += WIDTH) {
        VECTOR sum = leading*READ(&row[l]);
        for (int i = 0; i < n; i++) sum += element[i]*READ(&others[i*lanes + l]);
        sum *= scale;
        AT(&row[l]) -= leading*sum;
        for (int i = 0; i < n; i++) AT(&others[i*lanes + l]) -= element[i]*sum;
    }
    row[column] = length;
    for (int i = 0; i < n; i++) others[i*lanes + column] = 0;
}
