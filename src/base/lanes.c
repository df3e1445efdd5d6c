/* Inner loops of gracecg_base_lanes, which says what they do. The loops themselves stand in lanes_variant.h, which is
   compiled for each width of vectors: series, or parameters, lie side by side. */
#include "vectors.h"
#include <math.h>

/* As in the Fortran module */
enum { LANES = 8, MOST_LANES = 24, POLES = 10, BLOCK = 64, MOST_ROWS = 16, LEFT_OUT = 0, PREDICTED = 1 };

/* A filter: the arrays of gracecg_base_lanes, each row of a transition `states` numbers long */
struct filter {
    const int32_t *coupled;
    const double *output, *gain, *inverse_deviation, *below, *on, *above;
};

#define KERNEL "lanes_variant.h"
#include "every_width.h"

INTERNAL void gracecg_lanes_whiten(int32_t widest, int32_t lanes, int32_t samples, int32_t carried, const int32_t *role,
                                   const double *gain, const double *inverse_deviation, const double *decay, double *state,
                                   double *series)
{
    const struct filter filter = { .gain = gain, .inverse_deviation = inverse_deviation, .on = decay };

    CALL(whiten, &filter, lanes, samples, carried, role, state, series);
}

INTERNAL void gracecg_lanes_filter(int32_t widest, int32_t states, int32_t lanes, int32_t samples, int32_t carried,
                                   const int32_t *role, const int32_t *coupled, const double *output, const double *gain,
                                   const double *inverse_deviation, const double *below, const double *on, const double *above,
                                   double *state, double *series)
{
    const struct filter filter = { coupled, output, gain, inverse_deviation, below, on, above };

    CALL(filter, &filter, states, lanes, samples, carried, role, state, series);
}

INTERNAL void gracecg_lanes_add_products(int32_t widest, int32_t n, int32_t stride, int32_t m, const double *rows,
                                         const double *observed, double *normal, double *rhs)
{
    CALL(add_products, n, stride, m, rows, observed, normal, rhs);
}

INTERNAL void gracecg_lanes_carry(int32_t widest, int32_t lanes, int32_t steps, double interval, const double *omega,
                                  const double *a, const double *b, const double *f, double *columns)
{
    CALL(carry, lanes, steps, interval, omega, a, b, f, columns);
}

INTERNAL void gracecg_lanes_combine(int32_t widest, int32_t lanes, int32_t stride, int32_t n, int32_t m, const double *columns,
                                    const double *weights, double *combined)
{
    CALL(combine, lanes, stride, n, m, columns, weights, combined);
}

INTERNAL void gracecg_lanes_reflect(int32_t widest, int32_t lanes, int32_t column, int32_t n, double *row, double *others)
{
    CALL(reflect, lanes, column - 1, n, row, others);
}
