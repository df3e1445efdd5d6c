/*
 * gracecg.h - the C interface of gracecg: models of a GRACE-type satellite's environment and forces,
 * propagation, simulation of a centre-of-gravity calibration, its estimation, the least error that an
 * estimate can have, and the planner of the manoeuvre.
 *
 * Conventions, for every function:
 *
 * - It returns a gracecg_status: GRACECG_OK (0) or what kind of thing went wrong. The last argument,
 *   `error`, receives status and message; it belongs to the caller, one for each thread, and may be
 *   NULL. Messages are complete sentences that name value, allowed range and remedy.
 *   After a failure the results are not to be used; handles are then NULL.
 * - Handles are opaque. What ..._open, ..._create, ..._read, ..._parse and the like make must be given
 *   back with ..._free, which sets the handle to NULL; NULL may be freed. A handle that was freed or
 *   is of another kind is recognised and refused (GRACECG_BAD_HANDLE): it is a number in disguise, and
 *   nothing is read through it.
 * - Every object is constant once it is made: any number of threads may use it at once. Functions keep
 *   no state between calls. ..._free waits for calls that still use the object in other threads.
 * - Numbers are SI (m, s, kg, T, rad, W). Arrays are rows of one epoch or point each: n positions are
 *   double[n][3], given as a pointer to the first number. n = 0 does nothing.
 *   NaN and infinities are refused (GRACECG_BAD_VALUE) wherever they come in or would come out.
 * - Output arrays marked "or NULL" are left out when NULL; every other pointer must not be NULL
 *   (GRACECG_NULL_POINTER).
 * - Texts are UTF-8 or Latin, end with a zero, and are at most 4095 bytes long (names, paths); texts of
 *   settings may have 1 MB.
 * - Nothing prints and nothing ends the process.
 *
 * Frames:
 * - inertial: mean equator and equinox of J2000, origin at the Earth's centre. Precession, nutation and
 *   polar motion are left out: the Earth turns about the inertial z axis.
 * - Earth-fixed: turned from the inertial one by the Greenwich sidereal angle about z.
 * - body: axes of the satellite, x along it, y across, z towards the Earth in nominal flight.
 * - Quaternions turn inertial into body axes and have their scalar part last.
 */
#ifndef GRACECG_H
#define GRACECG_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------ status and errors */

/* Size of the message of a gracecg_error in bytes, the closing zero included. */
#define GRACECG_MESSAGE_SIZE 1020

typedef enum gracecg_status {
    GRACECG_OK = 0,
    GRACECG_NULL_POINTER = 1,   /* an argument that is needed is NULL */
    GRACECG_BAD_HANDLE = 2,     /* a handle that was never made, was freed, or is of another kind */
    GRACECG_BAD_SIZE = 3,       /* a count is too great, or an array too short for the result */
    GRACECG_BAD_VALUE = 4,      /* a number is not finite or outside its range; a text is too long */
    GRACECG_FAILED = 5,         /* the work failed (unknown name, file, settings, data): see message */
    GRACECG_NOT_CONVERGED = 6,  /* an estimate did not converge; the solution is filled nevertheless */
    GRACECG_NO_MEMORY = 7,      /* memory ran out, or too many objects are alive */
    GRACECG_STATUS_SIZE_ = 0x7fffffff   /* not a status: makes the type 32 bits wide */
} gracecg_status;

/* What went wrong; the caller's own. A message that is too long is cut off and ends with "...". */
typedef struct gracecg_error {
    int32_t status;                         /* a gracecg_status */
    char message[GRACECG_MESSAGE_SIZE];     /* empty after success */
} gracecg_error;

/* The version, like "0.1.0". A constant text: never free it. */
const char *gracecg_version(void);

/* A status as a few words. A constant text; "unknown status" for a number that is none. */
const char *gracecg_status_text(gracecg_status status);

/* Names of the estimators and of the built-in cases, 0 <= index < count; NULL outside. Constant texts. */
int32_t gracecg_algorithm_count(void);
const char *gracecg_algorithm_name(int32_t index);
int32_t gracecg_case_count(void);
const char *gracecg_case_name(int32_t index);

/* ------------------------------------------------------------------ time */

/* An instant of UTC: the modified Julian day number, and the seconds of that day. From 1900 to 2100. */
typedef struct gracecg_utc {
    int32_t mjd;
    double seconds;     /* 0 <= seconds < 86400, in a day that ends with a leap second < 86401 */
} gracecg_utc;

/* Reads ISO 8601: "1989-01-02T00:00:00.5" or "1989-01-02". */
gracecg_status gracecg_utc_parse(const char *text, gracecg_utc *utc, gracecg_error *error);

/* SI seconds later (or, negative, earlier), leap seconds counted. */
gracecg_status gracecg_utc_add(const gracecg_utc *utc, double seconds, gracecg_utc *later,
                               gracecg_error *error);

/* SI seconds from start to finish, leap seconds counted. */
gracecg_status gracecg_utc_difference(const gracecg_utc *start, const gracecg_utc *finish,
                                      double *seconds, gracecg_error *error);

/* Greenwich mean sidereal time (IAU 1982), rad, 0 <= angle < 2 pi. ut1_minus_utc: s, at most 1 in size. */
gracecg_status gracecg_sidereal_angle(const gracecg_utc *utc, double ut1_minus_utc, double *angle,
                                      gracecg_error *error);

