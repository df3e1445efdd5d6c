/* The loops of plate_loads.c for vectors of WIDTH numbers (every_width.h).

   What the machine does. GRACE has six plates: one vector of 8 numbers, two of 4. A vector is put together from numbers of
   WIDTH plates, 72 bytes apart, at little more than an instruction a number. Air then takes some 110 products, sums and
   comparisons a vector, most of them in the two polynomials of erfc and the one of exp, and 3 quotients; light some 50. */
#include "../base/functions_variant.h"

/* One number of each of WIDTH plates */
TARGET INLINE VECTOR VARIANT(of_plates)(const double *number)
{
    VECTOR numbers;

    for (int l = 0; l < WIDTH; l++) numbers[l] = number[l*(sizeof(struct plate)/sizeof(double))];
    return numbers;
}

/* The areas of WIDTH plates, 0 for those that do not exist */
TARGET INLINE VECTOR VARIANT(areas_of)(const struct plate *plate, int existing)
{
    static const double number[LANES] = {0, 1, 2, 3, 4, 5, 6, 7};
    const VECTOR zero = {0};

    return VARIANT(choice)((BITS)(READ(number) < zero + existing), VARIANT(of_plates)(&plate->area), zero);
}

/* 0 in place of a negative number, or of NaN */
TARGET INLINE VECTOR VARIANT(positive)(VECTOR x)
{
    return (VECTOR)((BITS)(x > 0) & (BITS)x);
}

/* Adds forces on plates, and their torques about the centre of mass. */
TARGET INLINE void VARIANT(add_forces)(const struct plate *plate, const double *centre_of_mass, const VECTOR *force, VECTOR *sum)
{
    const VECTOR x = VARIANT(of_plates)(&plate->centre[0]) - centre_of_mass[0];
    const VECTOR y = VARIANT(of_plates)(&plate->centre[1]) - centre_of_mass[1];
    const VECTOR z = VARIANT(of_plates)(&plate->centre[2]) - centre_of_mass[2];

    for (int i = 0; i < 3; i++) sum[FORCE + i] += force[i];
    sum[TORQUE] += y*force[2] - z*force[1];
    sum[TORQUE + 1] += z*force[0] - x*force[2];
    sum[TORQUE + 2] += x*force[1] - y*force[0];
}

/* 1 + erf(w), given e = exp(-w^2). erfc(x) = e R(x) for x >= 0, R a quotient of polynomials with positive coefficients, 2.4e-17
   of itself off exp(x^2) erfc(x) at 22 places of a Chebyshev grid in (x - 2.5)/(x + 2.5) and between them. Beyond 27, where e is
   nothing, R is that of 27. */
TARGET INLINE VECTOR VARIANT(one_plus_erf)(VECTOR w, VECTOR e)
{
    const VECTOR zero = {0}, most = zero + 27, size = VARIANT(choice)((BITS)(w < 0), -w, w);
    const VECTOR x = VARIANT(choice)((BITS)(size < most), size, most);
    const VECTOR p = 1 + x*(2.4088724141114564 + x*(2.867965959266897 + x*(2.1859049465747327 + x*(
                     1.1712747649980797 + x*(0.4592273728934928 + x*(0.13331415236542968 + x*(0.028345893811779006 + x*(
                     0.004243873805181623 + x*(0.00040728887609039804 + x*1.9300996693953924e-05)))))))));
    const VECTOR q = 1 + x*(3.5372515812069696 + x*(5.8593269522764775 + x*(6.012448609582029 + x*(4.25717689567263 + x*(
                     2.190458781132582 + x*(0.8387192696619542 + x*(0.2400371129076327 + x*(0.05060273901253051 + x*(
                     0.007539175531709088 + x*(0.0007219007368574066 + x*3.4210125916513266e-05))))))))));
    const VECTOR tail = e*p/q;

    return VARIANT(choice)((BITS)(w > 0), 2 - tail, tail);
}

