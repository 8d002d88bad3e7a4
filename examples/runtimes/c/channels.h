/* An atmosphere in channels (format 3): its quantities, computed from tables that have no axis of range. */
#ifndef CHANNELS_H
#define CHANNELS_H

#include "database.h"

/* A quantity of format 2 at a place, as `value_at`; the last value for path radiance is the scattering angle. */
double value_in_channels(const struct database *database, const char *name, const double *where);

#endif
