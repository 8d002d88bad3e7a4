/* A database, read and checked whole before the first pixel. */
#ifndef DATABASE_H
#define DATABASE_H

#include "call.h"

#include <hdf5.h>
#include <stddef.h>

/* Deflate packs at most 1032 bytes into one: a file that claims more does not hold it. */
enum { PACKING = 1100, SMALL = 1 << 20 };
enum { AXES = 5, ARRAYS = 40, NAME = 64 };
#define LIGHT "ambient_radiance_harmonics"
#define GLOW "ground_radiance_harmonics"

/* Codes 10 l + m of the harmonics. */
enum { HARMONICS = 11 };
extern const double SKY_HARMONIC_CODES[HARMONICS];

struct axis {
    const char *name;
    char rule[NAME];
    double *nodes, period; /* period 0 where it does not repeat */
    size_t count;
    int clamps;
    double dark_below; /* of source elevations: no light of the source is left there; NaN where the file does not say */
};

struct array {
    const char *name;
    size_t rank;
    struct axis axes[AXES];
    float *values;
};

/* What a file must hold: the names of the axes of an array, and the range of its values. */
struct layout {
    const char *name;
    const char *axes[AXES];
    double least, most;
};

/* What a file of format 3 states; lengths in km. */
struct channels {
    int present;
    double ground_km, scale_km;
    double ends[3][2]; /* of range, altitude and elevation */
    int clamps[3];     /* values beyond them are read at the ends */
};

struct database {
    const char *path;
    struct array arrays[ARRAYS];
    int tilted;            /* it has harmonics of the light around faces */
    double ground[3];      /* emissivity, temperature and emitted radiance of the ground; NaN where it does not state them */
    char ground_material[NAME]; /* of the ground; empty where it names none */
    int night;             /* it has its quantities without the source */
    int tracked;           /* it has the tracks of Sun and Moon */
    int lunar;             /* its source is the Moon */
    struct channels channels;
    size_t parted;         /* so many wavelengths of the band part its light; 0 where it is not parted */
    const char **material_names; /* as many as the axis 'material' has nodes; of a .band only */
};

/* Read a file of a type ("htt", "band" or "atmq"), or fail; `clamped` names axes whose ends hold outside. */
void sky_open_database(struct database *database, const char *path, const char *filetype, const char *const *clamped);

/* An attribute of an HDF5 object, for other readers: a text of less than NAME bytes, or one number; 0 where it is not. */
int sky_read_text(hid_t item, const char *name, char *to);
int sky_read_number(hid_t item, const char *name, double *to);

const struct array *sky_array_of(const struct database *database, const char *name);

int sky_holds(const struct database *database, const char *name);

/* Codes of the coefficients LIGHT or GLOW. */
const struct axis *sky_codes_of(const struct database *database, const char *name);

/* Degree: a table whose lowest source elevation is above says nothing of twilight. */
extern const double SKY_CIVIL_TWILIGHT;

/* Linear interpolation in every axis of an array, at one value for each. */
double sky_interpolated(const struct database *database, const char *name, const double *where);

/* A quantity of format 2 at a place, one value for each of its axes, the last of path radiance by angle where the file
 * has it so; below the lowest elevation of the source, its light fades
 * into what the air emits. */
double sky_value_at(const struct database *database, const char *name, const double *where);

/* Part the light of an atmosphere by wavelength where it and the file of the band hold what that takes; they are then of
 * one band. */
void sky_part_light(struct database *air, const struct database *band);

/* How many values `sky_light_at` and `sky_extinction_at` give: one for each wavelength, or one for the whole band. */
size_t sky_parts_of(const struct database *air);

/* Light on surfaces at a place, as `value_at`. */
void sky_light_at(const struct database *air, const char *name, const double *where, double *to);

/* Extinction per km of emitted light over the range of the place, as (8) and (9) have it; of the band where light is not
 * parted. */
void sky_extinction_at(const struct database *air, const double *where, double *to);

#endif