/* Inertial vectors [n][3] into Earth-fixed ones, by the sidereal angle (rad); with the negative angle
   the way back. In and out may be the same array. */
gracecg_status gracecg_earth_fixed(double sidereal_angle, size_t n, const double *inertial,
                                   double *fixed, gracecg_error *error);

/* UT1-UTC (s) and x and y of the pole (rad) at a time, each or NULL, from a file of the IERS as it is published:
   finals2000A or EOP C04. */
gracecg_status gracecg_earth_parameters(const char *path, const gracecg_utc *utc, double *ut1_minus_utc,
                                        double pole[2], gracecg_error *error);

/* The rotation from inertial (GCRS) to Earth-fixed axes, fixed = rotation * inertial, `seconds` after a time at which
   its constants are computed, at most ten days; rotation [3][3]: precession IAU 2006, nutation IAU 2000B. pole or NULL:
   x and y, rad. */
gracecg_status gracecg_earth_orientation(const gracecg_utc *utc, double ut1_minus_utc, const double pole[2],
                                         double seconds, double *rotation, gracecg_error *error);

/* ------------------------------------------------------------------ gravity */

typedef struct gracecg_gravity gracecg_gravity;

/* "egm96" (to degree 70), "point-mass" (degree and order 0), or the path of an ICGEM .gfc file. */
gracecg_status gracecg_gravity_open(const char *name_or_file, int32_t degree, int32_t order,
                                    gracecg_gravity **gravity, gracecg_error *error);
gracecg_status gracecg_gravity_free(gracecg_gravity **gravity, gracecg_error *error);

/* Of Earth-fixed positions [n][3] (m, at least 1 km from the centre): acceleration [n][3] (m/s^2,
   Earth-fixed, without the centrifugal part), potential [n] (m^2/s^2), and the second derivatives of
   the potential [n][3][3] (1/s^2, symmetric), each or NULL. All three come from one recursion; without
   second derivatives many points in a call take half the time each. */
gracecg_status gracecg_gravity_evaluate(const gracecg_gravity *gravity, size_t n, const double *position,
                                        double *acceleration, double *potential, double *gradient,
                                        gracecg_error *error);

/* ------------------------------------------------------------------ geomagnetic field */

typedef struct gracecg_field gracecg_field;

/* "igrf95" (1985 to 2000), "igrf14" (1900 to 2030), or the path of an SHC file, at a date. */
gracecg_status gracecg_field_open(const char *name_or_file, const gracecg_utc *date,
                                  gracecg_field **field, gracecg_error *error);
gracecg_status gracecg_field_free(gracecg_field **field, gracecg_error *error);

/* Flux density [n][3] (T, Earth-fixed) at Earth-fixed positions [n][3] (m, at least 1 km from the
   centre). */
gracecg_status gracecg_field_evaluate(const gracecg_field *field, size_t n, const double *position,
                                      double *flux_density, gracecg_error *error);

/* ------------------------------------------------------------------ thermosphere: density and wind */

typedef struct gracecg_density gracecg_density;

/* DTM-77 with the solar flux and Kp of a date, from the embedded table (December 1988 to February
   1989, and 2000). They stay those of the date, whatever the time of evaluation. */
gracecg_status gracecg_density_open(const gracecg_utc *date, gracecg_density **density,
                                    gracecg_error *error);

/* DTM-77 with given indices: F10.7 of the day before and its 81-day mean (sfu, 50 to 500), Kp three
   hours before (0 to 9). */
gracecg_status gracecg_density_open_indices(double f107, double f107_mean, double kp,
                                            gracecg_density **density, gracecg_error *error);

/* The same for a model by name: "dtm77", "dtm78" (as CNES has it), "dtm94", or "exponential" (4e-12 kg/m^3 at
   466 km, scale height 65 km). */
gracecg_status gracecg_density_open_model(const char *name, const gracecg_utc *date,
                                          gracecg_density **density, gracecg_error *error);
gracecg_status gracecg_density_open_model_indices(const char *name, double f107, double f107_mean,
                                                  double kp, gracecg_density **density,
                                                  gracecg_error *error);
gracecg_status gracecg_density_free(gracecg_density **density, gracecg_error *error);

/* Density [n] (kg/m^3) and, each or NULL, temperature [n] (K) and number densities of He, O and N2
   [n][3] (1/m^3) at Earth-fixed positions [n][3] (m), `seconds`[n] after `epoch`. Refuses heights
   below 120 km (DTM). */
gracecg_status gracecg_density_evaluate(const gracecg_density *density, const gracecg_utc *epoch,
                                        size_t n, const double *seconds, const double *position,
                                        double *mass_density, double *temperature,
                                        double *number_density, gracecg_error *error);

typedef struct gracecg_wind gracecg_wind;

/* "hwm93" (the embedded table: 1989-01-02 0 h UT, 466 km) or the path of a table of one's own. */
gracecg_status gracecg_wind_open(const char *name_or_file, gracecg_wind **wind, gracecg_error *error);
gracecg_status gracecg_wind_free(gracecg_wind **wind, gracecg_error *error);

/* Eastward and northward wind [n][2] (m/s, relative to the turning Earth) at Earth-fixed positions
   [n][3] (m), `seconds`[n] after `epoch`. */
