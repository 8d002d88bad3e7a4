/* A frame: what its pixels share. */
#ifndef SKYSHINE_FRAME_H
#define SKYSHINE_FRAME_H

#include "tables.h"

enum { CODES = 65536 };
/* Panels of the lattice of ranges: in each octave of range + NEAREST equally many of equal length, each with a cubic. */
enum { OCTAVE_BITS = 4, OCTAVES = 22, PANELS = OCTAVES << OCTAVE_BITS, CUBIC = 4 };
#define NEAREST (1.0 / 1024) /* km */

/* An axis whose cells are found by one division and few comparisons. A periodic one has its first node again at its end; one
 * of a single node has a second one, at which the same values stand. */
struct grid {
    const char *name;
    double *nodes, *per_length, first, last, scale, period;
    int32_t *cell; /* the lowest that reaches into an equal part of the axis */
    int parts, steps, count, clamps;
    int even; /* all cells are of the same length */
};

/* Of each material: what the beam becomes by (34) and by (35), without incidence and lobe. */
struct materials {
    double *diffuse, *specular, *shininess;
};

struct skyshine_frame {
    const skyshine_tables *tables;
    struct block *memory;
    double extinction, path_ratio; /* of the centre: 5.5 / beta*, and (10) */
    double source_heading, sine, cosine; /* of the source's elevation */
    double elevation, heading; /* of the centre's line */
    int32_t *in_band, *in_surface; /* index of a code; -1 where there is none */
    struct materials materials;
    struct grid altitude, azimuth, slope, kelvin, planck;
    size_t plane; /* temperatures of one material */
    double *temperature, *blackbody;
    double *emission; /* by material, panel and node of `planck`: coefficients of a cubic */
    size_t bases;
    double *sky; /* by material and basis: reflected light */
    /* Wavelengths at which light may fall below 0, where it is bounded: taken out of `sky`. */
    size_t bounded;
    double *sky_bounded, *rho_bounded;
};

#endif
