/* Light of Sun or Moon along joined lines of sight: scattered once, with what scattering again and again in the forward
 * peak of particles changes (`once`), and scattered more often (`again`). */
#include "scattering.h"
#include "export.h"

typedef struct {
    const Rays *rays;
    const Layers *layers;
    const Scattering *air;
    int64_t sources, stride, few; /* S, padded P, padded Q */
    const double *to_source, *deflection; /* (K + 1) x S */
    const double *phase_of_lines; /* L x N x S x C, or NULL */
    int kind;
    float scale; /* of the weights, which keeps moonlight inside single precision */
    const float *unit; /* P: weights over the scale */
    float *depth, *scaled, *through; /* K x P: optical depth, scaled, transmittance to the near end */
    float *rows; /* scratch */
    int64_t *order; /* K: segments by layer */
    double *numbers, *peak_numbers; /* scratch */
    float *peak_rows;
    float *once, *again; /* K x S, L x S x P or K x P */
} Task;

INLINE float upper_share_of(const double *sum, double lower, double upper, int64_t layer) {
    double above = upper * sum[layer + 1], column = lower * sum[layer] + above;
    if (column > 0) return (float)(above / column);
    return (float)(lower + upper > 0 ? upper / (lower + upper) : 0.5);
}

/* Optical depths of each segment and transmittance from its near end to the observer. */
static void prepare(const Task *task, const void *given, int is_double) {
    const Rays *rays = task->rays;
    int64_t points = task->layers->points, stride = task->stride;
    float *total = task->rows;
    for (int64_t line = 0; line < rays->lines; line++) {
        for (int64_t p = 0; p < stride; p++) total[p] = 0;
        for (int64_t k = rays->first[line]; k + 1 < line_end(rays, line); k++) {
            float *depth = task->depth + k * stride, *through = task->through + k * stride;
            const float *below = task->air->scaled + rays->layer[k] * stride;
            for (int64_t p = points; p < stride; p++) depth[p] = 0;
            if (is_double)
                for (int64_t p = 0; p < points; p++) depth[p] = (float)((const double *)given)[k * points + p];
            else
                for (int64_t p = 0; p < points; p++) depth[p] = ((const float *)given)[k * points + p];
            column_f((float)(rays->lower[k] / UNIT_OF_AIR), (float)(rays->upper[k] / UNIT_OF_AIR), below, below + stride,
                     stride, task->scaled + k * stride);
            for (int64_t p = 0; p < stride; p += LANES) {
                store_f(through + p, exp_f(-load_f(total + p)));
                store_f(total + p, load_f(total + p) + load_f(depth + p));
            }
        }
    }
}

/* Depth of scattering in the peak from a source to a place, (padded Q); 0 where the Earth hides it. */
static void peak_depth(const Peak *peak, const SourcePlace *place, const float *along, float *depth) {
    int64_t few = padded(peak->paths.points);
    depth_at(&peak->paths, place, depth);
    for (int64_t q = 0; q < few; q += LANES) {
        VectorF of_source = load_f(depth + q);
        store_f(depth + q, select_f(of_source >= all_f(HIDDEN), all_f(0), of_source) + load_f(along + q));
    }
}

/* A source is so close to a line of sight, through so much scattering in the peak, that the peak matters. */
static int is_near(const Task *task, int64_t line, int64_t s, const float *along, float *row) {
    const Peak *peak = &task->air->peak;
    int64_t begin = task->rays->first[line], end = line_end(task->rays, line) - 1, few = task->few;
    double nearest = -1;
    for (int64_t e = begin; e <= end; e++) {
        double cosine = task->deflection[e * task->sources + s];
        if (cosine > nearest) nearest = cosine;
    }
    if (!(nearest > peak->farthest)) return 0;
    for (int end_of_line = 0; end_of_line < 2; end_of_line++) {
        int64_t e = end_of_line ? end : begin;
        Height height = height_of(&peak->paths, task->rays->altitude[e]);
        SourcePlace place;
        double scratch[24];
        source_places(&peak->paths, &height, 1, task->to_source + e * task->sources + s, scratch, &place);
        peak_depth(peak, &place, along + (end - begin) * few, row);
        for (int64_t q = 0; q < peak->paths.points; q++)
            if (row[q] > peak->none) return 1;
    }
    return 0;
}