gracecg_status gracecg_wind_evaluate(const gracecg_wind *wind, const gracecg_utc *epoch, size_t n,
                                     const double *seconds, const double *position, double *east_north,
                                     gracecg_error *error);

/* ------------------------------------------------------------------ Sun and Earth radiation */

/* The Sun [n][3] (m, inertial, from the Earth's centre, geometric) `seconds`[n] after `epoch`. */
gracecg_status gracecg_sun_position(const gracecg_utc *epoch, size_t n, const double *seconds,
                                    double *position, gracecg_error *error);

/* The part [n] of the Sun's disc, 0 to 1, that the Earth leaves free, for satellite and Sun [n][3]
   each (m, the same axes). */
gracecg_status gracecg_sun_illumination(size_t n, const double *position, const double *sun,
                                        double *illumination, gracecg_error *error);

typedef struct gracecg_earth_radiation gracecg_earth_radiation;

/* Knocke's model. constants: "report", "knocke" or "constant-emissivity"; rings of segments around the
   cap, 0 to 7; solar irradiance at 1 au in W/m^2 (1 to 10^4; 1367 is usual). */
gracecg_status gracecg_earth_radiation_open(const char *constants, int32_t rings, double solar_irradiance,
                                            gracecg_earth_radiation **model, gracecg_error *error);
gracecg_status gracecg_earth_radiation_free(gracecg_earth_radiation **model, gracecg_error *error);

/* Net flux [n][3] (W/m^2, inertial, away from the Earth) at inertial positions [n][3] (m, outside the
   Earth), `seconds`[n] after `epoch`: the sum of irradiance times direction over the segments. */
gracecg_status gracecg_earth_radiation_flux(const gracecg_earth_radiation *model,
                                            const gracecg_utc *epoch, size_t n, const double *seconds,
                                            const double *position, double *flux, gracecg_error *error);

/* The same by segments, at one position: `count` receives their number (1 + 3 rings (rings + 1)),
   `irradiance`[capacity] W/m^2 on a surface that faces the segment, `direction`[capacity][3] unit
   vectors from the segments to the satellite, inertial. GRACECG_BAD_SIZE when capacity < count. */
gracecg_status gracecg_earth_radiation_segments(const gracecg_earth_radiation *model,
                                                const gracecg_utc *epoch, double seconds,
                                                const double position[3], size_t capacity, size_t *count,
                                                double *irradiance, double *direction,
                                                gracecg_error *error);

/* ------------------------------------------------------------------ loads on a satellite's surface */

typedef struct gracecg_surface gracecg_surface;

/* The trapezoidal prism of GRACE (m): x along `length`, z to the wide bottom that faces the Earth.
   specular, diffuse: reflected parts of the light, for the plate by plate loads. */
gracecg_status gracecg_surface_trapezoid(double length, double height, double width_bottom,
                                         double width_top, double specular, double diffuse,
                                         gracecg_surface **surface, gracecg_error *error);

/* A closed convex body of n plates, 1 to 32: outward unit normals [n][3], areas [n] (m^2), centres
   [n][3] (m, from any origin), specular and diffuse reflectivities [n]; body axes. */
gracecg_status gracecg_surface_create(size_t n, const double *normal, const double *area,
                                      const double *centre, const double *specular,
                                      const double *diffuse, gracecg_surface **surface,
                                      gracecg_error *error);
gracecg_status gracecg_surface_free(gracecg_surface **surface, gracecg_error *error);

/* Cross-section (m^2) seen from a direction (unit vector towards the observer, body axes). */
gracecg_status gracecg_surface_area(const gracecg_surface *surface, const double direction[3],
                                    double *area, gracecg_error *error);

/* Drag (m/s^2, body axes) with one coefficient: mass (kg), density (kg/m^3), velocity relative to the
   air (m/s, body axes). */
gracecg_status gracecg_surface_drag(const gracecg_surface *surface, double mass, double drag_coefficient,
                                    double density, const double velocity[3], double acceleration[3],
                                    gracecg_error *error);

/* Sunlight's pressure (m/s^2, body axes) with one reflectivity: irradiance at 1 au (W/m^2),
   illumination 0 to 1, vector from the satellite to the Sun (m, body axes). */
gracecg_status gracecg_surface_sunlight(const gracecg_surface *surface, double mass, double reflectivity,
                                        double solar_irradiance, double illumination,
                                        const double to_sun[3], double acceleration[3],
                                        gracecg_error *error);

/* The Earth's light (m/s^2, body axes) with one reflectivity and the cross-section towards the Earth:
   net flux of gracecg_earth_radiation_flux and position (m), both inertial; attitude. */
gracecg_status gracecg_surface_earthlight(const gracecg_surface *surface, double mass,
                                          double reflectivity, const double flux[3],
                                          const double position[3], const double quaternion[4],
                                          double acceleration[3], gracecg_error *error);

/* Air in free-molecular flow, plate by plate: force (N) and torque (N m) about the centre of mass (m, in
   the frame of the plates' centres), body axes. Air: density (kg/m^3), temperature (K), number densities
   of He, O, N2 (any unit); wall temperature (K) and energy accommodation, 0 to 1. */
gracecg_status gracecg_surface_aerodynamic_load(const gracecg_surface *surface,
                                                const double centre_of_mass[3], double density,
                                                double temperature, const double number_density[3],
                                                double wall_temperature, double accommodation,
                                                const double velocity[3], double force[3],
                                                double torque[3], gracecg_error *error);

