/* Refusals of the kernel as lines of text. */
#include "failure.h"
#include "call.h"

#include <stdio.h>
#include <string.h>

enum { LINE = 200 };

static void describe(const SkyFailure *of, char *line)
{
    const char *name = of->name;
    switch (of->status) {
    case SKY_CODE: snprintf(line, LINE, "%s: found %g; allowed: a code of the file", name, of->found); break;
    case SKY_TWILIGHT:
        snprintf(line, LINE, "%s: found %g; allowed: %g and above, or %g and below", name, of->found, of->least, of->most);
        break;
    case SKY_DIRECTION: snprintf(line, LINE, "'%s' must be three finite numbers that are not all 0", name); break;
    case SKY_LENGTH: snprintf(line, LINE, "%s: found %g; allowed: finite numbers from 0", name, of->found); break;
    case SKY_NO_MATERIAL: snprintf(line, LINE, "the pixel has no material"); break;
    case SKY_NO_RESPONSE: snprintf(line, LINE, "the surface file has no response to shade"); break;
    case SKY_NOT_FINITE:
        snprintf(line, LINE, strcmp(name, "surroundings") ? "%s must be a list of finite numbers" : "%s must be finite numbers", name);
        break;
    case SKY_LACKS: snprintf(line, LINE, "lacks '%s'", name); break;
    case SKY_NODES: snprintf(line, LINE, "the axis '%s' has nodes, a rule or a period that are not those of the format", name); break;
    case SKY_SUM: snprintf(line, LINE, "'%s' sums to %g; allowed: 1", name, of->found); break;
    case SKY_BANDS:
        snprintf(line, LINE, "has %g wavelengths from %g to %g um; allowed: those of the air", of->found, of->least, of->most);
        break;
    case SKY_VALUES:
    case SKY_NUMBER: snprintf(line, LINE, "'%s' holds %g; allowed: %g to %g", name, of->found, of->least, of->most); break;
    default: snprintf(line, LINE, "%s: found %g; allowed: %g to %g", name, of->found, of->least, of->most);
    }
}

void sky_check(int32_t status, const SkyFailure *failure, const char *path, long long first)
{
    char line[LINE];
    if (!status) return;
    describe(failure, line);
    if (path) sky_fail("%s: %s", path, line);
    if (first >= 0) sky_fail("pixel %lld: %s", first + (long long)failure->row, line);
    sky_fail("%s", line);
}