/* Adds what the peak changes of the light that a segment scatters, before attenuation, (padded P): for depths (padded Q)
 * and a scattering angle [rad]. */
static void add_peak(const Task *task, int64_t k, const float *depth, double angle, float *light) {
    const Peak *peak = &task->air->peak;
    int64_t last = peak->angles - 1, few = peak->paths.points, *first = (int64_t *)(task->peak_numbers + task->few);
    double degrees = clipped(angle * (180 / PI), peak->angle[0], peak->angle[last]), *steps = task->peak_numbers;
    int64_t turn = last_below(peak->angle, last, degrees);
    float part = (float)((degrees - peak->angle[turn]) / (peak->angle[turn + 1] - peak->angle[turn]));
    float *deep = task->peak_rows, *share = deep + task->few, *changes = share + task->few;
    for (int64_t q = 0; q < task->few; q++) steps[q] = depth[q] / peak->least_depth;
    for (int64_t q = 0; q < task->few; q += DOUBLES)
        store_d(steps + q, logarithm_d(larger_d(load_d(steps + q), all_d(1))) * (1 / peak->log_step));
    for (int64_t q = 0; q < few; q++) {
        double over = depth[q] / peak->least_depth;
        share[q] = (float)(clipped((depth[q] - peak->none) / (peak->whole - peak->none), 0, 1) * (1 / (4 * PI)));
        share[q] *= (float)(over < 1 ? over : 1);
        first[q] = steps[q] < peak->depths - 2 ? (int64_t)steps[q] : peak->depths - 2;
        deep[q] = steps[q] - first[q] < 1 ? (float)(steps[q] - first[q]) : 1;
        first[q] = first[q] * few + q;
    }
    for (int end = 0; end < 2; end++) {
        int64_t level = task->rays->layer[k] + end;
        const float *near = peak->change + (level * peak->angles + turn) * peak->depths * few;
        const float *far = near + peak->depths * few;
        float *change = changes + end * (task->few + 8);
        for (int64_t q = 0; q < few; q++) {
            const float *a = near + first[q], *b = far + first[q];
            float at_near = a[0] + (a[few] - a[0]) * deep[q], at_far = b[0] + (b[few] - b[0]) * deep[q];
            change[q] = (at_near + (at_far - at_near) * part) * share[q];
        }
        change[few] = 0;
    }
    float lower = (float)(task->rays->lower[k] / UNIT_OF_AIR), upper = (float)(task->rays->upper[k] / UNIT_OF_AIR);
    const float *below = peak->every + task->rays->layer[k] * task->stride, *above = below + task->stride;
    for (int64_t p = 0; p < task->layers->points; p++) {
        int64_t q = peak->spread[p];
        float next = peak->spread_next[p];
        const float *lower_change = changes + q, *upper_change = lower_change + task->few + 8;
        float at_lower = lower_change[0] + (lower_change[1] - lower_change[0]) * next;
        float at_upper = upper_change[0] + (upper_change[1] - upper_change[0]) * next;
        light[p] += lower * below[p] * at_lower + upper * above[p] * at_upper;
    }
}

/* Phase function of the particles of a segment at its scattering angle, at the classes of wavelength (C,). */
static void phase_at(const Task *task, int64_t line, int64_t k, int64_t s, double angle, float upper, float *shape) {
    const Scattering *air = task->air;
    int64_t layer = task->rays->layer[k], levels = task->layers->levels, classes = air->classes;
    if (task->phase_of_lines) {
        const double *below = task->phase_of_lines + ((line * levels + layer) * task->sources + s) * classes;
        const double *above = below + task->sources * classes;
        for (int64_t c = 0; c < classes; c++) shape[c] = (float)below[c] * (1 - upper) + (float)above[c] * upper;
        return;
    }
    double place = angle / air->angle_step;
    int64_t first = place < air->angles - 2 ? (int64_t)place : air->angles - 2;
    float part = (float)(place - first);
    const float *near = air->phase + (first * levels + layer) * classes, *far = near + levels * classes;
    for (int64_t c = 0; c < classes; c++) {
        float low = near[c] + (far[c] - near[c]) * part;
        float high = near[classes + c] + (far[classes + c] - near[classes + c]) * part;
        shape[c] = (1 - upper) * low + upper * high;
    }
}

