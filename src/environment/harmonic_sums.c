/* Sums over degree and order of solid spherical harmonics: the inner loops of the module
   gracecg_environment_spherical_harmonics, which says what is summed and has the interfaces. The loops themselves
   stand in harmonic_sums_variant.h, which is compiled for each width of vectors: orders, or places, lie side by side. */
#include "../base/vectors.h"

/* As in the Fortran module */
enum { LANES = 8, COLUMNS = 7, PLACES = 8, MOST_BLOCKS = 46 };

/* The sums: Phi and its derivatives at fixed q^2; N_, NN_: with n, n^2 before each term. */
enum { PHI, N_PHI, DX, DY, DZ, FIRST_DERIVATIVES,
       NN_PHI = FIRST_DERIVATIVES, N_DX, N_DY, N_DZ, DXX, DXY, DXZ, DYZ, DZZ, SECOND_DERIVATIVES };

/* The columns of a step: beta; coefficients of cos and sin for Phi, its derivative and its second derivative by q_z */
enum { BETA, F, DF = 3, DDF = 5 };

typedef const double (*steps_t)[COLUMNS][LANES];

struct function {
    int32_t blocks, orders;
    const int32_t *first;
    steps_t steps;
};

/* re[2 + m] + i im[2 + m] = (x + i y)^m for 0 <= m < LANES*blocks and m <= LANES, 0 before them. Behind the first LANES + 1
   they are vectors: each is read as it was written, from m = 1 on, for the processor need not wait until it is in memory then. */
INLINE void powers_of(double x, double y, int blocks, double *re, double *im)
{
    re[0] = re[1] = im[0] = im[1] = 0;
    re += 2;
    im += 2;
    re[0] = 1;
    im[0] = 0;
    re[1] = x;
    im[1] = y;
    for (int m = 2; m <= LANES; m++) {
        int i = m/2, k = m - m/2;
        re[m] = re[i]*re[k] - im[i]*im[k];
        im[m] = re[i]*im[k] + im[i]*re[k];
    }
    const double step_re = re[LANES], step_im = im[LANES];
    for (int block = 1; block < blocks; block++)
        for (int m = LANES*block + 1; m <= LANES*(block + 1); m++) {
            re[m] = re[m - LANES]*step_re - im[m - LANES]*step_im;
            im[m] = re[m - LANES]*step_im + im[m - LANES]*step_re;
        }
}

#define KERNEL "../environment/harmonic_sums_variant.h"
#include "../base/every_width.h"

/* Sums PHI to DZ at the place q; vectors of at most `widest` numbers */
INTERNAL void gracecg_harmonic_sums_first(int32_t widest, int32_t blocks, int32_t orders, const int32_t *first, steps_t steps,
                                          const double *q, double *sums)
{
    CALL(sum_first, blocks, orders, first, steps, q, sums);
}

/* Sums PHI to DZ of two functions at the place q, the other with no more degrees and orders than the first */
INTERNAL void gracecg_harmonic_sums_two(int32_t widest, int32_t blocks, int32_t orders, const int32_t *first, steps_t steps,
                                        int32_t other_blocks, int32_t other_orders, const int32_t *other_first,
                                        steps_t other_steps, const double *q, double (*sums)[FIRST_DERIVATIVES])
{
    const struct function one = { blocks, orders, first, steps };
    const struct function other = { other_blocks, other_orders, other_first, other_steps };

    CALL(sum_two, &one, &other, q, sums);
}

/* All sums at the place q */
INTERNAL void gracecg_harmonic_sums_second(int32_t widest, int32_t blocks, int32_t orders, const int32_t *first, steps_t steps,
                                           const double *q, double *sums)
{
    CALL(sum_second, blocks, orders, first, steps, q, sums);
}

/* Sums PHI to DZ at PLACES places */
INTERNAL void gracecg_harmonic_sums_places(int32_t widest, int32_t orders, const int32_t *first, steps_t steps,
                                           const double (*q)[PLACES], double (*sums)[PLACES])
{
    CALL(sum_places, orders, first, steps, q, sums);
}
