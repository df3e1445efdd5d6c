/* Air and light on plates: the inner loops of the module gracecg_spacecraft_surface_loads, which says what acts and where it
   is from. The loops themselves stand in plate_loads_variant.h, which is compiled for each width of vectors: plates lie
   side by side. */
#include "../base/vectors.h"
#include <math.h>

/* As in the Fortran modules */
enum { LANES = 8, MAX_PLATES = 32 };

struct plate {
    double normal[3], area, centre[3], specular, diffuse;
};

struct flow {
    double velocity[3], density, thermal_speed, leaving_speed;
};

struct light {
    double to_source[3], pressure;
};

struct plate_sums {
    double force[3], torque[3], projected_area;
};

/* The sums over the plates, by place in plate_sums */
enum { FORCE, TORQUE = 3, PROJECTED_AREA = 6, SUMS };

#define KERNEL "../spacecraft/plate_loads_variant.h"
#include "../base/every_width.h"

INTERNAL void gracecg_plates_in_air(int32_t widest, int32_t count, const struct plate *plates, const double *centre_of_mass,
                                    const struct flow *flow, struct plate_sums *sums)
{
    CALL(plates_in_air, count, plates, centre_of_mass, flow, sums);
}

INTERNAL void gracecg_plates_in_light(int32_t widest, int32_t count, const struct plate *plates, const double *centre_of_mass,
                                      const struct light *light, struct plate_sums *sums)
{
    CALL(plates_in_light, count, plates, centre_of_mass, light, sums);
}
