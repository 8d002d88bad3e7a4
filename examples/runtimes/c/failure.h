/* Refusals of the kernel as lines of text. */
#ifndef FAILURE_H
#define FAILURE_H

#include "pixels.h"

/* Fail with the line of a refusal: of a file where `path` is not NULL, of one of many pixels where `first` is not -1, the
 * number of the first of the kernel's call. Returns where nothing was refused. */
void sky_check(int32_t status, const SkyFailure *failure, const char *path, long long first);

#endif
