/*
 * gracecg_level1.h - the C interface of gracecg's second library: Level-1 files of GRACE and GRACE-FO, and the
 * centre-of-gravity offset from them. The conventions are those of gracecg.h.
 */
#ifndef GRACECG_LEVEL1_H
#define GRACECG_LEVEL1_H

#include "gracecg.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The records of a Level-1 file in order of time, each epoch once. */
typedef struct gracecg_level1 gracecg_level1;

/* Reads a file, text or binary, of any product that `gracecg level1 list` knows. span or NULL: first and last
   time tag that are wanted, in s past 2000-01-01 12:00:00 in the file's own time frame. */
gracecg_status gracecg_level1_read(const char *path, const double span[2], gracecg_level1 **level1,
                                   gracecg_error *error);
gracecg_status gracecg_level1_free(gracecg_level1 **level1, gracecg_error *error);

/* How many records, fields and warnings there are; each or NULL. */
gracecg_status gracecg_level1_counts(const gracecg_level1 *level1, size_t *records, size_t *fields,
                                     size_t *warnings, gracecg_error *error);

/* Product, satellite and time frame (R: on-board computer or receiver, G: GPS; none where records do not say),
   as "MAG1A C R". */
gracecg_status gracecg_level1_about(const gracecg_level1 *level1, char *text, size_t size, size_t *length,
                                    gracecg_error *error);

/* The name of field 0 <= index < fields, and what is unusual about the file, 0 <= index < warnings. */
gracecg_status gracecg_level1_field(const gracecg_level1 *level1, size_t index, char *text, size_t size,
                                    size_t *length, gracecg_error *error);
gracecg_status gracecg_level1_warning(const gracecg_level1 *level1, size_t index, char *text, size_t size,
                                      size_t *length, gracecg_error *error);

/* Time tags [records]: whole seconds past 2000-01-01 12:00:00, and the rest, 0 <= fraction < 1 s; each or NULL.
   capacity is the length of the arrays. */
gracecg_status gracecg_level1_times(const gracecg_level1 *level1, size_t capacity, double *seconds,
                                    double *fraction, gracecg_error *error);

/* The values [records] of a field, in the units of the file: integers and flags are exact, letters their codes.
   A value that a record has not is NaN. */
gracecg_status gracecg_level1_values(const gracecg_level1 *level1, const char *field, size_t capacity,
                                     double *values, gracecg_error *error);

/* The offset of a calibration manoeuvre from the Level-1 files in a folder. */
typedef struct gracecg_level1_offset {
    double offset[3];           /* from the centre of mass to the proof mass, SRF, m */
    double covariance[3][3];    /* m^2: noise, leakage of the rods, and what is known of scales, gains, field */
    double time;                /* middle of the manoeuvre, GPS s past 2000-01-01 12:00:00 */
    double gain[3];             /* of the rods by the attitude, A m^2/mA */
    double gain_sigma[3];       /* A m^2/mA */
    double torque_delay;        /* of the torque behind the tags of its current, s */
    double torque_delay_sigma;  /* s */
    double accelerometer_delay; /* of the samples behind their tags, s */
    double accelerometer_delay_sigma;   /* s; 0: not estimated */
    double condition;           /* of the scaled normal matrix with leakage, without a-priori sigma */
    double residual_rms[3];     /* in the band of the estimate, m/s^2 */
    double chi_square;          /* of the spans about the offset */
    int32_t degrees;            /* of freedom of chi_square; 0 with one span */
    int32_t spans;              /* that are used */
    int32_t samples;            /* of the accelerometer, that are used */
    int32_t leakage;            /* 0: left out, 1: by its a-priori sigma (not separable), 2: estimated */
    int32_t flag;               /* 0: good, 1: to be used with care, 2: not to be used */
    int32_t reserved;           /* 0 */
} gracecg_level1_offset;

/* Estimates the offset as `gracecg level1 estimate` does. setup: path of a namelist with mass_properties and level1.
   satellite: "A" to "D", or NULL: the only one, or the first, that has files. spans [n_spans][2]: start (GPS s past
   2000-01-01 12:00:00) and duration (s) of sub-manoeuvres; n_spans = 0 and NULL: those of the SOE file in the folder, or
   by the currents. source: "torque+cal", "torque", "acc-cal", "acc-raw", "sca", "imu", or NULL: torque+cal. text or
   NULL: why the flag is not 0, then what is wrong, a line each. */
gracecg_status gracecg_estimate_level1(const char *folder, const char *setup, const char *satellite, size_t n_spans,
                                       const double *spans, const char *source, gracecg_level1_offset *offset,
                                       char *text, size_t size, size_t *length, gracecg_error *error);

/* The same of one manoeuvre of several in the folder (`--day`): that which a day, as "2020-02-01", has part of, with the
   days before and behind it. NULL: of all files. */
gracecg_status gracecg_estimate_level1_day(const char *folder, const char *setup, const char *satellite,
                                           const char *day, size_t n_spans, const double *spans, const char *source,
                                           gracecg_level1_offset *offset, char *text, size_t size, size_t *length,
                                           gracecg_error *error);

#ifdef __cplusplus
}
#endif

#endif /* GRACECG_LEVEL1_H */