/* Sunlight, plate by plate: force (N) and torque (N m) about the centre of mass, body axes. */
gracecg_status gracecg_surface_sunlight_load(const gracecg_surface *surface,
                                             const double centre_of_mass[3], double solar_irradiance,
                                             double illumination, const double to_sun[3],
                                             double force[3], double torque[3], gracecg_error *error);

/* ------------------------------------------------------------------ cases */

/* A calibration case: satellite, orbit, models, instruments and manoeuvre. */
typedef struct gracecg_case gracecg_case;

/* A built-in case by name, or a case file (namelist) by path. */
gracecg_status gracecg_case_open(const char *name_or_file, gracecg_case **the_case, gracecg_error *error);

/* A case from the text of a case file. */
gracecg_status gracecg_case_parse(const char *text, gracecg_case **the_case, gracecg_error *error);
gracecg_status gracecg_case_free(gracecg_case **the_case, gracecg_error *error);

/* The case file's text, with every setting, its unit and meaning. `length` (or NULL) receives the bytes
   needed without the closing zero; GRACECG_BAD_SIZE when text[size] is too short. size = 0 with
   text = NULL asks for the length alone. */
gracecg_status gracecg_case_text(const gracecg_case *the_case, char *text, size_t size, size_t *length,
                                 gracecg_error *error);

/* Each or NULL: epoch (time 0), duration and interval of the true arc (s), initial state (position m,
   velocity m/s, inertial; angular velocity rad/s, body; quaternion), true offset d from the centre of
   mass to the proof mass (m, body). */
gracecg_status gracecg_case_values(const gracecg_case *the_case, gracecg_utc *epoch, double *duration,
                                   double *interval, double state[13], double offset[3],
                                   gracecg_error *error);

/* ------------------------------------------------------------------ force model and propagation */

/* One satellite with all its models, built from a case; times are seconds from the case's epoch. */
typedef struct gracecg_force_model gracecg_force_model;

gracecg_status gracecg_force_model_open(const gracecg_case *the_case, gracecg_force_model **model,
                                        gracecg_error *error);
gracecg_status gracecg_force_model_free(gracecg_force_model **model, gracecg_error *error);

/* The epoch of a force model and its Greenwich sidereal angle then (rad), each or NULL; it grows by
   7.292115e-5 rad/s. Of a case with earth_orientation = 'iau' it is the Earth rotation angle, which alone does not
   lead to Earth-fixed axes: see gracecg_force_model_orientation. */
gracecg_status gracecg_force_model_epoch(const gracecg_force_model *model, gracecg_utc *epoch,
                                         double *sidereal_angle, gracecg_error *error);

/* The rotation [3][3] from inertial to Earth-fixed axes, fixed = rotation * inertial, that a force model has `seconds`
   from its epoch. */
gracecg_status gracecg_force_model_orientation(const gracecg_force_model *model, double seconds,
                                               double *rotation, gracecg_error *error);

/* Accelerations [n][3] (m/s^2, inertial axes) at `seconds`[n] from the epoch, position and velocity
   [n][3] (inertial) and attitude [n][4]; each or NULL. `total` is the sum of the four. Fields,
   solar activity and leap seconds stay those of the epoch: open a new model for another day. */
gracecg_status gracecg_force_model_evaluate(const gracecg_force_model *model, size_t n,
                                            const double *seconds, const double *position,
                                            const double *velocity, const double *quaternion,
                                            double *gravity, double *drag, double *solar_radiation,
                                            double *earth_radiation, double *total,
                                            gracecg_error *error);

/* Torques (N m, body axes, about the centre of mass) of air, sunlight, gravity gradient and torque rods,
   and the magnetic flux density (T, body axes), for one state as in gracecg_case_values; each or NULL. */
gracecg_status gracecg_force_model_torques(const gracecg_force_model *model, double seconds,
                                           const double state[13], double aerodynamic[3],
                                           double solar[3], double gravity_gradient[3],
                                           double magnetic[3], double flux_density[3],
                                           gracecg_error *error);

/* The time derivative of the 13 components of the state. */
gracecg_status gracecg_force_model_rate(const gracecg_force_model *model, double seconds,
                                        const double state[13], double rate[13], gracecg_error *error);

/* Integrates orbit and attitude (Runge-Kutta-Fehlberg 7(8)) from time 0: states [steps + 1][13], the
   first one the initial state, every `interval` s (> 0). tolerance = 0: one step an interval; else steps
   under control with interpolation, by how far four steps and one of their length may differ, relative to
   1e7 m, 1e4 m/s, 1e-3 rad/s and 1 (1e-10, say). At most 10^6 intervals. Nothing controls the attitude:
   the torques turn the satellite freely, as in a calibration manoeuvre; over more than some minutes use
   gracecg_force_model_propagate_nadir. */
gracecg_status gracecg_force_model_propagate(const gracecg_force_model *model, const double state[13],
                                             double interval, size_t steps, double tolerance,
                                             double *states, gracecg_error *error);

/* Integrates the orbit of a satellite whose attitude is held: body z to the centre of the Earth, y across
   the orbit, x along the orbit (forward other than 0) or against it (0). Position (m) and velocity (m/s),
   inertial, at time 0; the rest as in gracecg_force_model_propagate. The states have the attitude and the
   angular velocity that are held. */
