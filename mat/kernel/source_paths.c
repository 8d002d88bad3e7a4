#include "source_paths.h"
#include "export.h"

/* Optical depth (K, S, P) to sources of cosines (K, S) of zenith angles at altitudes (K,) [m]; `row` has room for padded
 * P numbers, `scratch` for three rows of padded S and S places. */
SKYSHINE_EXPORT void SKYSHINE_NAME(source_depth)(
    const SourcePaths *paths, int64_t points, int64_t sources, const double *altitude, const double *cosine, float *row,
    double *scratch, float *depth
) {
    SourcePlace *places = (SourcePlace *)(scratch + 3 * padded(sources));
    for (int64_t k = 0; k < points; k++) {
        Height height = height_of(paths, altitude[k]);
        source_places(paths, &height, sources, cosine + k * sources, scratch, places);
        for (int64_t s = 0; s < sources; s++) {
            depth_at(paths, places + s, row);
            for (int64_t p = 0; p < paths->points; p++) *depth++ = row[p];
        }
    }
}
