/* The tables of a state, a band and a source, and the radiance of a pixel from them. */
#ifndef SKYSHINE_TABLES_H
#define SKYSHINE_TABLES_H

#include "database.h"

struct skyshine_tables {
    struct database surface, band, air;
    int32_t *codes;       /* of the materials of the band */
    struct block *memory;
};

/* Functions of a direction whose weighted sum is the light on a face: the first for the light that no harmonic holds, then
 * the harmonics. */
enum { BASES = 1 + HARMONICS };

/* L_ambient as weights of the bases, BASES rows of `parts` values (one for each wavelength, or one for the whole band): of a
 * face in any direction, or of a level one in every direction. `place` is a line and its source; `ground` the temperature of
 * the ground and what it emits. Returns how many bases have weights. */
size_t sky_ambient_weights(const struct database *air, const double *place, int tilted, const double *ground, size_t parts, double *to);

/* The bases at a unit normal in the frame of the source's azimuth. */
void sky_bases(const struct database *air, const double *normal, double *to);

/* Temperature and emitted radiance of the ground: of a material, or as the file states it where that is 0. */
void sky_ground_of(const skyshine_tables *tables, int32_t material, double altitude, double time, double *ground);

/* The last value of `place` is the azimuth of the source; returns the path radiance ratio there. */
double sky_path_ratio_at(const struct database *air, const double *place);

#endif
