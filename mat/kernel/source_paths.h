/* Optical depth from a distant source to any point: `transfer.source_paths.SourcePaths`. */
#ifndef SKYSHINE_SOURCE_PATHS_H
#define SKYSHINE_SOURCE_PATHS_H

#include "lanes.h"
#include "scalar.h"

#define HIDDEN 1e4f

typedef struct {
    int64_t levels, nodes, points; /* N, U, P */
    double earth_radius, scale_height; /* m; the second of the shell whose air mass divides the depths of the table */
    const double *altitude;        /* N, m */
    const double *elevation;       /* N x U, rad */
    const float *log_depth;        /* N x U x padded P */
} SourcePaths;

/* A point between the levels, for sources of any elevation. */
typedef struct {
    int64_t lower;
    double share, inside, over; /* of the layer; altitude inside the air, m; ratio of radii, above 1 in space */
} Height;

/* Where in the table the ray to a source lies: the first of four corners, their weights, the logarithm of the air mass. */
typedef struct {
    int64_t corner;
    float weight[4], log_air_mass, seen, hidden; /* factor and addend of the depth: see `depth_at` */
} SourcePlace;

INLINE Height height_of(const SourcePaths *paths, double altitude) {
    Height height;
    double top = paths->altitude[paths->levels - 1];
    height.inside = altitude < top ? altitude : top;
    height.over = (paths->earth_radius + altitude) / (paths->earth_radius + height.inside);
    height.lower = last_below(paths->altitude, paths->levels - 1, height.inside);
    double bottom = paths->altitude[height.lower];
    height.share = clipped((height.inside - bottom) / (paths->altitude[height.lower + 1] - bottom), 0, 1);
    return height;
}

/* The places of rays to sources of cosines (S,) of zenith angles; `scratch` has room for three rows of padded S. */
INLINE void source_places(
    const SourcePaths *paths, const Height *height, int64_t sources, const double *cosine, double *scratch,
    SourcePlace *places
) {
    int64_t stride = padded(sources);
    double *elevation = scratch, *log_air_mass = elevation + stride, *clear = log_air_mass + stride;
    double radius = (paths->earth_radius + height->inside) / paths->scale_height;
    for (int64_t s = 0; s < sources; s++) elevation[s] = cosine[s];
    for (int64_t s = sources; s < stride; s++) elevation[s] = 0;
    for (int64_t s = 0; s < stride; s += DOUBLES) {
        VectorD sine = smaller_d(larger_d(load_d(elevation + s), all_d(-1)), all_d(1)), angle = arc_sine_d(sine);
        BitsD never = sine > all_d(2);
        if (height->over > 1) { /* moved along the ray to where it enters the air, if it does */
            VectorD ratio = height->over * root_d(1 - sine * sine);
            never = (sine >= all_d(0)) | (ratio >= all_d(1));
            ratio = smaller_d(ratio, all_d(1));
            angle = select_d(never, angle, arc_sine_d(ratio) - 0.5 * PI);
            sine = select_d(never, sine, -root_d(1 - ratio * ratio));
        }
        VectorD across = radius * sine, root = root_d(across * across + 2 * radius + 1);
        VectorD positive = (2 * radius + 1) / (root + select_d(across > all_d(0), across, all_d(0)));
        store_d(elevation + s, angle);
        store_d(log_air_mass + s, logarithm_d(select_d(across > all_d(0), positive, root - across)));
        store_d(clear + s, select_d(never, all_d(1), all_d(0)));
    }
    double share = height->share;
    const double *low = paths->elevation + height->lower * paths->nodes, *high = low + paths->nodes;
    for (int64_t s = 0; s < sources; s++) {
        SourcePlace *place = places + s;
        int64_t begin = 0, end = paths->nodes - 1;
        int is_clear = clear[s] > 0, hidden = !is_clear && elevation[s] < low[0] * (1 - share) + high[0] * share;
        while (end - begin > 1) {
            int64_t middle = (begin + end) / 2;
            double node = low[middle] * (1 - share) + high[middle] * share;
            int is_below = node <= elevation[s];
            begin = is_below ? middle : begin;
            end = is_below ? end : middle;
        }
        double here = low[begin] * (1 - share) + high[begin] * share;
        double next = low[begin + 1] * (1 - share) + high[begin + 1] * share;
        double part = next > here ? clipped((elevation[s] - here) / (next - here), 0, 1) : 0;
        place->corner = height->lower * paths->nodes + begin;
        place->weight[0] = (float)((1 - share) * (1 - part));
        place->weight[1] = (float)((1 - share) * part);
        place->weight[2] = (float)(share * (1 - part));
        place->weight[3] = (float)(share * part);
        place->log_air_mass = (float)log_air_mass[s];
        place->seen = is_clear ? 0 : 1;
        place->hidden = hidden ? HIDDEN : 0;
    }
}

/* Optical depth at all points, HIDDEN or more where the Earth hides the source: (padded P). */
INLINE void depth_at(const SourcePaths *paths, const SourcePlace *place, float *depth) {
    int64_t stride = padded(paths->points);
    const float *corner = paths->log_depth + place->corner * stride, *above = corner + paths->nodes * stride;
    for (int64_t p = 0; p < stride; p += LANES) {
        VectorF log_depth = load_f(corner + p) * place->weight[0] + load_f(corner + stride + p) * place->weight[1];
        log_depth += load_f(above + p) * place->weight[2] + load_f(above + stride + p) * place->weight[3];
        store_f(depth + p, exp_f(log_depth + place->log_air_mass) * place->seen + place->hidden);
    }
}

#endif