gracecg_status gracecg_force_model_propagate_nadir(const gracecg_force_model *model, const double position[3],
                                                   const double velocity[3], int32_t forward, double interval,
                                                   size_t steps, double tolerance, double *states,
                                                   gracecg_error *error);

/* ------------------------------------------------------------------ simulation */

/* The true arc of a case and what its star cameras see: once, for any number of runs. */
typedef struct gracecg_simulator gracecg_simulator;

gracecg_status gracecg_simulator_open(const gracecg_case *the_case, gracecg_simulator **simulator,
                                      gracecg_error *error);
gracecg_status gracecg_simulator_free(gracecg_simulator **simulator, gracecg_error *error);

/* The true arc, without the run's density wave. `count` (or NULL) receives the number of epochs; with
   capacity = 0 and no arrays that is all. Each array or NULL: times [capacity] (s), states
   [capacity][13], angular acceleration (rad/s^2), magnetic flux density (T) and non-gravitational
   acceleration (m/s^2) [capacity][3] in body axes. GRACECG_BAD_SIZE when capacity < count. */
gracecg_status gracecg_simulator_truth(const gracecg_simulator *simulator, size_t capacity, size_t *count,
                                       double *seconds, double *states, double *angular_acceleration,
                                       double *flux_density, double *non_gravitational,
                                       gracecg_error *error);

/* ------------------------------------------------------------------ observations */

/* What an operator knows: satellite, manoeuvre, instruments; and beside it how to estimate. Cases, setups
   and observation sets carry options of the estimators: those of the groups &estimation, &optimal and
   &sequential of their text, and the defaults for what it does not say (gracecg_options_text). */
typedef struct gracecg_setup gracecg_setup;

/* From a file setup.nml, from such a file's text, or that of an observation set. The options are those of a
   file options.nml beside the file, else those in the file or text itself, if it is one of version 0.1. */
gracecg_status gracecg_setup_read(const char *file, gracecg_setup **setup, gracecg_error *error);
gracecg_status gracecg_setup_parse(const char *text, gracecg_setup **setup, gracecg_error *error);
gracecg_status gracecg_setup_free(gracecg_setup **setup, gracecg_error *error);

/* The text of setup.nml, followed by the options; text, size and length as in gracecg_case_text. */
gracecg_status gracecg_setup_text(const gracecg_setup *setup, char *text, size_t size, size_t *length,
                                  gracecg_error *error);

/* The same setup with measured moments of the torque rods in place of those that they were commanded to: times
   [count] in s from the epoch, rising, over the whole arc; moments [count][3] along the rods x, y, z in A m^2.
   They have the rods' gain and delay in them. */
gracecg_status gracecg_setup_measured(const gracecg_setup *setup, size_t count, const double *time,
                                      const double *moment, gracecg_setup **measured, gracecg_error *error);

/* The samples of one calibration; times in s from the setup's epoch, rising. */
typedef struct gracecg_samples {
    size_t accelerometer_count;
    const double *accelerometer_time;
    const double *acceleration;         /* [count][3], body axes, m/s^2 */
    size_t star_camera_count;
    const double *star_camera_time;     /* rising for each head */
    const int32_t *star_camera_head;    /* 1 or 2 */
    const double *quaternion;           /* [count][4], inertial to camera, scalar last */
    size_t magnetometer_count;          /* may be 0 with an orbit: a field model stands in */
    const double *magnetometer_time;
    const double *flux_density;         /* [count][3], body axes, T */
    size_t orbit_count;                 /* may be 0 with a magnetometer */
    const double *orbit_time;
    const double *orbit_position;       /* [count][3], inertial, m */
} gracecg_samples;

/* An observation set. */
typedef struct gracecg_observations gracecg_observations;

/* From arrays in memory, which are copied and checked. */
gracecg_status gracecg_observations_create(const gracecg_setup *setup, const gracecg_samples *samples,
                                           gracecg_observations **observations, gracecg_error *error);

/* From a folder as `gracecg simulate` writes it, and into one, which is made if it is not there. The options
   stand in its file options.nml; without it they are the defaults, or those in a setup.nml of version 0.1. */
gracecg_status gracecg_observations_read(const char *folder, gracecg_observations **observations,
                                         gracecg_error *error);
gracecg_status gracecg_observations_write(const gracecg_observations *observations, const char *folder,
                                          gracecg_error *error);

/* Simulated, with the random numbers of a seed and run (>= 0): the same as `gracecg simulate` draws. */
gracecg_status gracecg_observations_simulate(const gracecg_simulator *simulator, int32_t seed,
                                             int32_t run, gracecg_observations **observations,
                                             gracecg_error *error);
gracecg_status gracecg_observations_free(gracecg_observations **observations, gracecg_error *error);

/* The setup of an observation set, as a handle of its own, to be freed. */
gracecg_status gracecg_observations_setup(const gracecg_observations *observations, gracecg_setup **setup,
                                          gracecg_error *error);

/* How many samples of accelerometer, star camera, magnetometer and orbit there are. */
gracecg_status gracecg_observations_counts(const gracecg_observations *observations, size_t counts[4],
                                           gracecg_error *error);

/* The samples of one instrument, arrays as in gracecg_samples, each or NULL, with room for `capacity`
   samples. GRACECG_BAD_SIZE when there are more. */
