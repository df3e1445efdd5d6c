/* The loops of earth_light.c for vectors of WIDTH numbers (every_width.h).

   What the machine does. The rings are one vector up to 4 or 8 of them: some 50 products and sums, 6 roots, 4 quotients, each
   waiting for the one before. Of the segments a vector takes some 25 products and sums; the cap has one to itself. */
#include "../base/functions_variant.h"

/* Cosine and sine of the angle beta at the Earth's centre, from the subsatellite point to the boundary that has a part of all
   segments inside it. All fill the same solid angle, so the boundary's nadir angle zeta follows from
   1 - cos(zeta) = part (1 - cos(zeta_m)); then beta = gamma - zeta, sin(gamma) = r_s sin(zeta)/R. Of cos(gamma)^2 the
   difference to 1 is worked out, since gamma is a right angle at the limb. */
TARGET INLINE void VARIANT(boundary)(const struct view *view, VECTOR part, VECTOR *cosine, VECTOR *sine)
{
    const double limb = view->limb_depth;
    const VECTOR zero = {0}, depth = limb*part, cos_zeta = 1 - depth, squared = depth*(2 - depth);
    const VECTOR cos_gamma_squared = (1 - part)*(2 - limb*(1 + part))/(2 - limb);
    const VECTOR cos_gamma = VARIANT(root)(VARIANT(choice)((BITS)(cos_gamma_squared > 0), cos_gamma_squared, zero));
    const VECTOR sin_zeta = VARIANT(root)(squared), sin_gamma = view->radius*sin_zeta;

    *cosine = cos_gamma*cos_zeta + sin_gamma*sin_zeta;
    *sine = sin_gamma*cos_zeta - cos_gamma*sin_zeta;
}

/* Half-way between the two boundaries of each ring: the direction of the sum of their unit vectors. From there to the
   satellite it is `upward` along the satellite's vertical and `sideward` across it, in all 1. */
TARGET INLINE void VARIANT(find_centres)(const struct segments *segments, const struct view *view, struct centres *centres)
{
    for (int l = 0; l < segments->rings; l += WIDTH) {
        VECTOR inner_cosine, inner_sine, outer_cosine, outer_sine;

        VARIANT(boundary)(view, READ(&segments->inner[l]), &inner_cosine, &inner_sine);
        VARIANT(boundary)(view, READ(&segments->outer[l]), &outer_cosine, &outer_sine);
        const VECTOR x = inner_cosine + outer_cosine, y = inner_sine + outer_sine, length = VARIANT(root)(x*x + y*y);
        const VECTOR cosine = x/length, sine = y/length;
        const VECTOR upward = view->radius - cosine, distance = VARIANT(root)(upward*upward + sine*sine);
        AT(&centres->cosine[l]) = cosine;
        AT(&centres->sine[l]) = sine;
        AT(&centres->upward[l]) = upward/distance;
        AT(&centres->sideward[l]) = -sine/distance;
    }
}

TARGET static void VARIANT(ring_centres)(const struct segments *segments, const struct view *view, struct centres *centres)
{
    VARIANT(find_centres)(segments, view, centres);
}

TARGET static void VARIANT(earth_flux)(const struct segments *segments, const struct view *view, double *flux)
{
    const double *albedo = view->albedo, *emissivity = view->emissivity;
    struct centres centres;
    double total[3][LANES];

    VARIANT(find_centres)(segments, view, &centres);
    for (int l = 0; l < LANES; l += WIDTH) {
        VECTOR up = {0}, north = {0}, east = {0};
        for (int ring = 0; ring < segments->rings; ring++) {
            const double c = centres.cosine[ring], s = centres.sine[ring];
            const double upward = centres.upward[ring], sideward = centres.sideward[ring];
            const double sine_up = c*view->up_z, sine_north = s*view->north_z;
            const double sun_up = c*view->sun_up, sun_north = s*view->sun_north, sun_east = s*view->sun_east;
            for (int i = l; i < segments->count[ring]; i += LANES) {
                const int segment = segments->first[ring] + i;
                const VECTOR cos_azimuth = READ(&segments->cos_azimuth[segment]);
                const VECTOR sin_azimuth = READ(&segments->sin_azimuth[segment]);
                const VECTOR sine = sine_up + sine_north*cos_azimuth;
                const VECTOR cosine = sun_up + sun_north*cos_azimuth + sun_east*sin_azimuth;
                const VECTOR lit = (VECTOR)((BITS)(cosine > 0) & (BITS)cosine);
                const VECTOR radiance = (albedo[0] + sine*(albedo[1] + sine*albedo[2]))*lit +
                    (emissivity[0] + sine*(emissivity[1] + sine*emissivity[2]));
                up += upward*(radiance*READ(&segments->exists[segment]));
                north += sideward*(radiance*cos_azimuth);
                east += sideward*(radiance*sin_azimuth);
            }
        }
        AT(&total[0][l]) = up;
        AT(&total[1][l]) = north;
        AT(&total[2][l]) = east;
    }
    for (int i = 0; i < 3; i++) flux[i] = total_of(total[i]);
}