TARGET static void VARIANT(plates_in_air)(int count, const struct plate *plates, const double *centre_of_mass,
                                          const struct flow *flow, struct plate_sums *sums)
{
    const double half_root_pi = 0.88622692545275801365, inverse_root_pi = 0.56418958354775628695;
    const double *v = flow->velocity, c = flow->thermal_speed, inverse_c = 1/c;
    double total[SUMS][LANES];

    for (int l = 0; l < LANES; l += WIDTH) {
        VECTOR sum[SUMS] = {{0}};
        for (int i = l; i < count; i += LANES) {
            const struct plate *plate = &plates[i];
            const VECTOR area = VARIANT(areas_of)(plate, count - i);
            const VECTOR n_x = VARIANT(of_plates)(&plate->normal[0]), n_y = VARIANT(of_plates)(&plate->normal[1]);
            const VECTOR n_z = VARIANT(of_plates)(&plate->normal[2]);
            const VECTOR along_normal = n_x*v[0] + n_y*v[1] + n_z*v[2], w = along_normal*inverse_c;
            const VECTOR e = VARIANT(exponential)(-(w*w)), one_plus_erf = VARIANT(one_plus_erf)(w, e);
            const VECTOR mass_flux = flow->density*c/2*(e*inverse_root_pi + w*one_plus_erf);
            const VECTOR pressure = flow->density*c*c/4*one_plus_erf + half_root_pi*flow->leaving_speed*mass_flux;
            const VECTOR force[3] = { -area*(mass_flux*v[0] + pressure*n_x), -area*(mass_flux*v[1] + pressure*n_y),
                                      -area*(mass_flux*v[2] + pressure*n_z) };
            VARIANT(add_forces)(plate, centre_of_mass, force, sum);
            sum[PROJECTED_AREA] += area*VARIANT(positive)(along_normal);
        }
        for (int s = 0; s < SUMS; s++) AT(&total[s][l]) = sum[s];
    }
    for (int i = 0; i < 3; i++) sums->force[i] = total_of(total[FORCE + i]);
    for (int i = 0; i < 3; i++) sums->torque[i] = total_of(total[TORQUE + i]);
    sums->projected_area = total_of(total[PROJECTED_AREA]);
}

TARGET static void VARIANT(plates_in_light)(int count, const struct plate *plates, const double *centre_of_mass,
                                            const struct light *light, struct plate_sums *sums)
{
    const double *u = light->to_source;
    double total[SUMS][LANES];

    for (int l = 0; l < LANES; l += WIDTH) {
        VECTOR sum[SUMS] = {{0}};
        for (int i = l; i < count; i += LANES) {
            const struct plate *plate = &plates[i];
            const VECTOR n_x = VARIANT(of_plates)(&plate->normal[0]), n_y = VARIANT(of_plates)(&plate->normal[1]);
            const VECTOR n_z = VARIANT(of_plates)(&plate->normal[2]);
            const VECTOR specular = VARIANT(of_plates)(&plate->specular), diffuse = VARIANT(of_plates)(&plate->diffuse);
            const VECTOR cosine = VARIANT(positive)(n_x*u[0] + n_y*u[1] + n_z*u[2]);
            const VECTOR lit_area = VARIANT(areas_of)(plate, count - i)*cosine, thrust = -light->pressure*lit_area;
            const VECTOR along_light = thrust*(1 - specular), along_normal = thrust*(2*(specular*cosine + diffuse/3));
            const VECTOR force[3] = { along_light*u[0] + along_normal*n_x, along_light*u[1] + along_normal*n_y,
                                      along_light*u[2] + along_normal*n_z };
            VARIANT(add_forces)(plate, centre_of_mass, force, sum);
            sum[PROJECTED_AREA] += lit_area;
        }
        for (int s = 0; s < SUMS; s++) AT(&total[s][l]) = sum[s];
    }
    for (int i = 0; i < 3; i++) sums->force[i] = total_of(total[FORCE + i]);
    for (int i = 0; i < 3; i++) sums->torque[i] = total_of(total[TORQUE + i]);
    sums->projected_area = total_of(total[PROJECTED_AREA]);
}
