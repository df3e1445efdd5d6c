/* The loops of harmonic_sums.c for vectors of WIDTH numbers (every_width.h).

   What the machine does. The recursion is a chain of a product and a difference, 6 cycles a degree on Zen 4. Beside
   it a degree takes 8 products and 6 sums of a vector for first derivatives, two of each a cycle, half as many of
   8 numbers: they hide behind the chain, or with 8 numbers take a little longer than it. For that the recursion
   stands first in the loop: behind the other products, it waits for them (1.4 times as long).
   Coefficients are 40 bytes an order and degree: those of 20x20 stay in the first cache, those of 70x70 (112 KB) come
   from the second at each place, or once for PLACES. */

/* At one place, WIDTH orders side by side; `sums` up to FIRST_DERIVATIVES or SECOND_DERIVATIVES */
TARGET INLINE void VARIANT(sum_place)(const int count, int blocks, int orders, const int32_t *first, steps_t steps,
                                      const double *q, double *sums)
{
    const VECTOR zero = {0}, q_z = zero + q[2], minus_q_squared = zero - (q[0]*q[0] + q[1]*q[1] + q[2]*q[2]);
    double power_re[LANES*MOST_BLOCKS + 3], power_im[LANES*MOST_BLOCKS + 3];
    double total[SECOND_DERIVATIVES][LANES], order[LANES];

    powers_of(q[0], q[1], blocks, power_re, power_im);
    for (int l = 0; l < LANES; l++) order[l] = l;

    for (int l = 0; l < LANES; l += WIDTH) {
        VECTOR sum[SECOND_DERIVATIVES];
        for (int s = 0; s < count; s++) sum[s] = zero;
        for (int block = 0; block < blocks && LANES*block + l < orders; block++) {
            /* k = 0: h is 1. The last step of a block is of its first order, the one before it of the second, ... */
            int i = first[block];
            const int end = first[block + 1] - l;
            VECTOR h = zero + 1, next = q_z, k = zero + 1;
            VECTOR re = READ(&steps[i][F][l]), im = READ(&steps[i][F + 1][l]);
            VECTOR d_re = READ(&steps[i][DF][l]), d_im = READ(&steps[i][DF + 1][l]);
            VECTOR dd_re = READ(&steps[i][DDF][l]), dd_im = READ(&steps[i][DDF + 1][l]);
            VECTOR k_re = zero, k_im = zero, kk_re = zero, kk_im = zero, kd_re = zero, kd_im = zero;
            for (i++; i < end; i++) {
                const VECTOR after = q_z*next + minus_q_squared*READ(&steps[i][BETA][l])*h;
                h = next;
                next = after;
                const VECTOR f_re = h*READ(&steps[i][F][l]), f_im = h*READ(&steps[i][F + 1][l]);
                const VECTOR df_re = h*READ(&steps[i][DF][l]), df_im = h*READ(&steps[i][DF + 1][l]);
                re += f_re;
                im += f_im;
                k_re += k*f_re;
                k_im += k*f_im;
                d_re += df_re;
                d_im += df_im;
                if (count == SECOND_DERIVATIVES) {
                    kk_re += k*(k*f_re);
                    kk_im += k*(k*f_im);
                    kd_re += k*df_re;
                    kd_im += k*df_im;
                    dd_re += h*READ(&steps[i][DDF][l]);
                    dd_im += h*READ(&steps[i][DDF + 1][l]);
                }
                k += 1;
            }
            /* The powers m, m - 1 and m - 2 of q_x + i q_y; sums with n = m + k in place of k */
            const int m_first = block*LANES + l;
            const VECTOR m = READ(&order[l]) + (double)(block*LANES);
            const VECTOR p_re = READ(&power_re[2 + m_first]), p_im = READ(&power_im[2 + m_first]);
            const VECTOR b_re = READ(&power_re[1 + m_first]), b_im = READ(&power_im[1 + m_first]);
            const VECTOR n_re = m*re + k_re, n_im = m*im + k_im;
            sum[PHI] += p_re*re + p_im*im;
            sum[N_PHI] += p_re*n_re + p_im*n_im;
            sum[DX] += m*(b_re*re + b_im*im);
            sum[DY] += m*(b_re*im - b_im*re);
            sum[DZ] += b_re*d_re + b_im*d_im;
            if (count == SECOND_DERIVATIVES) {
                const VECTOR c_re = READ(&power_re[m_first]), c_im = READ(&power_im[m_first]);
                sum[NN_PHI] += p_re*(m*(n_re + k_re) + kk_re) + p_im*(m*(n_im + k_im) + kk_im);
                sum[N_DX] += m*(b_re*n_re + b_im*n_im);
                sum[N_DY] += m*(b_re*n_im - b_im*n_re);
                sum[N_DZ] += b_re*(m*d_re + kd_re) + b_im*(m*d_im + kd_im);
                sum[DXX] += m*(m - 1)*(c_re*re + c_im*im);
                sum[DXY] += m*(m - 1)*(c_re*im - c_im*re);
                sum[DXZ] += (m - 1)*(c_re*d_re + c_im*d_im);
                sum[DYZ] += (m - 1)*(c_re*d_im - c_im*d_re);
                sum[DZZ] += c_re*dd_re + c_im*dd_im;
            }
        }
        for (int s = 0; s < count; s++) AT(&total[s][l]) = sum[s];
    }
    for (int s = 0; s < count; s++) sums[s] = total_of(total[s]);
}

