/* Temperatures in the shade, beside a wall or under other heat: the formulas of schemas/formats/htt-1.md. */
#ifndef SKYSHINE_SHADE_H
#define SKYSHINE_SHADE_H

#include "export.h"
#include "pixel_tables.h"

/* Bytes of the scratch of the functions of `shade.c`. */
size_t SKYSHINE_NAME(skyshine_shade_scratch)(const SkyTables *tables);

/* Temperature of a face in the shade all day, under an open share of the sky; `face` has material, altitude, azimuth,
 * slope and time. */
int32_t SKYSHINE_NAME(skyshine_shaded)(const SkyTables *tables, const double *face, double sky_view, size_t row, double *kelvin,
                                       void *scratch, SkyFailure *failure);

#endif
