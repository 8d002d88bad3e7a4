/* An atmosphere in channels (format 3): its quantities, computed from tables that have no axis of range. */
#ifndef CHANNELS_H
#define CHANNELS_H

#include "database.h"

/* A quantity of format 2 at a place, as `value_at`; the last value for path radiance is the scattering angle. */
double sky_value_in_channels(const struct database *database, const char *name, const double *where);

/* Light on surfaces at a place, one value for each wavelength of the band. */
void sky_light_in_channels(const struct database *database, const char *name, const double *where, double *to);

/* Extinction per km of emitted light at each wavelength, a mean over the range of the place. */
void sky_extinction_in_channels(const struct database *database, const double *where, double *to);

#endif