/* Means (S,) of cosines (2, S) at both ends of a segment, from -1 to 1, and their angles, rad; rows of padded S. */
INLINE void middle_angles(const double *ends, int64_t sources, double *cosine, double *angle) {
    int64_t stride = padded(sources);
    for (int64_t s = 0; s < sources; s++) cosine[s] = 0.5 * (ends[s] + ends[sources + s]);
    for (int64_t s = sources; s < stride; s++) cosine[s] = 0;
    for (int64_t s = 0; s < stride; s += DOUBLES) {
        VectorD bounded = smaller_d(larger_d(load_d(cosine + s), all_d(-1)), all_d(1));
        store_d(cosine + s, bounded);
        store_d(angle + s, 0.5 * PI - arc_sine_d(bounded));
    }
}

/* Light scattered once. */
static void once(Task *task) {
    const Rays *rays = task->rays;
    const Scattering *air = task->air;
    int64_t sources = task->sources, stride = task->stride, few = task->few, points = task->layers->points;
    float *total = task->rows, *molecules = total + stride, *particles = molecules + stride, *light = particles + stride;
    float *here = light + stride, *shape = here + stride;
    float *depth = shape + 8 + air->classes, *through = depth + sources * stride;
    float *row = through + sources * stride, *middle = row + few, *source_peak = middle + few;
    float *along = source_peak + sources * few, *near = along + (rays->segments + 1) * few;
    double *cosines = task->numbers + 3 * padded(sources), *angles = cosines + padded(sources);
    SourcePlace *places = (SourcePlace *)(angles + padded(sources));
    task->peak_rows = near + sources, task->peak_numbers = (double *)places + (sources * (int64_t)sizeof(SourcePlace) + 7) / 8;
    for (int64_t line = 0; line < rays->lines; line++) {
        int64_t begin = rays->first[line], end = line_end(rays, line) - 1;
        for (int64_t p = 0; p < stride; p++) total[p] = 0;
        if (air->peak.few) {
            for (int64_t q = 0; q < few; q++) along[q] = 0;
            for (int64_t k = begin; k < end; k++) {
                const float *below = air->peak.few + rays->layer[k] * few;
                float *next = along + (k + 1 - begin) * few;
                column_f((float)(rays->lower[k] / UNIT_OF_AIR), (float)(rays->upper[k] / UNIT_OF_AIR), below, below + few,
                         few, next);
                for (int64_t q = 0; q < few; q += LANES) store_f(next + q, load_f(next + q) + load_f(next - few + q));
            }
        }
        for (int64_t s = 0; s < sources; s++) near[s] = air->peak.few ? (float)is_near(task, line, s, along, row) : 0;
        for (int64_t e = begin; e <= end; e++) {
            Height height = height_of(&air->paths, rays->altitude[e]);
            int64_t k = e - 1;
            source_places(&air->paths, &height, sources, task->to_source + e * sources, task->numbers, places);
            float lower = 0, upper = 0, upper_share = 0;
            if (e > begin) {
                lower = (float)(rays->lower[k] / UNIT_OF_AIR), upper = (float)(rays->upper[k] / UNIT_OF_AIR);
                const float *rayleigh = air->rayleigh + rays->layer[k] * stride;
                column_f(lower, upper, rayleigh, rayleigh + stride, stride, molecules);
                if (air->particles) {
                    const float *below = air->particles + rays->layer[k] * stride;
                    column_f(lower, upper, below, below + stride, stride, particles);
                    upper_share = upper_share_of(air->particle_sum, rays->lower[k], rays->upper[k], rays->layer[k]);
                }
                const float *scaled = task->scaled + k * stride;
                for (int64_t p = 0; p < stride; p += LANES) store_f(total + p, load_f(total + p) + load_f(scaled + p));
                middle_angles(task->deflection + k * sources, sources, cosines, angles);
            }
            for (int64_t s = 0; s < sources; s++) {
                float *depth_before = depth + s * stride, *through_before = through + s * stride;
                const SourcePlace *place = places + s;
                depth_at(&air->paths, place, here);
                if (e == begin) {
                    for (int64_t p = 0; p < stride; p += LANES) {
                        store_f(depth_before + p, load_f(here + p));
                        store_f(through_before + p, exp_f(-load_f(here + p)));
                    }
                    if (near[s] > 0) peak_depth(&air->peak, place, along, source_peak + s * few);
                    continue;
                }
                double cosine = cosines[s];
                float molecular = (float)(0.75 / (1 + 2 * air->anisotropy)
                    * ((1 + 3 * air->anisotropy) + (1 - air->anisotropy) * cosine * cosine) / (4 * PI));
                if (air->particles) phase_at(task, line, k, s, angles[s], upper_share, shape);
                for (int64_t p = 0; p < stride; p += LANES) {
                    VectorF sum = load_f(molecules + p) * molecular;
                    if (air->particles) {
                        VectorF phase = all_f(0);
                        for (int64_t c = 0; c < air->classes; c++)
                            phase += shape[c] * load_f(air->phase_share + c * stride + p);
                        sum += phase * load_f(particles + p) * (float)(1 / (4 * PI));
                    }
                    store_f(light + p, sum);
                }
                if (near[s] > 0) {
                    float *before = source_peak + s * few;
                    peak_depth(&air->peak, place, along + (e - begin) * few, row);
                    for (int64_t q = 0; q < few; q += LANES)
                        store_f(middle + q, 0.5f * (load_f(before + q) + load_f(row + q)));
                    for (int64_t q = 0; q < few; q++) before[q] = row[q];
                    add_peak(task, k, middle, angles[s], light);
                }
                float *lines = task->once + (task->kind == OF_LINES ? (line * sources + s) * stride : k * stride);
                Eight sum = {{{0}}};
                for (int64_t p = 0; p < stride; p += 8)
                    for (int h = 0; h < 8 / LANES; h++) {
                        int64_t at = p + h * LANES;
                        VectorF before = load_f(depth_before + at), bright = load_f(through_before + at);
                        VectorF now = load_f(here + at) + smaller_f(load_f(total + at), all_f(HIDDEN));
                        VectorF dark = exp_f(-now), difference = now - before, square = difference * difference;
                        BitsF wide = square > all_f(1);
                        /* mean of exp(-x) over the segment, in which x is linear */
                        VectorF series = ((square * (1 / 80.0f) + 1) * square * (1 / 24.0f) + 1) * root_f(bright * dark);
                        VectorF mean = select_f(wide, (bright - dark) / select_f(wide, difference, all_f(1)), series);
                        VectorF sent = mean * load_f(light + at);
                        store_f(depth_before + at, now);
                        store_f(through_before + at, dark);
                        if (task->kind == OF_BAND)
                            sum.part[h] += sent * load_f(task->unit + at);
                        else
                            store_f(lines + at, load_f(lines + at) + sent);
                    }
                if (task->kind == OF_BAND) {
                    float value = total_of(&sum);
                    task->once[k * sources + s] = near[s] > 0 && value < 0 ? 0 : value;
                }
            }
        }
        if (task->kind == OF_LINES)
            for (int64_t s = 0; s < sources; s++)
                for (int64_t p = 0; near[s] > 0 && p < points; p++) {
                    float *value = task->once + (line * sources + s) * stride + p;
                    if (*value < 0) *value = 0;
                }
    }
}

