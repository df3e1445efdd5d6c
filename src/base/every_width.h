/* Compiles the header KERNEL for vectors of each width (vectors.h). It finds WIDTH, the numbers of a vector; TARGET,
   before each function, the instructions that have them; VARIANT(name), a name of its own for each function; VECTOR, the
   type, and BITS, as whole numbers; AT(numbers) and READ(numbers), a vector in memory to change or to read. */
#define VECTOR VARIANT(vector)
#define BITS VARIANT(bits)
#define AT(numbers) (*(VECTOR *)(numbers))
#define READ(numbers) (*(const VECTOR *)(numbers))

#define WIDTH 2
#define TARGET
#define VARIANT(name) name##_plain
typedef double VECTOR __attribute__((vector_size(8*WIDTH), aligned(8), may_alias));
typedef uint64_t BITS __attribute__((vector_size(8*WIDTH), may_alias));
#include KERNEL
#undef WIDTH
#undef TARGET
#undef VARIANT

#ifdef __x86_64__
#define WIDTH 4
#define TARGET __attribute__((target("avx2")))
#define VARIANT(name) name##_avx2
typedef double VECTOR __attribute__((vector_size(8*WIDTH), aligned(8), may_alias));
typedef uint64_t BITS __attribute__((vector_size(8*WIDTH), may_alias));
#include KERNEL
#undef WIDTH
#undef TARGET
#undef VARIANT

#define WIDTH 8
#define TARGET __attribute__((target("avx512f")))
#define VARIANT(name) name##_avx512
typedef double VECTOR __attribute__((vector_size(8*WIDTH), aligned(8), may_alias));
typedef uint64_t BITS __attribute__((vector_size(8*WIDTH), may_alias));
#include KERNEL
#undef WIDTH
#undef TARGET
#undef VARIANT
#endif

#undef VECTOR
#undef BITS
#undef AT
#undef READ
