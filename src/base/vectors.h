/* What the kernels in C have in common. They are in C because a C compiler makes several variants of a function, of
   which the one for the processor's widest vectors (2, 4 or 8 numbers) is taken when the program runs; gfortran does
   not. All variants give the same bits: what lies side by side in a vector knows nothing of its neighbours; sums have
   one order; a product and a sum are rounded each (no FMA).

   A kernel's file includes this, then says which header has its loops and has it compiled for each width:

       #define KERNEL "loops.h"         (as seen from the folder of every_width.h)
       #include "every_width.h"

   and calls them by CALL. They need the vector types of GNU C: gcc, clang and their relatives. */
#ifndef GRACECG_VECTORS_H
#define GRACECG_VECTORS_H

#include <stdint.h>

#ifdef __FAST_MATH__
#error "compile gracecg without -ffast-math: the sums have one order, and NaN is told from numbers"
#endif

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#else
/* fpm calls the compiler without flags: there would be no optimisation. */
#pragma GCC optimize("O3", "fp-contract=off")
#endif

#ifdef __x86_64__
#include <immintrin.h>
#endif

#define INLINE static inline __attribute__((always_inline))

/* The sum of 8 numbers, as many as the widest vector has, in pairs: vectors of two numbers, which every processor has, in
   memory that was written as wider ones */
INLINE double total_of(const double *value)
{
    typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));
    const pair *pairs = (const pair *)value, sum = (pairs[0] + pairs[2]) + (pairs[1] + pairs[3]);

    return sum[0] + sum[1];
}

/* A function that the library's Fortran calls; the shared library does not show it. */
#define INTERNAL __attribute__((visibility("hidden")))

/* The processor's answer is read from a table that was filled when the program started. */
#ifdef __x86_64__
#define CALL(name, ...) \
    if (widest >= 8 && __builtin_cpu_supports("avx512f")) name##_avx512(__VA_ARGS__); \
    else if (widest >= 4 && __builtin_cpu_supports("avx2")) name##_avx2(__VA_ARGS__); \
    else name##_plain(__VA_ARGS__)
#else
#define CALL(name, ...) (void)widest, name##_plain(__VA_ARGS__)
#endif

#endif
