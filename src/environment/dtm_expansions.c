/* The expansions of the module gracecg_environment_dtm, which says what they are. The formula stands in
   dtm_expansions_variant.h, which is compiled for each width of vectors: temperature and constituents lie side by side. */
#include "../base/vectors.h"

/* As in the Fortran module */
enum { LANES = 8 };

/* The columns of an expansion: the coefficients A(1..39), and what is worked out from them */
enum { EXPONENTIAL_KP = 39, FLUX, BETA, ANNUAL, SEMIANNUAL = ANNUAL + 2, ANTISYMMETRIC_ANNUAL = SEMIANNUAL + 2,
       ANTISYMMETRIC_SEMIANNUAL = ANTISYMMETRIC_ANNUAL + 2 };

struct harmonics {
    double p10, p20, p30, p40, p50, p11, p21, p31, p51, p22, p32, p33;
    double year[2], half_year[2], day[2], half_day[2], third_day[2];
    double kp, exponential_kp;
};

typedef const double (*columns_t)[LANES];

#define KERNEL "../environment/dtm_expansions_variant.h"
#include "../base/every_width.h"

INTERNAL void gracecg_dtm_expansions(int32_t widest, int32_t count, columns_t columns, const struct harmonics *h, double *g)
{
    CALL(expansions, count, columns, h, g);
}