/* The elevations of the source between which the field is taken: the first of `*width` and their weights
 * (`source_nodes.elevation_weights`). */
static int64_t elevation_weights(const Scattering *air, double sine, double elevation, double *weight, int64_t *width) {
    int64_t count = air->elevations;
    double inside = clipped(sine, air->sine[0], air->sine[count - 1]);
    if (count - air->smooth >= 4 && inside >= air->sine[air->smooth]) {
        *width = air->elevation.width;
        return air->smooth + cubic_weights(&air->elevation, inside < sine ? arc_sine(inside) : elevation, weight);
    }
    double above = (inside != sine ? arc_sine(inside) : elevation) * (180 / PI) - air->start, span = air->end - air->start;
    double late = span - (above > 0 ? above : 0), light = 1;
    double fall = (late > 0 ? late * late / (2 * span) : 0) - (above < 0 ? above : 0);
    if (fall > 0) light = exponential(-air->fall * fall);
    *width = count > 1 ? 2 : 1;
    if (count == 1) {
        weight[0] = light / air->typical[0];
        return 0;
    }
    int64_t below = last_below(air->sine, count - 1, inside);
    double share = (inside - air->sine[below]) / (air->sine[below + 1] - air->sine[below]);
    weight[0] = (1 - share) * light / air->typical[below];
    weight[1] = share * light / air->typical[below + 1];
    return below;
}

