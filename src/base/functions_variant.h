/* Functions of the numbers of a vector, for kernels that need them (every_width.h). */

/* Of two vectors the numbers of the first where a comparison holds, else those of the second */
TARGET INLINE VECTOR VARIANT(choice)(BITS holds, VECTOR first, VECTOR second)
{
    return (VECTOR)((holds & (BITS)first) | (~holds & (BITS)second));
}

/* Square roots: the compilers' vectors have none, and sqrt of their numbers one by one is asked for its errno */
TARGET INLINE VECTOR VARIANT(root)(VECTOR x)
{
#if !defined(__x86_64__)
    for (int l = 0; l < WIDTH; l++) x[l] = sqrt(x[l]);
    return x;
#elif WIDTH == 2
    return (VECTOR)_mm_sqrt_pd((__m128d)x);
#elif WIDTH == 4
    return (VECTOR)_mm256_sqrt_pd((__m256d)x);
#else
    return (VECTOR)_mm512_sqrt_pd((__m512d)x);
#endif
}

/* The exponential function. The polynomial is that of fdlibm (e_exp.c; notice in elementary.c), with an error below one unit
   of the last place. Numbers beyond -708 and 709 are taken for these, so that 2^k is a normal number; NaN stays. */
TARGET INLINE VECTOR VARIANT(exponential)(VECTOR x)
{
    const double ln2_high = 6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10;
    const VECTOR zero = {0}, least = zero - 708, most = zero + 709;
    x = VARIANT(choice)((BITS)(x < least), least, x);
    x = VARIANT(choice)((BITS)(x > most), most, x);

    /* 2^52 + 2^51 more, a number has its nearest integer in its last bits: k, 1023 more for the exponent of 2^k */
    const VECTOR shifted = x*1.44269504088896338700 + (0x1.8p52 + 1023), k = shifted - (0x1.8p52 + 1023);
    const VECTOR high = x - k*ln2_high, low = k*ln2_low, r = high - low, z = r*r;
    const VECTOR c = r - z*(1.66666666666666019037e-01 + z*(-2.77777777770155933842e-03 + z*(6.61375632143793436117e-05 +
                     z*(-1.65339022054652515390e-06 + z*4.13813679705723846039e-08))));

    return (1 - ((low - r*c/(2 - c)) - high))*(VECTOR)((BITS)shifted << 52);
}