gracecg_status gracecg_observations_accelerometer(const gracecg_observations *observations,
                                                  size_t capacity, double *time, double *acceleration,
                                                  gracecg_error *error);
gracecg_status gracecg_observations_star_camera(const gracecg_observations *observations,
                                                size_t capacity, double *time, int32_t *head,
                                                double *quaternion, gracecg_error *error);
gracecg_status gracecg_observations_magnetometer(const gracecg_observations *observations,
                                                 size_t capacity, double *time, double *flux_density,
                                                 gracecg_error *error);
gracecg_status gracecg_observations_orbit(const gracecg_observations *observations, size_t capacity,
                                          double *time, double *position, gracecg_error *error);

/* ------------------------------------------------------------------ estimation */

/* Room for the parameters beside the offset, and for a name with its closing zero. */
/* How to estimate, as the text of a file of options: groups &estimation (first guesses, weights), &optimal
   and &sequential. `object` is a case, a setup or an observation set; text, size and length as in
   gracecg_case_text. An observation set has the options of its simulator's case, of its setup, or of the
   file options.nml in its folder. */
gracecg_status gracecg_options_text(const void *object, char *text, size_t size, size_t *length,
                                    gracecg_error *error);

/* Another object like this one, with the options of a text: what it does not say has its default. `changed`
   is the address of a handle of the object's type, cast; free it as its like. */
gracecg_status gracecg_options_replace(const void *object, const char *text, void **changed,
                                       gracecg_error *error);

#define GRACECG_MOST_PARAMETERS 16
#define GRACECG_NAME_SIZE 16

/* The result of an estimator. */
typedef struct gracecg_solution {
    double offset[3];           /* d, from the centre of mass to the proof mass, body axes, m */
    double sigma[3];            /* square roots of the diagonal of covariance, m */
    double covariance[3][3];    /* of the offset under the instruments' noise, m^2 */
    double drift[3];            /* of the non-gravitational acceleration's straight line, m/s^3 */
    double bias[3];             /* its value at the epoch, m/s^2 */
    double quaternion[4];       /* attitude at the epoch */
    double angular_velocity[3]; /* at the epoch, body axes, rad/s */
    double residual_rms[3];     /* of the accelerometer, m/s^2 */
    double condition;           /* number of the scaled normal matrix */
    /* From here to `edited`: of "optimal" and "sequential", 0 of the others */
    double variance_factor;     /* weighted squares of the residuals over their redundancy; 1 if model
                                   and noise hold */
    double noise_level[3];      /* of the accelerometer, that the estimator weighted with, m^2 s^-4/Hz */
    double noise_corner[3];     /* Hz */
    double star_camera_sigma[3];/* about camera x, y, boresight, rad */
    double parameter_value[GRACECG_MOST_PARAMETERS];    /* beside the offset: unmodelled torque, and what */
    double parameter_sigma[GRACECG_MOST_PARAMETERS];    /* group `optimal` of the options asks for; SI units */
    char parameter_name[GRACECG_MOST_PARAMETERS][GRACECG_NAME_SIZE];
    int32_t parameter_count;
    int32_t edited[2];          /* samples left out: accelerometer (by axis), star camera */
    int32_t iterations;
    int32_t converged;          /* 1 or 0 */
    int32_t warning_count;      /* what was bridged, and what casts doubt on the fit */
} gracecg_solution;

/* Estimates the offset from observations alone, by an algorithm of gracecg_algorithm_name, with the
   options of the observation set (gracecg_options_text). warnings[size] (or
   NULL with size 0) receives the warnings, each ended by a newline, cut off at the size.
   GRACECG_NOT_CONVERGED fills the solution, which is then not to be relied upon. */
gracecg_status gracecg_estimate(const char *algorithm, const gracecg_observations *observations,
                                gracecg_solution *solution, char *warnings, size_t size,
                                gracecg_error *error);

/* An estimate with all that it can tell of itself. */
typedef struct gracecg_fit gracecg_fit;

/* Estimates as gracecg_estimate does, and keeps the fit. */
gracecg_status gracecg_fit_open(const char *algorithm, const gracecg_observations *observations, gracecg_fit **fit,
                                gracecg_error *error);
gracecg_status gracecg_fit_free(gracecg_fit **fit, gracecg_error *error);

/* As gracecg_estimate gives it. */
gracecg_status gracecg_fit_solution(const gracecg_fit *fit, gracecg_solution *solution, char *warnings, size_t size,
                                    gracecg_error *error);

/* How many accelerometer samples, parameters (d_x, d_y, d_z first) and epochs of the running estimate (of
   "sequential"; 0 of the others) there are; each or NULL. */
gracecg_status gracecg_fit_counts(const gracecg_fit *fit, size_t *samples, size_t *parameters, size_t *running,
                                  gracecg_error *error);

/* Of the accelerometer samples that the fit keeps on all axes, each or NULL, with room for `capacity`: time [n] (s from
   the epoch), residual [n][3] (observed minus fitted, body axes, m/s^2), partials [n][3][3] (row: axis of the
   acceleration, column: component of the offset, 1/s^2), fitted angular acceleration [n][3] (rad/s^2). */
gracecg_status gracecg_fit_series(const gracecg_fit *fit, size_t capacity, double *time, double *residual,
                                  double *partials, double *angular_acceleration, gracecg_error *error);