/* Sum of rows of a table, `step` apart, times their factors, at some vectors of points. */
INLINE void sum_rows(int vectors, int64_t rows, const float *row, int64_t step, const float *factor, VectorF *sum) {
    for (int i = 0; i < vectors; i++) sum[i] = factor[0] * load_f(row + i * LANES);
    for (int64_t b = 1; b < rows; b++) {
        row += step;
        for (int i = 0; i < vectors; i++) sum[i] += factor[b] * load_f(row + i * LANES);
    }
}

/* Light of one place of a table, by elevation of the source and azimuthal moment, times a weight (padded P): of rows at
 * `table`, `rows[m]` of each moment m, which lie `step` apart, with their factors; elevations lie `apart`. Moments have
 * rows of their own, one after the other, or begin `moment_step` apart and share the factors. Of a band its sum is added
 * to `sums` (U x M), else it is added to `light` (U x M x padded P). */
INLINE void add_place(
    const Task *task, int of_band, int64_t from, int64_t to, const float *table, int64_t apart, const int64_t *rows,
    int64_t step, int64_t moment_step, const float *factor, const float *weight, Eight *sums, float *light
) {
    enum { BLOCK = 32, PARTS = 8 / LANES };
    int64_t stride = task->stride, azimuthal = task->layers->azimuthal;
    for (int64_t v = from; v < to; v++) {
        const float *row = table + v * apart, *factors = factor;
        for (int64_t m = 0; m < azimuthal; m++) {
            float *into = light + (v * azimuthal + m) * stride;
            Eight *of_band_sum = sums + v * azimuthal + m;
            int64_t p = 0;
            for (; p + BLOCK <= stride; p += BLOCK) {
                VectorF sum[BLOCK / LANES];
                sum_rows(BLOCK / LANES, rows[m], row + p, step, factors, sum);
                for (int i = 0; i < BLOCK / LANES; i++) {
                    VectorF some = sum[i] * load_f(weight + p + i * LANES);
                    if (of_band)
                        of_band_sum->part[i % PARTS] += some;
                    else
                        store_f(into + p + i * LANES, load_f(into + p + i * LANES) + some);
                }
            }
            for (; p < stride; p += 8) {
                VectorF sum[PARTS];
                sum_rows(PARTS, rows[m], row + p, step, factors, sum);
                for (int i = 0; i < PARTS; i++) {
                    VectorF some = sum[i] * load_f(weight + p + i * LANES);
                    if (of_band)
                        of_band_sum->part[i] += some;
                    else
                        store_f(into + p + i * LANES, load_f(into + p + i * LANES) + some);
                }
            }
            row += moment_step ? moment_step : rows[m] * step;
            factors += moment_step ? 0 : rows[m];
        }
    }
}

