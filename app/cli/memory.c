/* How the program treats the system's memory. An estimate takes and gives back some megabytes in arrays of a few hundred
   kilobytes; the C library of GNU gives these back to the system at once, and each new one costs the faults of its pages:
   a sixth of the time of a Monte Carlo. So the program keeps what it has had, up to KEPT bytes. What a program that links
   the library does with memory is its own. */
#include <stdlib.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

enum { KEPT = 256 << 20, LARGE = 32 << 20 };    /* Arrays from LARGE on, the most there can be, are given back as before */

__attribute__((visibility("hidden"))) void gracecg_keep_memory(void)
{
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, LARGE);
    mallopt(M_TRIM_THRESHOLD, KEPT);
#endif
}
