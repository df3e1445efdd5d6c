/* Elementary functions of many numbers at once, and the random numbers of gracecg_base_random made with them. The loops
   stand in elementary_variant.h, which is compiled for each width of vectors (every_width.h). The bits do not depend on
   the processor, nor on whose C library there is.

   The polynomials are those of fdlibm (https://www.netlib.org/fdlibm: e_log.c, e_exp.c, k_sin.c, k_cos.c), with errors below one
   unit of the last place. Its notice: "Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved. Developed at
   SunPro, a Sun Microsystems, Inc. business. Permission to use, copy, modify, and distribute this software is freely
   granted, provided that this notice is preserved." */
#include "vectors.h"
#include <math.h>

enum { ROUNDS = 10 };

/* Table 2 of the paper that gracecg_base_random names; words of 32 bits */
static const uint64_t MULTIPLIER_0 = 0xD2511F53, MULTIPLIER_1 = 0xCD9E8D57, INCREMENT_0 = 0x9E3779B9, INCREMENT_1 = 0xBB67AE85;
static const uint64_t LOW = 0xFFFFFFFF;

#define KERNEL "elementary_variant.h"
#include "every_width.h"

INTERNAL void gracecg_random_block(int32_t widest, const uint64_t *key, const uint64_t *counter, uint64_t *words)
{
    CALL(block, key, counter, words);
}

INTERNAL void gracecg_random_normals(int32_t widest, int32_t pairs, const uint64_t *key, const uint64_t *counter, double *x)
{
    CALL(normals, key, counter, pairs, x);
}

/* Four numbers are no vector of eight. */
INLINE int32_t no_wider_than(int32_t n, int32_t widest)
{
    return n % 8 == 0 || widest < 4 ? widest : 4;
}

INTERNAL void gracecg_lanes_sines_cosines(int32_t widest, int32_t n, const double *turns, double *sines, double *cosines)
{
    widest = no_wider_than(n, widest);
    CALL(sines_cosines, n, turns, sines, cosines);
}

INTERNAL void gracecg_lanes_exponentials(int32_t widest, int32_t n, const double *x, double *y)
{
    widest = no_wider_than(n, widest);
    CALL(exponentials, n, x, y);
}