/* The name of parameter 0 <= index < parameters; text, size and length as in gracecg_case_text. */
gracecg_status gracecg_fit_parameter(const gracecg_fit *fit, size_t index, char *text, size_t size, size_t *length,
                                     gracecg_error *error);

/* Each or NULL: covariance [parameters][parameters] of the parameters (SI units; capacity >= parameters), what of the
   offset's covariance comes from the noise of accelerometer x, y, z, of the star camera, and from a-priori knowledge
   [5][3][3] (m^2), and the covariance [15][15] of d, alpha, beta, omega and the attitude's small angles (0 where the
   options do not ask for it). */
gracecg_status gracecg_fit_covariance(const gracecg_fit *fit, size_t capacity, double *covariance, double *by_source,
                                      double *state_covariance, gracecg_error *error);

/* What the fit tells of model and noise; of accelerometer axes x, y, z where three are given. */
typedef struct gracecg_fit_tests {
    double torque_factor;       /* of the rods' torque that would fit the rotation best */
    double torque_sigma;        /* its standard deviation; 0: was not compared */
    double attitude_misfit;     /* RMS of the attitude's residuals, standard deviations; 0: noise not known */
    double rms[3];              /* of the residuals, m/s^2 */
    double expected_rms[3];     /* of the setup's noise, m/s^2; 0: it is not known, nor what follows */
    double ratio[3];            /* RMS of the whitened residuals: 1 if the noise is that of the setup */
    double ratio_sigma[3];      /* its standard deviation by chance */
    double probability[3];      /* that white noise has such autocorrelations (Ljung and Box) */
    double worst[3];            /* the largest residual, m/s^2 */
    double worst_time[3];       /* s */
    double peak_frequency[3];   /* where the spectrum is farthest above the expected one, Hz */
    double peak_ratio[3];       /* the quotient there */
    double bound[3];            /* sigma of d that the accelerometer allows if the rotation is known, m; 0: none */
    double information_share[3][3];     /* [axis][component]: of the information on a component of d */
    double source_share[5][3];  /* [source][component] of the variance; sources as in gracecg_fit_covariance */
    double semi_axis[3];        /* of the error ellipsoid of one sigma, longest first, m */
    double direction[3][3];     /* unit vectors along them, body axes */
} gracecg_fit_tests;

gracecg_status gracecg_fit_test(const gracecg_fit *fit, gracecg_fit_tests *tests, gracecg_error *error);

/* The offset as "sequential" had it on the way, each or NULL: time [n] (s), offset and sigma [n][3] (m). */
gracecg_status gracecg_fit_running(const gracecg_fit *fit, size_t capacity, double *time, double *offset,
                                   double *sigma, gracecg_error *error);

/* What the data say of the things that the setup states. */
typedef struct gracecg_beliefs {
    double undetected[3];       /* what a single wrong one could move each component by, unseen, and what the estimate
                                   differs from that of "optimal" by, m */
    double apart[3];            /* the latter alone, m */
    int32_t tested;             /* how many */
    int32_t contradicted;
    int32_t untested;           /* too weakly: they could move a component farther than is wanted */
    int32_t sign_known;         /* 1: the setup says that the sign of the accelerometer is confirmed */
} gracecg_beliefs;

/* Estimates as gracecg_estimate does, and tells what the data say of rods, inertia, accelerometer, magnetometer, star
   camera and noise. text[size] (or NULL with size 0) receives two lines, each ended by a newline and perhaps empty:
   what is contradicted, with what would explain it, and what cannot be tested here. */
gracecg_status gracecg_test_beliefs(const char *algorithm, const gracecg_observations *observations,
                                    gracecg_beliefs *beliefs, char *text, size_t size, gracecg_error *error);

/* One offset from several observation sets, by the algorithm optimal with the options of each; scale factors, rod gain,
   magnetometer bias and inertia are one for all. */
typedef struct gracecg_joint {
    double offset[3];           /* of the time of the last run, body axes, m */
    double covariance[3][3];    /* m^2 */
    double chi_square;          /* of all differences between the runs */
    double probability;         /* that chance makes so much */
    int32_t degrees;            /* of freedom of chi_square */
    int32_t consistent;         /* 1: the runs agree on one offset, 0: they do not */
} gracecg_joint;

/* observations[count] are handles. difference[count][3] and difference_sigma[count][3], each or NULL, receive each run
   alone minus all others, and its standard deviation if they agree, m. */
gracecg_status gracecg_estimate_joint(gracecg_observations **observations, size_t count, gracecg_joint *joint,
                                      double *difference, double *difference_sigma, gracecg_error *error);

/* One offset from a long observation set, cut into arcs of `arc` seconds at most (0: 60), each estimated by the algorithm
   optimal with its own attitude, bias and drag, and joined as several sets are; on `threads` threads. arcs and joined, each
   or NULL, receive how many arcs there are, and how many are joined: the others tell no offset, or disagree. warnings[size]
   (or NULL with size 0) receives lines, each ended by a newline. */
gracecg_status gracecg_estimate_chain(const gracecg_observations *observations, double arc, int32_t threads,
                                      gracecg_joint *joint, size_t *arcs, size_t *joined, char *warnings, size_t size,
                                      gracecg_error *error);

/* ------------------------------------------------------------------ the limit of an estimate */