TARGET static void VARIANT(sum_first)(int blocks, int orders, const int32_t *first, steps_t steps, const double *q,
                                      double *sums)
{
    VARIANT(sum_place)(FIRST_DERIVATIVES, blocks, orders, first, steps, q, sums);
}

TARGET static void VARIANT(sum_second)(int blocks, int orders, const int32_t *first, steps_t steps, const double *q,
                                       double *sums)
{
    VARIANT(sum_place)(SECOND_DERIVATIVES, blocks, orders, first, steps, q, sums);
}

struct VARIANT(order_sums) {
    VECTOR re, im, k_re, k_im, d_re, d_im;
};

/* Adds to the sums of orders, of f, k f and the derivative by q_z for cos and sin, the products of a step with h. */
TARGET INLINE void VARIANT(add_step)(const double (*step)[LANES], int l, VECTOR h, VECTOR k, struct VARIANT(order_sums) *s)
{
    const VECTOR f_re = h*READ(&step[F][l]), f_im = h*READ(&step[F + 1][l]);

    s->re += f_re;
    s->im += f_im;
    s->k_re += k*f_re;
    s->k_im += k*f_im;
    s->d_re += h*READ(&step[DF][l]);
    s->d_im += h*READ(&step[DF + 1][l]);
}

/* Adds orders m to the sums of a function; p are their powers of q_x + i q_y, b those of m - 1. */
TARGET INLINE void VARIANT(add_orders)(const struct VARIANT(order_sums) *s, VECTOR m, const VECTOR p[2], const VECTOR b[2],
                                       VECTOR *sum)
{
    sum[PHI] += p[0]*s->re + p[1]*s->im;
    sum[N_PHI] += p[0]*(m*s->re + s->k_re) + p[1]*(m*s->im + s->k_im);
    sum[DX] += m*(b[0]*s->re + b[1]*s->im);
    sum[DY] += m*(b[0]*s->im - b[1]*s->re);
    sum[DZ] += b[0]*s->d_re + b[1]*s->d_im;
}

/* Two functions at one place, the other with no more degrees and orders: recursion and powers serve both. Each has the
   operations that sum_place has for it. */
TARGET static void VARIANT(sum_two)(const struct function *one, const struct function *other, const double *q,
                                    double (*sums)[FIRST_DERIVATIVES])
{
    const VECTOR zero = {0}, q_z = zero + q[2], minus_q_squared = zero - (q[0]*q[0] + q[1]*q[1] + q[2]*q[2]);
    double power_re[LANES*MOST_BLOCKS + 3], power_im[LANES*MOST_BLOCKS + 3];
    double total[2][FIRST_DERIVATIVES][LANES], order[LANES];

    powers_of(q[0], q[1], one->blocks, power_re, power_im);
    for (int l = 0; l < LANES; l++) order[l] = l;

    for (int l = 0; l < LANES; l += WIDTH) {
        VECTOR sum[2][FIRST_DERIVATIVES];
        for (int s = 0; s < FIRST_DERIVATIVES; s++) sum[0][s] = sum[1][s] = zero;
        for (int block = 0; block < one->blocks && LANES*block + l < one->orders; block++) {
            const int m_first = LANES*block + l, both = m_first < other->orders;
            const int count = one->first[block + 1] - one->first[block] - l;
            const int other_count = both ? other->first[block + 1] - other->first[block] - l : 0;
            steps_t step = &one->steps[one->first[block]], other_step = &other->steps[both ? other->first[block] : 0];
            struct VARIANT(order_sums) s = {{0}}, o = {{0}};
            VECTOR h = zero + 1, next = q_z, k = zero;
            int i = 1;

            VARIANT(add_step)(step[0], l, h, k, &s);
            if (both) VARIANT(add_step)(other_step[0], l, h, k, &o);
            for (; i < other_count; i++) {
                const VECTOR after = q_z*next + minus_q_squared*READ(&step[i][BETA][l])*h;
                h = next;
                next = after;
                k += 1;
                VARIANT(add_step)(step[i], l, h, k, &s);
                VARIANT(add_step)(other_step[i], l, h, k, &o);
            }
            for (; i < count; i++) {
                const VECTOR after = q_z*next + minus_q_squared*READ(&step[i][BETA][l])*h;
                h = next;
                next = after;
                k += 1;
                VARIANT(add_step)(step[i], l, h, k, &s);
            }
            const VECTOR m = READ(&order[l]) + (double)(block*LANES);
            const VECTOR p[2] = { READ(&power_re[2 + m_first]), READ(&power_im[2 + m_first]) };
            const VECTOR b[2] = { READ(&power_re[1 + m_first]), READ(&power_im[1 + m_first]) };
            VARIANT(add_orders)(&s, m, p, b, sum[0]);
            if (both) VARIANT(add_orders)(&o, m, p, b, sum[1]);
        }
        for (int s = 0; s < FIRST_DERIVATIVES; s++) {
            AT(&total[0][s][l]) = sum[0][s];
            AT(&total[1][s][l]) = sum[1][s];
        }
    }
    for (int s = 0; s < FIRST_DERIVATIVES; s++) {
        sums[0][s] = total_of(total[0][s]);
        sums[1][s] = total_of(total[1][s]);
    }
}