/* Light scattered more than once, layer by layer for all lines, so that a layer's tables are read once. */
INLINE void again(const Task *task, int of_band) {
    const Rays *rays = task->rays;
    const Layers *layers = task->layers;
    const Scattering *air = task->air;
    int64_t sources = task->sources, stride = task->stride, azimuthal = layers->azimuthal, count = functions_of(layers);
    int64_t apart = count * stride, width = layers->direction.width, rows[64], directions[64];
    float *weight = task->rows, *functions = weight + 3 * stride, *cosine = functions + count;
    float *light = cosine + sources * azimuthal, *moment = light + air->elevations * azimuthal * stride;
    float *share = moment + air->elevations * azimuthal; /* S x 4 */
    Eight *sums = (Eight *)(share + 4 * sources);
    int64_t *node = task->order + rays->segments;
    double *cosines = task->numbers + count, *angles = cosines + padded(sources);
    for (int64_t m = 0; m < azimuthal; m++) rows[m] = layers->moments - m, directions[m] = width;
    for (int64_t at = 0; at < rays->segments; at++) {
        int64_t k = task->order[at], layer, line = 0, from = air->elevations, to = 0, first = 0;
        double nearer, farther, of_direction[8];
        if (k < 0) continue;
        layer = rays->layer[k];
        const float *depth = task->depth + k * stride, *scaled = task->scaled + k * stride;
        const float *through = task->through + k * stride;
        middle_angles(task->to_source + k * sources, sources, cosines, angles);
        for (int64_t s = 0; s < sources; s++) {
            double to_source = cosines[s];
            double angle = 0.5 * (task->deflection[k * sources + s] + task->deflection[(k + 1) * sources + s]);
            double of_node[4] = {0}, up = rays->rise[k], across = (1 - up * up) * (1 - to_source * to_source);
            int64_t nodes;
            node[s] = elevation_weights(air, to_source, 0.5 * PI - angles[s], of_node, &nodes);
            from = node[s] < from ? node[s] : from;
            to = node[s] + nodes > to ? node[s] + nodes : to;
            for (int i = 0; i < 4; i++) share[4 * s + i] = (float)of_node[i];
            float turn = (float)clipped((angle + up * to_source) / __builtin_sqrt(across > 1e-12 ? across : 1e-12), -1, 1);
            float *multiple = cosine + s * azimuthal;
            for (int64_t m = 0; m < azimuthal; m++) /* Chebyshev's recurrence */
                multiple[m] = m == 0 ? 1 : m == 1 ? turn : 2 * turn * multiple[m - 1] - multiple[m - 2];
        }
        for (int64_t i = from * azimuthal; i < to * azimuthal; i++) {
            if (of_band)
                sums[i] = (Eight){{{0}}};
            else
                for (int64_t p = 0; p < stride; p++) light[i * stride + p] = 0;
        }
        legendre(layers->moments, azimuthal, rays->rise[k], task->numbers);
        for (int64_t b = 0; b < count; b++) functions[b] = (float)task->numbers[b];
        inside_layer(layers, rays, k, &nearer, &farther);
        int64_t pieces = layers->parts.count[layer] > 1 ? pieces_of(layers, layer, nearer, farther, &first) : 1;
        for (int64_t i = 0; i < pieces; i++) {
            Piece piece;
            int64_t whole[2] = {layer, layer + 1};
            const int64_t *places = whole;
            int ends = 2;
            if (layers->parts.count[layer] > 1) {
                piece_of(layers, layer, nearer, farther, first + i, &piece);
                piece_weights_f(&piece, scaled, through, stride, weight);
                places = piece.place, ends = 3;
            } else {
                double height = layers->altitude[layer + 1] - layers->altitude[layer];
                float climb = (float)(0.5 * (rays->altitude[k + 1] - rays->altitude[k]) / height);
                end_weights_f((float)(rays->upper[k] / UNIT_OF_AIR), air->scaled + (layer + 1) * stride, scaled, climb,
                              through, stride, weight, weight + stride);
            }
            for (int end = 0; end < ends; end++) {
                float *of_place = weight + end * stride;
                if (of_band)
                    for (int64_t p = 0; p < stride; p++) of_place[p] *= task->unit[p];
                const float *table = air->source + places[end] * air->elevations * apart;
                add_place(task, of_band, from, to, table, apart, rows, stride, 0, functions, of_place, sums, light);
            }
        }
        if (air->straight) {
            int64_t step = azimuthal * stride, of_level = air->elevations * layers->directions * step;
            straight_share_f(depth, scaled, through, stride, weight);
            if (of_band)
                for (int64_t p = 0; p < stride; p++) weight[p] *= task->unit[p];
            first = direction_weights(layers, rays->rise[k], of_direction);
            for (int end = 0; end < 2; end++) {
                float factor[8];
                double part = end ? farther : 1 - farther;
                if (!(part > LEVEL)) continue;
                for (int64_t i = 0; i < width; i++) factor[i] = (float)(part * of_direction[i]);
                const float *table = air->straight + (layer + end) * of_level + first * step;
                add_place(task, of_band, from, to, table, layers->directions * step, directions, step, stride, factor, weight, sums,
                          light);
            }
        }
        if (of_band) {
            for (int64_t i = from * azimuthal; i < to * azimuthal; i++) moment[i] = total_of(&sums[i]);
            for (int64_t s = 0; s < sources; s++) {
                float radiance = 0;
                for (int64_t i = 0; i < 4 && node[s] + i < to; i++) {
                    const float *of_node = moment + (node[s] + i) * azimuthal;
                    float value = 0;
                    for (int64_t m = 0; m < azimuthal; m++) value += of_node[m] * cosine[s * azimuthal + m];
                    radiance += value * share[4 * s + i];
                }
                task->again[k * sources + s] = radiance < 0 ? 0 : radiance;
            }
            continue;
        }
        while (line + 1 < rays->lines && rays->first[line + 1] <= k) line++;
        for (int64_t s = 0; s < sources; s++) {
            float *into = task->again + (task->kind == OF_LINES ? (line * sources + s) * stride : k * stride);
            for (int64_t i = 0; i < 4 && node[s] + i < to; i++)
                for (int64_t m = 0; m < azimuthal; m++) {
                    const float *of_node = light + ((node[s] + i) * azimuthal + m) * stride;
                    float factor = share[4 * s + i] * cosine[s * azimuthal + m];
                    for (int64_t p = 0; p < stride; p += LANES)
                        store_f(into + p, load_f(into + p) + factor * load_f(of_node + p));
                }
        }
    }
}