/* The least covariance of the offset (Cramer-Rao bound) with a case's manoeuvre and noise spectra, the
   drag a straight line in time; and what is added by what is known only within the limits of group
   `a_priori` of the case. Body axes. */
typedef struct gracecg_bound {
    double covariance[3][3];    /* m^2 */
    double sigma[3];            /* square roots of its diagonal, m */
    double principal_sigma[3];  /* square roots of its eigenvalues, ascending, m */
    double direction[3][3];     /* unit vectors along them: direction[2] is the worst */
    double consider_sigma[3];   /* with all that follows, m */
    double by_source[5][3];     /* added by scale factors, rod gain, magnetometer bias, inertia and
                                   unmodelled torque, m; 0 for what the settings estimate */
} gracecg_bound;

/* The bound of a case. */
gracecg_status gracecg_case_bound(const gracecg_case *the_case, gracecg_bound *bound, gracecg_error *error);

/* ------------------------------------------------------------------ planning the manoeuvre */

/* The moment of a torque rod from start to stop; rods of one axis add up. */
typedef struct gracecg_rod {
    double amplitude;           /* A m^2 */
    double frequency;           /* Hz */
    double phase;               /* rad */
    double start;               /* s from the case's epoch */
    double stop;                /* s */
    double taper;               /* of a smooth start and stop, s; 0: abrupt */
    double rise_time;           /* of the edges of a square wave, s */
    int32_t axis;               /* body axis 1, 2 or 3 */
    int32_t waveform;           /* 1 sine, 2 cosine, 3 tapered, 4 square */
} gracecg_rod;

/* The manoeuvre of a case. `count` (or NULL) receives the number of rods' activations; with rods = NULL
   that is all. GRACECG_BAD_SIZE when capacity < count. */
gracecg_status gracecg_case_rods(const gracecg_case *the_case, size_t capacity, size_t *count,
                                 gracecg_rod *rods, gracecg_error *error);

/* What the planner may do. */
typedef struct gracecg_design_settings {
    double start;               /* of the calibration, s from the case's epoch, within one revolution */
    double duration;            /* of the arc, 10 to 600 s */
    double amplitude;           /* of each rod, A m^2, at most 30 */
    double lowest_frequency;    /* Hz */
    double highest_frequency;   /* Hz */
    double taper;               /* of tapered waveforms, s */
    double rise_time;           /* of square waves, s */
    double rate_limit;          /* of the angular velocity, rad/s */
    double pointing_limit;      /* of the turn away from the nominal attitude, rad */
    int32_t rod_used[3];        /* along body x, y, z: 1 or 0 */
    int32_t waveform_used[4];   /* sine, cosine, tapered, square: 1 or 0 */
    int32_t threads;            /* 1 to 1024; the result does not depend on it */
} gracecg_design_settings;

/* A designed manoeuvre: errors of the offset in m, body axes. */
typedef struct gracecg_design {
    double sigma[3];            /* the limit under the accelerometer's noise */
    double wave[3];             /* RMS error by the density wave */
    double force[3];            /* error by drag and radiation that are not a straight line in time */
    double worst;               /* greatest sqrt(sigma^2 + wave^2 + force^2) of the axes */
    double rate;                /* greatest angular velocity, rad/s */
    double excursion;           /* greatest turn away from the nominal attitude, rad */
    int32_t evaluations;        /* of manoeuvres during the search */
    int32_t reserved;           /* 0 */
} gracecg_design;

/* The settings of `gracecg design` for a case: its duration and limits, 30 A m^2, 0.05 to 0.2 Hz. */
gracecg_status gracecg_design_defaults(const gracecg_case *the_case, gracecg_design_settings *settings,
                                       gracecg_error *error);

/* Searches the manoeuvre with the best worst axis for a case's satellite at one place of its orbit; takes
   seconds. `planned` is the case with that manoeuvre at that place, a handle of its own, to be freed. */
gracecg_status gracecg_design_manoeuvre(const gracecg_case *the_case, const gracecg_design_settings *settings,
                                        gracecg_case **planned, gracecg_design *design,
                                        gracecg_error *error);

/* The same along the orbit: `place` 1 is that of settings->start, 2 the start that is best on 1 to 150 revolutions
   (`gracecg design --anywhere`), 3 one manoeuvre for the worst axis at all places of them (`--everywhere`), that begins
   at settings->start. `start` or NULL: where `planned` begins, s from the case's epoch. */
gracecg_status gracecg_design_along(const gracecg_case *the_case, const gracecg_design_settings *settings, int32_t place,
                                    int32_t revolutions, gracecg_case **planned, gracecg_design *design, double *start,
                                    gracecg_error *error);

/* A case's manoeuvre at n places of its orbit, where a calibration starts `seconds`[n] from the epoch, at
   most 150 revolutions after it. Each or NULL: latitude (geodetic) and longitude [n] (rad); sigma [n][3], wave
   [n][3] and force [n][3] as in gracecg_design; standard deviation of the worst direction [n] and that
   direction [n][3]. Where a direction stays unseen, the standard deviations are DBL_MAX. */
gracecg_status gracecg_map(const gracecg_case *the_case, size_t n, const double *seconds, int32_t threads,
                           double *latitude, double *longitude, double *sigma, double *worst_sigma,
                           double *worst_direction, double *wave, double *force, gracecg_error *error);

#ifdef __cplusplus
}
#endif

#endif /* GRACECG_H */
