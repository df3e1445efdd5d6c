/* The formula of dtm_expansions.c for vectors of WIDTH numbers (every_width.h): some 90 products and sums a vector, and a
   few for the place alone. Four lanes are one vector of 4 numbers or of 8. */
#define COLUMN(i) READ(&columns[i][l])
#define A(i) COLUMN((i) - 1)

/* G(L) = 1 + F1 + M + Q + beta (AN1 + SAN1 + AN2 + SAN2 + D + SD + TD), Barlier et al. (1978); A(37) P10 in Q and A(39) Kp^2,
   or exp(Kp) with a column of its own, in M are of DTM-94. */
TARGET static void VARIANT(expansions)(int count, columns_t columns, const struct harmonics *h, double *g)
{
    for (int l = 0; l < count; l += WIDTH) {
        const VECTOR steady = COLUMN(FLUX) + A(7)*h->kp + (A(2) + A(8)*h->kp)*h->p20 + A(3)*h->p40 + A(37)*h->p10 +
            A(39)*(h->kp*h->kp) + COLUMN(EXPONENTIAL_KP)*h->exponential_kp;
        const VECTOR annual = (A(9) + A(10)*h->p20)*
            (COLUMN(ANNUAL)*h->year[0] + COLUMN(ANNUAL + 1)*h->year[1]);
        const VECTOR semiannual = (A(12) + A(13)*h->p20)*
            (COLUMN(SEMIANNUAL)*h->half_year[0] + COLUMN(SEMIANNUAL + 1)*h->half_year[1]);
        const VECTOR season = COLUMN(ANTISYMMETRIC_ANNUAL)*h->year[0] + COLUMN(ANTISYMMETRIC_ANNUAL + 1)*h->year[1];
        const VECTOR half_season = COLUMN(ANTISYMMETRIC_SEMIANNUAL)*h->half_year[0] +
            COLUMN(ANTISYMMETRIC_SEMIANNUAL + 1)*h->half_year[1];
        const VECTOR antisymmetric = (A(15)*h->p10 + A(16)*h->p30 + A(17)*h->p50)*season + A(19)*h->p10*half_season;
        const VECTOR diurnal =
            (A(21)*h->p11 + A(22)*h->p31 + A(23)*h->p51 + (A(24)*h->p11 + A(25)*h->p21)*season)*h->day[0] +
            (A(26)*h->p11 + A(27)*h->p31 + A(28)*h->p51 + (A(29)*h->p11 + A(30)*h->p21)*season)*h->day[1];
        const VECTOR semidiurnal = (A(31)*h->p22 + A(32)*h->p32*season)*h->half_day[0] +
            (A(33)*h->p22 + A(34)*h->p32*season)*h->half_day[1];
        const VECTOR terdiurnal = h->p33*(A(35)*h->third_day[0] + A(36)*h->third_day[1]);

        AT(&g[l]) = steady + COLUMN(BETA)*(annual + semiannual + antisymmetric + diurnal + semidiurnal + terdiurnal);
    }
}

#undef COLUMN
#undef A
