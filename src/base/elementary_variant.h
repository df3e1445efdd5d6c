/* The loops of elementary.c for vectors of WIDTH numbers (every_width.h). */

#include "functions_variant.h"

/* Philox 4x32-10: WIDTH blocks, a word of 32 bits in each 64, from `counter` on, by words. A round is two products, two
   shifts, two masks and four exclusive ors; a product of 64 bits is eight instructions where the processor has none. */
TARGET INLINE void VARIANT(blocks)(const uint64_t key[2], const uint64_t counter[4], BITS word[4])
{
    uint64_t k0 = key[0], k1 = key[1];

    for (int i = 0; i < 4; i++) word[i] = (BITS){0} + counter[i];
    for (int l = 1; l < WIDTH; l++) word[0][l] = (counter[0] + l) & LOW;
    for (int i = 0; i < ROUNDS; i++) {
        const BITS p0 = word[0]*MULTIPLIER_0, p1 = word[2]*MULTIPLIER_1;
        word[0] = p1 >> 32 ^ word[1] ^ k0;
        word[2] = p0 >> 32 ^ word[3] ^ k1;
        word[1] = p1 & LOW;
        word[3] = p0 & LOW;
        k0 = (k0 + INCREMENT_0) & LOW;
        k1 = (k1 + INCREMENT_1) & LOW;
    }
}

/* Numbers in (0, 1) from two words: 53 of their 64 bits; half of the last bit for zero. Behind the exponent of 2^52 a
   word is the number 2^52 + word. */
TARGET INLINE VECTOR VARIANT(open_unit_interval)(BITS high, BITS low)
{
    const uint64_t two_52 = 0x4330000000000000;
    const VECTOR bits = ((VECTOR)(high | two_52) - 0x1p52)*0x1p21 + ((VECTOR)(low >> 11 | two_52) - 0x1p52);
    const VECTOR zero = {0}, half = zero + 0.5;

    return (bits + (VECTOR)((BITS)(bits == zero) & (BITS)half))*0x1p-53;
}

/* Of numbers 2^k m, k < 1, m from sqrt(1/2) to sqrt(2): log m = f - (f^2/2 - s (f^2/2 + R)), f = m - 1, s = f/(2 + f) */
TARGET INLINE VECTOR VARIANT(natural_logarithm)(VECTOR x)
{
    const uint64_t root_half = 0x3FE6A09E667F3BCD, one = 0x3FF0000000000000, two_52 = 0x4330000000000000;
    const double ln2_high = 6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10;
    const BITS bits = (BITS)x + (one - root_half);
    const VECTOR k = (VECTOR)(bits >> 52 | two_52) - (0x1p52 + 1023);
    const VECTOR f = (VECTOR)((bits & 0x000FFFFFFFFFFFFF) + root_half) - 1, s = f/(2 + f), z = s*s, half_square = 0.5*f*f;
    const VECTOR r = z*(6.666666666666735130e-01 + z*(3.999999999940941908e-01 + z*(2.857142874366239149e-01 +
                     z*(2.222219843214978396e-01 + z*(1.818357216161805012e-01 + z*(1.531383769920937332e-01 +
                     z*1.479819860511658591e-01))))));
    return k*ln2_high - ((half_square - (s*(half_square + r) + k*ln2_low)) - f);
}

/* Of numbers of turns, less than 2^49: of the nearest quarter, and polynomials of the rest, at most an eighth of a turn.
   2^52 + 2^51 more, a number has its nearest integer in its last bits. */
TARGET INLINE void VARIANT(sine_and_cosine)(VECTOR turns, VECTOR *sine, VECTOR *cosine)
{
    const VECTOR quarters = 4*turns, shifted = quarters + 0x1.8p52;
    const VECTOR x = (quarters - (shifted - 0x1.8p52))*1.57079632679489661923, z = x*x;
    const VECTOR s = x + z*x*(-1.66666666666666324348e-01 + z*(8.33333333332248946124e-03 + z*(-1.98412698298579493134e-04 +
                     z*(2.75573137070700676789e-06 + z*(-2.50507602534068634195e-08 + z*1.58969099521155010221e-10)))));
    const VECTOR c = 1 - (0.5*z - z*z*(4.16666666666666019037e-02 + z*(-1.38888888888741095749e-03 +
                     z*(2.48015872894767294178e-05 + z*(-2.75573143513906633035e-07 + z*(2.08757232129817482790e-09 -
                     z*1.13596475577881948265e-11))))));
    const BITS quarter = (BITS)shifted, change = ((BITS)s ^ (BITS)c) & -(quarter & 1);

    *sine = (VECTOR)((BITS)s ^ change ^ (quarter & 2) << 62);
    *cosine = (VECTOR)((BITS)c ^ change ^ ((quarter + 1) & 2) << 62);
}

/* 25 products and sums a vector, and ten other instructions; the polynomials are chains of six products and sums, beside
   each other */
TARGET static void VARIANT(sines_cosines)(int n, const double *turns, double *sines, double *cosines)
{
    for (int i = 0; i < n; i += WIDTH) {
        VECTOR sine, cosine;

        VARIANT(sine_and_cosine)(READ(&turns[i]), &sine, &cosine);
        AT(&sines[i]) = sine;
        AT(&cosines[i]) = cosine;
    }
}

/* 19 products, sums and comparisons a vector, and a quotient */
TARGET static void VARIANT(exponentials)(int n, const double *x, double *y)
{
    for (int i = 0; i < n; i += WIDTH) AT(&y[i]) = VARIANT(exponential)(READ(&x[i]));
}

/* The first block alone */
TARGET static void VARIANT(block)(const uint64_t *key, const uint64_t *counter, uint64_t *words)
{
    BITS word[4];

    VARIANT(blocks)(key, counter, word);
    for (int i = 0; i < 4; i++) words[i] = word[i][0];
}

/* Two normal numbers from each block, by Box and Muller: some 80 products and sums of vectors, a quotient and a
   root. */
TARGET static void VARIANT(normals)(const uint64_t *key, const uint64_t *first, int pairs, double *x)
{
    uint64_t counter[4] = { first[0], first[1], first[2], first[3] };

    for (int i = 0; i < pairs; i += WIDTH, counter[0] = (counter[0] + WIDTH) & LOW) {
        const int count = pairs - i < WIDTH ? pairs - i : WIDTH;
        BITS word[4];
        VECTOR radius, along, across;

        VARIANT(blocks)(key, counter, word);
        radius = VARIANT(root)(-2*VARIANT(natural_logarithm)(VARIANT(open_unit_interval)(word[0], word[1])));
        VARIANT(sine_and_cosine)(VARIANT(open_unit_interval)(word[2], word[3]), &across, &along);
        along *= radius;
        across *= radius;
        for (int l = 0; l < count; l++) {
            x[2*(i + l)] = along[l];
            x[2*(i + l) + 1] = across[l];
        }
    }
}
