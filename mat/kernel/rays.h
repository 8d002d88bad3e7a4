/* Segments of joined lines of sight, as `transfer.segments.Segments` holds them, and where the parts of a field of
 * scattered light are that they look up. */
#ifndef SKYSHINE_RAYS_H
#define SKYSHINE_RAYS_H

#include "lanes.h"
#include "scalar.h"

/* Air counts in units of this many molecules m^-2, a power of 2, cross sections in its inverse: both are then inside the
 * range of single precision. */
#define UNIT_OF_AIR 9671406556917033397649408.0

typedef struct {
    int64_t lines, segments;  /* L, K: a segment without air lies between two lines */
    const int64_t *first;     /* L: first segment end of each line */
    const int64_t *layer;     /* K */
    const double *lower;      /* K: air that counts with the lower level of the layer, molecules m^-2 */
    const double *upper;      /* K */
    const double *altitude;   /* K + 1: of the segment ends, m */
    const double *rise;       /* K: cosine of the angle from the vertical at which light travels to the observer */
} Rays;

/* `node_cubics.NodeCubics`. */
typedef struct {
    int64_t nodes, width;
    const double *node;
    const int64_t *first;
    const double *coefficient; /* nodes x width x 4 */
} Cubics;

/* `layer_parts.LayerParts`. */
typedef struct {
    int64_t pairs;         /* J */
    const int64_t *count;  /* N - 1 */
    const double *edge;    /* J + 1 */
    const int64_t *place;  /* J x 3 */
    const double *share;   /* J x 3 */
} Parts;

/* A field of scattered light by functions of direction, and light scattered straight forward by directions. */
typedef struct {
    int64_t levels, points, moments, azimuthal; /* N, P, L, M; B functions: degrees m to L - 1 of each moment m */
    const double *altitude;                     /* N */
    Parts parts;
    int64_t directions, above;                  /* X, and how many of them rise */
    Cubics direction;
} Layers;

INLINE int64_t line_end(const Rays *rays, int64_t line) { /* one past the line's last segment end */
    return line + 1 < rays->lines ? rays->first[line + 1] : rays->segments + 1;
}

/* Weights of the `width` nodes from the returned one on. */
INLINE int64_t cubic_weights(const Cubics *cubics, double place, double *weight) {
    int64_t lower = last_below(cubics->node, cubics->nodes, place);
    double step = place - cubics->node[lower], square = step * step;
    for (int64_t i = 0; i < cubics->width; i++) {
        const double *c = cubics->coefficient + (lower * cubics->width + i) * 4;
        weight[i] = ((c[0] + c[1] * step) + c[2] * square) + c[3] * (square * step);
    }
    return cubics->first[lower];
}

#define TURN 100.0 /* directions below the horizon follow those above, from here on less what they are even in */

/* `directions.direction_weights`. */
INLINE int64_t direction_weights(const Layers *layers, double rise, double *weight) {
    const Cubics *cubics = &layers->direction;
    int64_t above = layers->above, count = layers->directions;
    double sine = __builtin_sqrt(clipped(1 - rise * rise, 0, 1));
    sine = sine < 1 - 1e-12 ? sine : 1 - 1e-12;
    double place = 0.5 * logarithm((1 + sine) / (1 - sine));
    int rises = above == 0 ? 0 : above == count ? 1 : rise > 0;
    if (rises)
        place = clipped(place, cubics->node[0], cubics->node[above - 1]);
    else
        place = clipped(TURN - place, cubics->node[above], cubics->node[count - 1]);
    return cubic_weights(cubics, place, weight);
}

/* Associated Legendre functions of norm sqrt((l - m)! / (l + m)!), degrees m to L - 1 of each m below M, one after the
 * other: `Ordinates.functions` at one cosine. */
INLINE void legendre(int64_t moments, int64_t azimuthal, double cosine, double *function) {
    double sine = __builtin_sqrt(clipped(1 - cosine * cosine, 0, 1)), diagonal = 1;
    for (int64_t m = 0; m < azimuthal; m++) {
        if (m > 0) diagonal *= -sine * __builtin_sqrt((2 * m - 1) / (double)(2 * m));
        double before = 0, last = diagonal;
        for (int64_t l = m; l < moments; l++) {
            *function++ = last;
            double next = (2 * l + 1) * cosine * last - __builtin_sqrt((double)((l + m) * (l - m))) * before;
            before = last;
            last = next / __builtin_sqrt((double)((l + 1 - m) * (l + 1 + m)));
        }
    }
}

INLINE int64_t functions_of(const Layers *layers) {
    return layers->azimuthal * layers->moments - layers->azimuthal * (layers->azimuthal - 1) / 2;
}

#define LEVEL 1e-9 /* share of a layer's height below which a segment is level */

/* Where a segment runs inside its layer, as shares of the layer's height from below: at its near and far end. */
INLINE void inside_layer(const Layers *layers, const Rays *rays, int64_t k, double *nearer, double *farther) {
    double bottom = layers->altitude[rays->layer[k]], height = layers->altitude[rays->layer[k] + 1] - bottom;
    *nearer = clipped((rays->altitude[k] - bottom) / height, 0, 1);
    *farther = clipped((rays->altitude[k + 1] - bottom) / height, 0, 1);
}

/* A piece of a segment in a pair of parts of a cut layer: the places of the pair's three known values, the shares of the
 * segment's optical depth that the piece has and that lie before it, and coefficients of the powers 0 to 2 of the piece
 * in each value's weight (`layer_parts.through_three`). */
typedef struct {
    const int64_t *place;
    double share, before, coefficient[3][3];
} Piece;

/* The first pair of parts of a segment in a cut layer, and their number. */
INLINE int64_t pieces_of(const Layers *layers, int64_t layer, double nearer, double farther, int64_t *first) {
    const Parts *parts = &layers->parts;
    double low = layer + (nearer < farther ? nearer : farther), high = layer + (nearer < farther ? farther : nearer);
    /* Inside the layer, where a level segment lies on its upper end too: the next layer may have no parts. */
    double start = (low < layer + 1 - LEVEL ? low : layer + 1 - LEVEL) + 0.5 * LEVEL;
    *first = last_below(parts->edge, parts->pairs + 1, start);
    int64_t end = *first;
    while (end <= parts->pairs && parts->edge[end] < high - LEVEL) end++;
    return end - *first > 1 ? end - *first : 1;
}

INLINE void piece_of(const Layers *layers, int64_t layer, double nearer, double farther, int64_t pair, Piece *piece) {
    const Parts *parts = &layers->parts;
    double low = layer + (nearer < farther ? nearer : farther), high = layer + (nearer < farther ? farther : nearer);
    double start = (low > parts->edge[pair] ? low : parts->edge[pair]) - layer;
    double end = (high < parts->edge[pair + 1] ? high : parts->edge[pair + 1]) - layer;
    double begin = farther >= nearer ? start : end, step = farther >= nearer ? end - start : start - end;
    double whole = farther - nearer;
    int level = whole < LEVEL && whole > -LEVEL;
    piece->place = parts->place + 3 * pair;
    piece->share = level ? 1 : step / whole;
    piece->before = level ? 0 : (begin - nearer) / whole;
    const double *known = parts->share + 3 * pair;
    for (int i = 0; i < 3; i++) {
        double a = known[(i + 1) % 3], b = known[(i + 2) % 3], divisor = (known[i] - a) * (known[i] - b);
        piece->coefficient[i][0] = (begin - a) * (begin - b) / divisor;
        piece->coefficient[i][1] = step * (2 * begin - a - b) / divisor;
        piece->coefficient[i][2] = step * step / divisor;
    }
}

#endif
