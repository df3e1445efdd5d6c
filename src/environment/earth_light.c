/* The Earth's light at a satellite: the inner loops of the module gracecg_environment_earth_radiation, which says what the
   segments are. The loops themselves stand in earth_light_variant.h, which is compiled for each width of vectors: rings,
   then segments lie side by side. */
#include "../base/vectors.h"
#include <math.h>

/* As in the Fortran module */
enum { LANES = 8, RING_LANES = 24, SEGMENT_LANES = 288 };

struct segments {
    double inner[RING_LANES], outer[RING_LANES];
    double cos_azimuth[SEGMENT_LANES], sin_azimuth[SEGMENT_LANES], exists[SEGMENT_LANES];
    int32_t rings, first[RING_LANES], count[RING_LANES];
};

struct view {
    double radius, limb_depth, up_z, north_z, sun_up, sun_north, sun_east, albedo[3], emissivity[3];
};

struct centres {
    double cosine[RING_LANES], sine[RING_LANES], upward[RING_LANES], sideward[RING_LANES];
};

#define KERNEL "../environment/earth_light_variant.h"
#include "../base/every_width.h"

INTERNAL void gracecg_ring_centres(int32_t widest, const struct segments *segments, const struct view *view,
                                   struct centres *centres)
{
    CALL(ring_centres, segments, view, centres);
}

INTERNAL void gracecg_earth_flux(int32_t widest, const struct segments *segments, const struct view *view, double *flux)
{
    CALL(earth_flux, segments, view, flux);
}