/* At PLACES places, WIDTH of them side by side, order by order: each with the operations that sum_place has for it */
TARGET static void VARIANT(sum_places)(int orders, const int32_t *first, steps_t steps, const double (*q)[PLACES],
                                       double (*sums)[PLACES])
{
    const VECTOR zero = {0};

    for (int place = 0; place < PLACES; place += WIDTH) {
        /* The powers for the orders of a block, behind the one before them; total[s][lane] */
        VECTOR power_re[LANES + 1], power_im[LANES + 1], step_re, step_im, total[FIRST_DERIVATIVES][LANES];
        const VECTOR q_x = READ(&q[0][place]), q_y = READ(&q[1][place]), q_z = READ(&q[2][place]);
        const VECTOR minus_q_squared = -(q_x*q_x + q_y*q_y + q_z*q_z);

        for (int s = 0; s < FIRST_DERIVATIVES; s++)
            for (int l = 0; l < LANES; l++) total[s][l] = zero;
        for (int p = 0; p < WIDTH; p++) {
            double re[LANES + 3], im[LANES + 3];
            powers_of(q_x[p], q_y[p], 1, re, im);
            for (int l = 0; l <= LANES; l++) {
                power_re[l][p] = re[1 + l];
                power_im[l][p] = im[1 + l];
            }
            step_re[p] = re[2 + LANES];
            step_im[p] = im[2 + LANES];
        }
        for (int order = 0; order < orders; order++) {
            const int block = order/LANES, l = order%LANES;
            int i = first[block];
            VECTOR h = zero + 1, next = q_z, k = zero + 1, m = zero + (double)order;
            VECTOR re = zero + steps[i][F][l], im = zero + steps[i][F + 1][l];
            VECTOR d_re = zero + steps[i][DF][l], d_im = zero + steps[i][DF + 1][l], k_re = zero, k_im = zero;
            for (i++; i < first[block + 1] - l; i++) {
                const VECTOR after = q_z*next + minus_q_squared*steps[i][BETA][l]*h;
                h = next;
                next = after;
                const VECTOR f_re = h*steps[i][F][l], f_im = h*steps[i][F + 1][l];
                re += f_re;
                im += f_im;
                k_re += k*f_re;
                k_im += k*f_im;
                d_re += h*steps[i][DF][l];
                d_im += h*steps[i][DF + 1][l];
                k += 1;
            }
            if (l == 0 && block > 0) {
                power_re[0] = power_re[LANES];
                power_im[0] = power_im[LANES];
                for (int i = 1; i <= LANES; i++) {
                    const VECTOR old_re = power_re[i], old_im = power_im[i];
                    power_re[i] = old_re*step_re - old_im*step_im;
                    power_im[i] = old_re*step_im + old_im*step_re;
                }
            }
            const VECTOR p_re = power_re[l + 1], p_im = power_im[l + 1], b_re = power_re[l], b_im = power_im[l];
            total[PHI][l] += p_re*re + p_im*im;
            total[N_PHI][l] += p_re*(m*re + k_re) + p_im*(m*im + k_im);
            total[DX][l] += m*(b_re*re + b_im*im);
            total[DY][l] += m*(b_re*im - b_im*re);
            total[DZ][l] += b_re*d_re + b_im*d_im;
        }
        for (int s = 0; s < FIRST_DERIVATIVES; s++) {
            const VECTOR *v = total[s];
            AT(&sums[s][place]) = ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
        }
    }
}