INLINE int64_t rounded(int64_t numbers) { return (numbers + 15) / 16 * 16; }

typedef struct {
    int64_t segments, rows, order, numbers, light;
} Sizes;

static Sizes sizes(const Rays *rays, const Layers *layers, const Scattering *air, int64_t sources, int kind) {
    int64_t stride = padded(layers->points), few = air->peak.few ? padded(air->peak.paths.points) : 0;
    int64_t azimuthal = layers->azimuthal, count = functions_of(layers), nodes = air->elevations * azimuthal;
    int64_t for_once = 5 * stride + 8 + air->classes + 2 * sources * stride + (2 + sources + rays->segments + 1 + 4) * few + sources + 16;
    int64_t for_again = 3 * stride + count + sources * azimuthal + nodes * (stride + 1 + 8) + 4 * sources;
    Sizes size;
    size.segments = rounded(rays->segments * stride);
    size.rows = rounded(for_once > for_again ? for_once : for_again) + 16;
    size.order = rays->segments + sources;
    int64_t for_places = 5 * padded(sources) + (sources * (int64_t)sizeof(SourcePlace) + 7) / 8;
    for_places += 2 * few;
    size.numbers = count + 2 * padded(sources) > for_places ? count + 2 * padded(sources) : for_places;
    size.light = rounded(kind == OF_BAND ? rays->segments * sources
        : kind == OF_LINES               ? rays->lines * sources * stride
                                         : rays->segments * stride);
    return size;
}

