/* An atmosphere in channels (format 3): its quantities, computed from tables that have no axis of range. */
#ifndef CHANNELS_H
#define CHANNELS_H

#include "database.h"

/* A quantity of format 2 at a place, as `value_at`; the last value for path radiance is the scattering angle. */
double value_in_channels(const struct database *database, const char *name, const double *where);

/* Light on surfaces at a place, one value for each wavelength of the band. */
void light_in_channels(const struct database *database, const char *name, const double *where, double *to);

/* Transmittance of emitted light at each wavelength over the range `reach`, from that over the range of the place, as
 * (8) and (9) have it from beta*. */
void transmittance_in_channels(const struct database *database, const double *where, double reach, double *to);

#endif