/* Bytes of scratch memory that `scattered_light` needs. */
SKYSHINE_EXPORT int64_t SKYSHINE_NAME(scattered_light_scratch)(
    const Rays *rays, const Layers *layers, const Scattering *air, int64_t sources, int64_t kind
) {
    Sizes size = sizes(rays, layers, air, sources, (int)kind);
    int64_t floats = 3 * size.segments + size.rows + 2 * size.light + rounded(padded(layers->points));
    return 8 * (size.order + size.numbers) + 4 * floats;
}

/* Scattered light of sources along L joined lines, per unit of a source's irradiance.
 *
 * `to_source`, `deflection` (K + 1, S): cosines of the source's zenith angle and of the scattering angle at the segment
 * ends. `depth` (K, P): optical depth of the segments, in double precision or not. `phase_of_lines` (L, N, S, C) or
 * NULL: phase function of the particles in place of that at the scattering angle. `result`: of a band (K + 1, S), up to
 * each segment end, with weights (P,); of lines (L, S, P); of segments (K, P), for one source. */
SKYSHINE_EXPORT void SKYSHINE_NAME(scattered_light)(
    const Rays *rays, const Layers *layers, const Scattering *air, int64_t sources, const double *to_source,
    const double *deflection, const void *depth, int64_t is_double, int64_t kind, const double *weight,
    const double *phase_of_lines, double *scratch, double *result
) {
    Sizes size = sizes(rays, layers, air, sources, (int)kind);
    int64_t points = layers->points, stride = padded(points), segments = rays->segments;
    Task task = {.rays = rays, .layers = layers, .air = air, .sources = sources, .stride = stride, .kind = (int)kind,
        .few = air->peak.few ? padded(air->peak.paths.points) : 0, .to_source = to_source, .deflection = deflection,
        .phase_of_lines = phase_of_lines, .scale = 1};
    task.numbers = scratch;
    task.order = (int64_t *)(scratch + size.numbers);
    float *floats = (float *)(task.order + size.order);
    task.depth = floats, task.scaled = task.depth + size.segments, task.through = task.scaled + size.segments;
    task.once = task.through + size.segments, task.again = task.once + size.light;
    float *unit = task.again + size.light;
    task.unit = unit, task.rows = unit + rounded(stride);
    double scale = 1e-300;
    for (int64_t p = 0; weight && p < points; p++) {
        double height = weight[p] < 0 ? -weight[p] : weight[p];
        scale = height > scale ? height : scale;
    }
    for (int64_t p = 0; p < stride; p++) unit[p] = weight && p < points ? (float)(weight[p] / scale) : 0;
    for (int64_t i = 0; i < size.light; i++) task.once[i] = task.again[i] = 0;
    prepare(&task, depth, (int)is_double);
    int64_t placed = 0;
    for (int64_t layer = 0; layer + 1 < layers->levels; layer++)
        for (int64_t line = 0; line < rays->lines; line++)
            for (int64_t k = rays->first[line]; k + 1 < line_end(rays, line); k++)
                if (rays->layer[k] == layer) task.order[placed++] = k;
    while (placed < segments) task.order[placed++] = -1;
    once(&task);
    if (kind == OF_BAND)
        again(&task, 1);
    else
        again(&task, 0);
    if (kind == OF_BAND) {
        for (int64_t i = 0; i < (segments + 1) * sources; i++) result[i] = 0;
        for (int64_t line = 0; line < rays->lines; line++)
            for (int64_t k = rays->first[line]; k + 1 < line_end(rays, line); k++)
                for (int64_t s = 0; s < sources; s++) {
                    int64_t i = k * sources + s;
                    result[i + sources] = result[i] + ((double)task.once[i] + (double)task.again[i]) * scale;
                }
        return;
    }
    int64_t rows = kind == OF_LINES ? rays->lines * sources : segments;
    for (int64_t row = 0; row < rows; row++)
        for (int64_t p = 0; p < points; p++) {
            float more = task.again[row * stride + p];
            result[row * points + p] = (double)task.once[row * stride + p] + (more < 0 ? 0 : more);
        }
}
