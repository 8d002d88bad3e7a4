/* See `shade.h`. Changes of heat and temperature are lists of the SKY_STEPS steps of a day. */
#include "shade.h"
#include "film.h"

enum { CORRECTIONS = 8 }; /* times that the excess of the heat loss is applied */
static const double DAY = 24, STEP = 24.0 / SKY_STEPS, STEFAN_BOLTZMANN = 5.6703744191844314e-8; /* W m^-2 K^-4 */
static const double MELTING_RANGE = 0.01;   /* K below its melting point in which a surface counts as melting */
static const double LOWEST_AUREOLE = 10;    /* degree: light around a lower Sun comes from there */
static const double WALL_EMISSIVITY = 0.95; /* of masonry, concrete and foliage in the thermal infrared */
enum { MATERIAL, ALTITUDE, AZIMUTH, SLOPE, TIME };

/* The response of one column, at the hours of the file; H hours, L cells of lag, O offsets. */
typedef struct {
    const SkyTables *tables;
    Place hour[SKY_STEPS], forcing[SKY_STEPS], time[SKY_STEPS]; /* of each step, on the axes of response, light and temperatures */
    uint8_t hours_there[SKY_STEPS];            /* the temperatures have the step's hour */
    double sine_up[SKY_STEPS], cosine_up[SKY_STEPS], sine_turn[SKY_STEPS], cosine_turn[SKY_STEPS], aureole[SKY_STEPS]; /* of the Sun */
    double *kernel_hours, *kernel;  /* (H, L); (L, SKY_STEPS) */
    double *excess, *film_loss, *evaporation; /* (H, O) */
    double *slope_hours;            /* (H) */
    double *day_nodes;              /* of the time axis */
    double slope[SKY_STEPS], start[SKY_STEPS], base[SKY_STEPS], moved[SKY_STEPS];
    double heat[SKY_STEPS], target[SKY_STEPS], light[SKY_STEPS], evaporated[SKY_STEPS], covered[SKY_STEPS];
    double twice[2 * SKY_STEPS], totals[2 * SKY_STEPS];
    double normal[SKY_STEPS], diffuse[SKY_STEPS], sky[SKY_STEPS], air[SKY_STEPS], light_altitude; /* at an altitude, NaN: none */
    double own[SKY_STEPS], sunlight[SKY_STEPS], ground[SKY_STEPS], sunlit[SKY_STEPS];
    Film film;
    WetDay open, day;
    int wet;
    double ground_altitude; /* of `ground`, NaN: none */
} Shade;

static const Axis *axes_of(const SkyTables *tables, int32_t array) { return tables->surface.arrays[array].axes; }

size_t SKYSHINE_NAME(skyshine_shade_scratch)(const SkyTables *tables) {
    if (!tables->surface.arrays[KERNEL].values) return sizeof(Shade);
    const Axis *axes = axes_of(tables, KERNEL);
    size_t hours = axes[3].count, lags = axes[4].count, offsets = axes_of(tables, LOSS_EXCESS)[4].count;
    size_t times = tables->surface.arrays[TEMPERATURE].values ? axes_of(tables, TEMPERATURE)[TIME].count : 0;
    return sizeof(Shade) + sizeof(double) * (hours * lags + lags * SKY_STEPS + 3 * hours * offsets + hours + times);
}

/* Whether the temperatures have an hour. */
static int has_hour(const Axis *time, double hour) {
    double since = hour - time->first;
    return time->rule == SKY_PERIODIC || since - DAY * floor_of(since / DAY) <= time->nodes[time->count - 1] - time->first;
}

static int32_t begin(Shade *shade, const SkyTables *tables, SkyFailure *failure) {
    if (!tables->surface.arrays[KERNEL].values) return refuse(failure, SKY_NO_RESPONSE, SKY_SURFACE, 0, "response_kernel", 0, 0, 0);
    const Array *arrays = tables->surface.arrays;
    const Axis *axes = axes_of(tables, KERNEL), *time = arrays[TEMPERATURE].values ? &arrays[TEMPERATURE].axes[TIME] : 0;
    const Axis *forcing = arrays[AUREOLE].values ? arrays[AUREOLE].axes : arrays[RAIN].values ? arrays[RAIN].axes : 0;
    size_t hours = axes[3].count, lags = axes[4].count, offsets = axes_of(tables, LOSS_EXCESS)[4].count;
    if (offsets < 2) return refuse(failure, SKY_NODES, SKY_SURFACE, 0, "temperature_offset", 0, 0, 0);
    shade->tables = tables;
    shade->kernel_hours = (double *)(shade + 1);
    shade->kernel = shade->kernel_hours + hours * lags;
    shade->excess = shade->kernel + lags * SKY_STEPS;
    shade->film_loss = shade->excess + hours * offsets;
    shade->evaporation = shade->film_loss + hours * offsets;
    shade->slope_hours = shade->evaporation + hours * offsets;
    shade->day_nodes = shade->slope_hours + hours;
    shade->ground_altitude = shade->light_altitude = NOT_A_NUMBER;
    for (size_t k = 0; k < SKY_STEPS; k++) {
        double hour = (double)k * STEP;
        int32_t status = find(&axes[3], hour, SKY_SURFACE, 0, &shade->hour[k], failure);
        if (!status && forcing) status = find(forcing, hour, SKY_SURFACE, 0, &shade->forcing[k], failure);
        shade->hours_there[k] = time && has_hour(time, hour);
        if (!status && shade->hours_there[k]) status = find(time, hour, SKY_SURFACE, 0, &shade->time[k], failure);
        if (status) return status;
    }
    return SKY_OK;
}

/* ---- Tables of a column ---- */

/* Corners of the columns whose response is stored around one of a material, an altitude and a slope. */
typedef struct {
    size_t column[4];
    double weight[4];
} Columns;

static int32_t columns_of(const SkyTables *tables, const double *face, size_t row, Columns *columns, SkyFailure *failure) {
    const Axis *axes = axes_of(tables, KERNEL);
    Place material, altitude, slope;
    int32_t status = find(&axes[0], face[MATERIAL], SKY_SURFACE, row, &material, failure);
    if (!status) status = find(&axes[1], bounded(&axes[1], face[ALTITUDE]), SKY_SURFACE, row, &altitude, failure);
    if (!status) status = find(&axes[2], bounded(&axes[2], face[SLOPE]), SKY_SURFACE, row, &slope, failure);
    if (status) return status;
    for (int c = 0; c < 4; c++) {
        size_t up = c & 2 ? altitude.upper : altitude.lower, tilt = c & 1 ? slope.upper : slope.lower;
        columns->column[c] = (material.lower * axes[1].count + up) * axes[2].count + tilt;
        columns->weight[c] = (c & 2 ? altitude.weight : 1 - altitude.weight) * (c & 1 ? slope.weight : 1 - slope.weight);
    }
    return SKY_OK;
}

/* Numbers of a column, so many of an array. */
static void mix(const SkyTables *tables, int32_t array, const Columns *columns, size_t count, double *to) {
    const float *values = tables->surface.arrays[array].values;
    for (size_t k = 0; k < count; k++) to[k] = columns->weight[0] * values[columns->column[0] * count + k];
    for (int c = 1; c < 4; c++)
        for (size_t k = 0; k < count && columns->weight[c] != 0; k++) to[k] += columns->weight[c] * values[columns->column[c] * count + k];
}

static double at_step(const double *hours, const Place *place) {
    return (1 - place->weight) * hours[place->lower] + place->weight * hours[place->upper];
}

static void through_the_day(const Shade *shade, const double *hours, double *to) {
    for (size_t k = 0; k < SKY_STEPS; k++) to[k] = at_step(hours, &shade->hour[k]);
}

/* A table (H, O) at a step and an offset; of the heat loss with its slope and a share of a film's. */
static double entry(const Shade *shade, const double *table, size_t step, size_t offset) {
    const Axis *offsets = &axes_of(shade->tables, LOSS_EXCESS)[4];
    const Place *place = &shade->hour[step];
    return (1 - place->weight) * table[place->lower * offsets->count + offset] + place->weight * table[place->upper * offsets->count + offset];
}

static double loss_entry(const Shade *shade, size_t step, size_t offset, double covered) {
    double loss = shade->slope[step] * axes_of(shade->tables, LOSS_EXCESS)[4].nodes[offset] + entry(shade, shade->excess, step, offset);
    return covered > 0 ? loss + covered * entry(shade, shade->film_loss, step, offset) : loss;
}

static size_t cell_at(const Axis *offsets, double at, size_t cell) {
    while (cell + 2 < offsets->count && offsets->nodes[cell + 1] <= at) cell++;
    while (cell > 0 && offsets->nodes[cell] > at) cell--;
    return cell;
}

/* The heat loss at an offset, linear between nodes and beyond them; its slope where it is wanted. */
static double loss_at(const Shade *shade, size_t step, double at, double covered, size_t *cell, double *rise) {
    const Axis *offsets = &axes_of(shade->tables, LOSS_EXCESS)[4];
    size_t low = *cell = cell_at(offsets, at, *cell);
    double below = loss_entry(shade, step, low, covered), above = loss_entry(shade, step, low + 1, covered);
    double slope = (above - below) / (offsets->nodes[low + 1] - offsets->nodes[low]);
    if (rise) *rise = slope;
    return below + (at - offsets->nodes[low]) * slope;
}

static double table_at(const Shade *shade, const double *table, size_t step, double at, size_t *cell) {
    const Axis *offsets = &axes_of(shade->tables, LOSS_EXCESS)[4];
    size_t low = *cell = cell_at(offsets, at, *cell);
    double below = entry(shade, table, step, low), above = entry(shade, table, step, low + 1);
    return below + (at - offsets->nodes[low]) * (above - below) / (offsets->nodes[low + 1] - offsets->nodes[low]);
}

/* Offset at which the heat loss, which ascends, is a wanted one. */
static double offset_of(const Shade *shade, size_t step, double wanted, double covered, size_t *cell) {
    const Axis *offsets = &axes_of(shade->tables, LOSS_EXCESS)[4];
    size_t low = *cell;
    while (low + 2 < offsets->count && loss_entry(shade, step, low + 1, covered) <= wanted) low++;
    while (low > 0 && loss_entry(shade, step, low, covered) > wanted) low--;
    *cell = low;
    double below = loss_entry(shade, step, low, covered), rise = loss_entry(shade, step, low + 1, covered) - below;
    return offsets->nodes[low] + (rise > 0 ? (wanted - below) / rise : 0) * (offsets->nodes[low + 1] - offsets->nodes[low]);
}

/* ---- The response ---- */

/* Where the integral of step means to the steps less a lag is read: `totals` and `values` from a place on, a part of a step
 * beyond it, and what whole days before give. */
typedef struct {
    const double *totals, *values;
    double part, days;
} Lagged;

static Lagged lagged(const Shade *shade, double lag) {
    double offset = 0.5 - lag / STEP, whole = floor_of(offset), day = floor_of(whole / SKY_STEPS);
    size_t from = (size_t)clipped(whole - day * SKY_STEPS, 0, SKY_STEPS - 1);
    return (Lagged){shade->totals + from, shade->twice + from, offset - whole, day * shade->totals[SKY_STEPS]};
}

static VectorD integral(const Lagged *of, size_t k) { return load_d(of->totals + k) + of->part * load_d(of->values + k) + of->days; }

/* The kernel applied to a history of heat. */
static void apply_kernel(Shade *shade, const double *heat, double *moved) {
    const Axis *lags = &axes_of(shade->tables, KERNEL)[4];
    double total = 0;
    for (size_t k = 0; k < 2 * SKY_STEPS; k++) {
        shade->twice[k] = heat[k % SKY_STEPS];
        shade->totals[k] = total;
        total += shade->twice[k];
    }
    for (size_t k = 0; k < SKY_STEPS; k++) moved[k] = 0;
    for (size_t l = 0; l < lags->count; l++) {
        double begin = lags->nodes[l], end = l + 1 < lags->count ? lags->nodes[l + 1] : lags->nodes[0] + DAY;
        const double *kernel = shade->kernel + l * SKY_STEPS;
        Lagged near = lagged(shade, begin), far = lagged(shade, end);
        VectorD scale = all_d(STEP / (end - begin));
        for (size_t k = 0; k < SKY_STEPS; k += DOUBLES)
            store_d(moved + k, load_d(moved + k) + load_d(kernel + k) * ((integral(&near, k) - integral(&far, k)) * scale));
    }
}

static void evaporation_of(Shade *shade) {
    size_t cell = 0;
    for (size_t k = 0; k < SKY_STEPS; k++)
        shade->evaporated[k] = table_at(shade, shade->evaporation, k, shade->start[k] + shade->moved[k], &cell);
}

/* Change of a dry face under `absorbed`; `base` is the heat loss without it. */
static void dry_change(Shade *shade, const double *absorbed, double lowest, double highest) {
    apply_kernel(shade, absorbed, shade->moved);
    for (size_t k = 0; k < SKY_STEPS; k++) shade->moved[k] = clipped(shade->moved[k], lowest, highest);
    for (int pass = 0; pass < CORRECTIONS; pass++) {
        size_t cell = 0;
        double *beyond = shade->light;
        for (size_t k = 0; k < SKY_STEPS; k++) {
            beyond[k] = loss_at(shade, k, shade->start[k] + shade->moved[k], 0, &cell, 0) - shade->base[k] - shade->slope[k] * shade->moved[k];
            shade->heat[k] = absorbed[k] - beyond[k];
        }
        apply_kernel(shade, shade->heat, shade->target);
        for (size_t k = 0; k < SKY_STEPS; k++) {
            /* Where the loss grows faster than its tangent the step is shortened, lest it overshoots. */
            double moved = shade->moved[k], steeper = moved != 0 ? beyond[k] / (shade->slope[k] * moved) : 0;
            shade->moved[k] = clipped(moved + (shade->target[k] - moved) / (1 + larger(steeper, 0)), lowest, highest);
        }
    }
}

/* Change of a face with a film. */
static void wet_change(Shade *shade, const double *absorbed) {
    const Film *film = &shade->film;
    WetDay *open = &shade->open, *day = &shade->day;
    size_t cell = 0;
    for (size_t k = 0; k < SKY_STEPS; k++) shade->moved[k] = 0;
    evaporation_of(shade);
    open_film(film, shade->evaporated, open);
    for (size_t k = 0; k < SKY_STEPS; k++)
        shade->base[k] += open->covered[k] * (table_at(shade, shade->film_loss, k, shade->start[k], &cell) - film->sunlight[k]);
    *day = *open;
    for (int pass = 0; pass <= CORRECTIONS; pass++) {
        double lowest = 0, highest = 0;
        size_t at = 0, balance = 0, moved_cell = 0;
        for (size_t k = 0; k < SKY_STEPS; k++) {
            double covered = day->covered[k], heat = absorbed[k] + covered * film_light(film, k, absorbed[k]);
            double surplus = heat - (loss_at(shade, k, shade->start[k], covered, &at, 0) - shade->base[k]);
            double balanced = offset_of(shade, k, shade->base[k] + heat, covered, &balance) - shade->start[k];
            if (surplus < 0) lowest = smaller(lowest, balanced);
            if (surplus > 0) highest = larger(highest, balanced);
            double loss = loss_at(shade, k, shade->start[k] + shade->moved[k], covered, &moved_cell, &shade->light[k]);
            shade->heat[k] = heat - (loss - shade->base[k] - shade->slope[k] * shade->moved[k]);
        }
        apply_kernel(shade, pass ? shade->heat : absorbed, shade->target);
        for (size_t k = 0; k < SKY_STEPS; k++) {
            double steeper = pass ? larger(shade->light[k] / shade->slope[k], 1) : 1;
            shade->moved[k] = clipped(shade->moved[k] + (shade->target[k] - shade->moved[k]) / steeper, lowest, highest);
        }
        day->start = pass && !is_finite(film->before) ? clipped(open->start + (day->end - open->end), 0, 1) : open->start;
        evaporation_of(shade);
        march_film(film, shade->evaporated, day);
    }
}

/* Read the film on a face; whether water stays on it. */
static int32_t read_film(Shade *shade, const double *face, const Columns *columns, size_t row, SkyFailure *failure) {
    const SkyTables *tables = shade->tables;
    const Array *arrays = tables->surface.arrays;
    size_t hours = axes_of(tables, KERNEL)[3].count, offsets = axes_of(tables, LOSS_EXCESS)[4].count;
    shade->wet = 0;
    if (!arrays[FILM_LOSS].values) return SKY_OK;
    int32_t status = read_array(&tables->surface, FILM_CAPACITY, face, row, &shade->film.capacity, failure);
    if (status || !(shade->film.capacity > 0)) return status;
    double cosine;
    shade->wet = 1;
    sine_and_cosine(face[SLOPE], &cosine);
    shade->film.before = NOT_A_NUMBER;
    if (arrays[FILM_BEFORE].values) mix(tables, FILM_BEFORE, columns, 1, &shade->film.before);
    mix(tables, FILM_LOSS, columns, hours * offsets, shade->film_loss);
    mix(tables, FILM_EVAPORATION, columns, hours * offsets, shade->evaporation);
    mix(tables, FILM_SUNLIGHT, columns, hours, shade->slope_hours);
    through_the_day(shade, shade->slope_hours, shade->film.sunlight);
    mix(tables, DRY_SUNLIGHT, columns, hours, shade->slope_hours);
    through_the_day(shade, shade->slope_hours, shade->film.dry_sunlight);
    for (size_t k = 0; k < SKY_STEPS; k++) shade->film.rain[k] = larger(cosine, 0) * corner_sum(&arrays[RAIN], &shade->forcing[k]);
    return SKY_OK;
}

/* Temperatures of a face in the open at the steps of the day; NaN where the table has none. */
static int32_t sunlit_day(const Shade *shade, const double *face, size_t row, double *sunlit, SkyFailure *failure) {
    const Array *array = &shade->tables->surface.arrays[TEMPERATURE];
    size_t times = array->axes[TIME].count, corner[8] = {0};
    double weight[8] = {1};
    for (int k = 0, corners = 1; k < TIME; k++) {
        Place place;
        int32_t status = find(&array->axes[k], face[k], SKY_SURFACE, row, &place, failure);
        if (status) return status;
        for (int c = 0; c < corners; c++) {
            if (k != MATERIAL) corner[corners + c] = corner[c] * array->axes[k].count + place.upper, weight[corners + c] = weight[c] * place.weight;
            corner[c] = corner[c] * array->axes[k].count + place.lower;
            weight[c] *= 1 - place.weight;
        }
        if (k != MATERIAL) corners *= 2;
    }
    for (size_t t = 0; t < times; t++) {
        double sum = 0;
        for (int c = 0; c < 8; c++)
            if (weight[c] != 0) sum += weight[c] * array->values[corner[c] * times + t];
        shade->day_nodes[t] = sum;
    }
    for (size_t k = 0; k < SKY_STEPS; k++) sunlit[k] = shade->hours_there[k] ? at_step(shade->day_nodes, &shade->time[k]) : NOT_A_NUMBER;
    return SKY_OK;
}

/* Change of temperature, in `moved`, by a change of absorbed heat, of which what ends melting is taken. */
static int32_t change(Shade *shade, const double *face, double *absorbed, const double *sunlit, double limit, size_t row, SkyFailure *failure) {
    const SkyTables *tables = shade->tables;
    const Axis *axes = axes_of(tables, KERNEL);
    size_t hours = axes[3].count, lags = axes[4].count, offsets = axes_of(tables, LOSS_EXCESS)[4].count, cell = 0, balance = 0;
    Columns columns;
    int32_t status = columns_of(tables, face, row, &columns, failure);
    if (!status) status = read_film(shade, face, &columns, row, failure);
    if (status) return status;
    mix(tables, KERNEL, &columns, hours * lags, shade->kernel_hours);
    mix(tables, LOSS_EXCESS, &columns, hours * offsets, shade->excess);
    mix(tables, LOSS_SLOPE, &columns, hours, shade->slope_hours);
    through_the_day(shade, shade->slope_hours, shade->slope);
    mix(tables, REFERENCE, &columns, hours, shade->slope_hours);
    through_the_day(shade, shade->slope_hours, shade->start);
    mix(tables, MELT, &columns, hours, shade->slope_hours);
    through_the_day(shade, shade->slope_hours, shade->target);
    for (size_t l = 0; l < lags; l++)
        for (size_t k = 0; k < SKY_STEPS; k++) {
            const Place *hour = &shade->hour[k];
            shade->kernel[l * SKY_STEPS + k] = (1 - hour->weight) * shade->kernel_hours[hour->lower * lags + l] +
                                               hour->weight * shade->kernel_hours[hour->upper * lags + l];
        }
    for (size_t k = 0; k < SKY_STEPS; k++) {
        shade->start[k] = is_finite(sunlit[k]) ? sunlit[k] - shade->start[k] : 0;
        if (sunlit[k] >= limit - MELTING_RANGE) absorbed[k] = smaller(absorbed[k] + shade->target[k], 0);
    }
    double lowest = 0, highest = 0;
    for (size_t k = 0; k < SKY_STEPS; k++) {
        shade->base[k] = loss_at(shade, k, shade->start[k], 0, &cell, 0);
        double balanced = offset_of(shade, k, shade->base[k] + absorbed[k], 0, &balance) - shade->start[k];
        if (absorbed[k] < 0) lowest = smaller(lowest, balanced);
        if (absorbed[k] > 0) highest = larger(highest, balanced);
    }
    if (shade->wet)
        wet_change(shade, absorbed);
    else
        dry_change(shade, absorbed, lowest, highest);
    return SKY_OK;
}

/* Means over the steps of the day of values that are means over other equal steps. */
static double mean_between(const double *values, size_t count, double begin, double end) {
    double sum = 0, steps = (double)count / DAY, from = begin * steps + 0.5, to = end * steps + 0.5;
    for (double whole = floor_of(from); whole < to; whole += 1) {
        double within = whole - (double)count * floor_of(whole / (double)count);
        sum += (smaller(to, whole + 1) - larger(from, whole)) * values[(size_t)clipped(within, 0, (double)count - 1)];
    }
    return sum / (to - from);
}

static void face_of(const SkyFaces *faces, size_t i, double *face) {
    face[MATERIAL] = faces->material[i];
    face[ALTITUDE] = faces->altitude[i];
    face[AZIMUTH] = faces->azimuth[i];
    face[SLOPE] = faces->slope[i];
}

static int32_t limit_of(const SkyTables *tables, const double *face, size_t row, double *limit, SkyFailure *failure) {
    return read_array(&tables->surface, HIGHEST, face, row, limit, failure);
}

/* Temperature at the time of a face after `change`. */
static int32_t moved_temperature(const Shade *shade, const double *face, double limit, size_t row, double *kelvin, SkyFailure *failure) {
    double sunlit, day = face[TIME] / DAY, place = (day - floor_of(day)) * SKY_STEPS, whole = floor_of(place);
    int32_t status = read_array(&shade->tables->surface, TEMPERATURE, face, row, &sunlit, failure);
    if (status) return status;
    size_t before = (size_t)clipped(whole, 0, SKY_STEPS - 1), after = before + 1 < SKY_STEPS ? before + 1 : 0;
    double moved = shade->moved[before] * (1 - (place - whole)) + shade->moved[after] * (place - whole);
    *kelvin = moved == 0 ? sunlit : smaller(sunlit + moved, larger(limit, sunlit));
    return SKY_OK;
}

int32_t SKYSHINE_NAME(skyshine_heated)(const SkyTables *tables, size_t count, const SkyFaces *faces, const double *absorbed,
                                       size_t steps, const double *hours, size_t times, double *temperature, void *scratch,
                                       SkyFailure *failure);
SKYSHINE_EXPORT int32_t SKYSHINE_NAME(skyshine_heated)(const SkyTables *tables, size_t count, const SkyFaces *faces, const double *absorbed,
                                       size_t steps, const double *hours, size_t times, double *temperature, void *scratch,
                                       SkyFailure *failure) {
    Shade *shade = scratch;
    double face[5], limit = 0;
    int32_t status = steps ? begin(shade, tables, failure) : SKY_OK;
    for (size_t i = 0; i < count && !status; i++) {
        face_of(faces, i, face);
        const double *heat = absorbed + i * steps;
        for (size_t k = 0; k < steps; k++)
            if (!is_finite(heat[k])) return refuse(failure, SKY_NOT_FINITE, SKY_SURFACE, i, "absorbed_change", heat[k], 0, 0);
        for (size_t k = 0; k < SKY_STEPS && steps; k++)
            shade->own[k] = steps == SKY_STEPS ? heat[k] : mean_between(heat, steps, ((double)k - 0.5) * STEP, ((double)k + 0.5) * STEP);
        if (steps) status = limit_of(tables, face, i, &limit, failure);
        if (steps && !status) status = sunlit_day(shade, face, i, shade->sunlit, failure);
        if (steps && !status) status = change(shade, face, shade->own, shade->sunlit, limit, i, failure);
        for (size_t t = 0; t < times && !status; t++) {
            face[TIME] = hours[i * times + t];
            status = steps ? moved_temperature(shade, face, limit, i, &temperature[i * times + t], failure)
                           : read_array(&tables->surface, TEMPERATURE, face, i, &temperature[i * times + t], failure);
        }
    }
    return status;
}

int32_t SKYSHINE_NAME(skyshine_changes)(const SkyTables *tables, size_t count, const SkyFaces *faces, const double *absorbed,
                                        const double *temperature, const double *highest, double *moved, void *scratch, SkyFailure *failure);
SKYSHINE_EXPORT int32_t SKYSHINE_NAME(skyshine_changes)(const SkyTables *tables, size_t count, const SkyFaces *faces, const double *absorbed,
                                        const double *temperature, const double *highest, double *moved, void *scratch, SkyFailure *failure) {
    Shade *shade = scratch;
    double face[5];
    int32_t status = begin(shade, tables, failure);
    for (size_t i = 0; i < count && !status; i++) {
        face_of(faces, i, face);
        for (size_t k = 0; k < SKY_STEPS; k++) shade->own[k] = absorbed[i * SKY_STEPS + k];
        status = change(shade, face, shade->own, temperature + i * SKY_STEPS, highest[i], i, failure);
        for (size_t k = 0; k < SKY_STEPS && !status; k++) moved[i * SKY_STEPS + k] = shade->moved[k];
    }
    return status;
}

/* ---- Heat from light and longwave ---- */

/* The Sun at the steps of the day. */
static void place_sun(Shade *shade) {
    const Array *arrays = shade->tables->surface.arrays;
    for (size_t k = 0; k < SKY_STEPS; k++) {
        shade->sine_up[k] = corner_sum(&arrays[SOLAR_ELEVATION], &shade->forcing[k]);
        shade->sine_turn[k] = corner_sum(&arrays[SOLAR_AZIMUTH], &shade->forcing[k]);
        shade->aureole[k] = corner_sum(&arrays[AUREOLE], &shade->forcing[k]);
    }
    for (size_t k = 0; k < SKY_STEPS; k += DOUBLES) {
        VectorD up, level, sine, cosine;
        sine_and_cosine_d(load_d(shade->sine_up + k), &up, &level);
        sine_and_cosine_d(load_d(shade->sine_turn + k), &sine, &cosine);
        store_d(shade->sine_up + k, up), store_d(shade->cosine_up + k, level);
        store_d(shade->sine_turn + k, sine), store_d(shade->cosine_turn + k, cosine);
    }
}

static int32_t begin_light(Shade *shade, const SkyTables *tables, SkyFailure *failure) {
    int32_t status = begin(shade, tables, failure);
    if (!status && !tables->surface.arrays[AUREOLE].values)
        status = refuse(failure, SKY_NO_RESPONSE, SKY_SURFACE, 0, "aureole_share", 0, 0, 0);
    if (!status) place_sun(shade);
    return status;
}

/* What surrounds a face. */
typedef struct {
    const double *shaded;
    double sky_view, facing, facing_emissivity;
} Around;

static double fourth_power(double x) { return x * x * (x * x); }

/* Light, longwave and air at an altitude, through the day; as before where it is the same. */
static int32_t light_at(Shade *shade, double altitude, size_t row, SkyFailure *failure) {
    const Array *arrays = shade->tables->surface.arrays;
    const Axis *altitudes = &arrays[AIR_TEMPERATURE].axes[0];
    Place place[2];
    if (altitude == shade->light_altitude) return SKY_OK;
    int32_t status = find(altitudes, bounded(altitudes, altitude), SKY_SURFACE, row, &place[0], failure);
    if (status) return status;
    for (size_t k = 0; k < SKY_STEPS; k++) {
        place[1] = shade->forcing[k];
        shade->normal[k] = corner_sum(&arrays[DIRECT_NORMAL], place);
        shade->diffuse[k] = corner_sum(&arrays[DIFFUSE], place);
        shade->sky[k] = corner_sum(&arrays[LONGWAVE], place);
        shade->air[k] = corner_sum(&arrays[AIR_TEMPERATURE], place);
    }
    shade->light_altitude = altitude;
    return SKY_OK;
}

/* Heat that a face absorbs more than in the open, from the sky that surroundings leave; sunlight that reaches it less. */
static int32_t of_the_sky(Shade *shade, const double *face, const Around *around, size_t row, double *absorbed, double *light, SkyFailure *failure) {
    const SkyDatabase *surface = &shade->tables->surface;
    double absorbs, emits, cosine, cosine_face, low_cosine, lowest = sine_and_cosine(LOWEST_AUREOLE, &low_cosine);
    double sine = sine_and_cosine(face[SLOPE], &cosine), sine_face = sine_and_cosine(face[AZIMUTH], &cosine_face);
    double view = 0.5 * (1 + cosine), open = around->sky_view, emissivity = around->facing_emissivity;
    int32_t status = read_array(surface, ABSORPTANCE, face, row, &absorbs, failure);
    if (!status) status = read_array(surface, EMISSIVITY, face, row, &emits, failure);
    if (!status) status = light_at(shade, face[ALTITUDE], row, failure);
    if (status) return status;
    for (size_t k = 0; k < SKY_STEPS; k++) {
        double normal = shade->normal[k], level = shade->diffuse[k], sky = shade->sky[k];
        double towards = shade->cosine_turn[k] * cosine_face + shade->sine_turn[k] * sine_face; /* cosine of the azimuth from the face's */
        double up = shade->sine_up[k], incidence = larger(cosine * up + sine * shade->cosine_up[k] * towards, 0);
        double above = larger(up, lowest), beside = up > lowest ? shade->cosine_up[k] : low_cosine;
        double aureole = shade->aureole[k], spread = (1 - aureole) * view * level;
        double beam = normal * incidence + aureole * level * (larger(cosine * above + sine * beside * towards, 0) / above);
        double air = STEFAN_BOLTZMANN * fourth_power(shade->air[k]);
        double emitted = is_finite(around->facing) ? STEFAN_BOLTZMANN * fourth_power(around->facing) : air;
        double wall = emissivity * emitted + (1 - emissivity) * (sky + air) / 2;
        light[k] = -(around->shaded[k] * beam + (1 - open) * spread);
        absorbed[k] = emits * (1 - open) * view * (wall - sky) + absorbs * light[k];
    }
    return SKY_OK;
}

/* Heat (in `ground`) and light (in `sunlight`) that level ground with the same surroundings sends more, per unit of view. */
static int32_t before_ground(Shade *shade, double altitude, const Around *around, size_t row, SkyFailure *failure) {
    const SkyTables *tables = shade->tables;
    const Axis *axes = axes_of(tables, TEMPERATURE);
    const double *numbers = tables->surface.numbers;
    double level[] = {numbers[SKY_GROUND_CODE], bounded(&axes[ALTITUDE], altitude), axes[AZIMUTH].nodes[0], 0, 0}, limit;
    int32_t status = limit_of(tables, level, row, &limit, failure);
    if (!status) status = of_the_sky(shade, level, around, row, shade->own, shade->sunlight, failure);
    if (!status) status = sunlit_day(shade, level, row, shade->sunlit, failure);
    if (!status) status = change(shade, level, shade->own, shade->sunlit, limit, row, failure);
    for (size_t k = 0; k < SKY_STEPS && !status; k++) {
        double sunlit = shade->sunlit[k];
        shade->ground[k] = 0;
        if (!shade->hours_there[k]) continue;
        double kelvin = smaller(sunlit + shade->moved[k], larger(limit, sunlit));
        shade->ground[k] = numbers[SKY_GROUND_EMISSIVITY] * STEFAN_BOLTZMANN * (fourth_power(kelvin) - fourth_power(sunlit));
    }
    shade->ground_altitude = altitude;
    return status;
}

/* `again`: the surroundings are those of the face before. */
static int32_t absorbed_of(Shade *shade, const double *face, const Around *around, int again, size_t row, double *absorbed, SkyFailure *failure) {
    const SkyTables *tables = shade->tables;
    int known = tables->surface.numbers[SKY_GROUND_CODE] > 0 && axes_of(tables, TEMPERATURE)[SLOPE].first <= 0;
    int endless = around->facing == around->facing && !is_finite(around->facing);
    if (!is_finite(around->sky_view) || endless || !is_finite(around->facing_emissivity))
        return refuse(failure, SKY_NOT_FINITE, SKY_SURFACE, row, "surroundings", around->sky_view, 0, 0);
    for (size_t k = 0; k < SKY_STEPS; k++)
        if (!is_finite(around->shaded[k])) return refuse(failure, SKY_NOT_FINITE, SKY_SURFACE, row, "surroundings", around->shaded[k], 0, 0);
    if (!(face[SLOPE] > 0) || !known) return of_the_sky(shade, face, around, row, absorbed, shade->light, failure);
    double cosine, absorbs, emits;
    int32_t status = again && shade->ground_altitude == face[ALTITUDE] ? SKY_OK : before_ground(shade, face[ALTITUDE], around, row, failure);
    if (!status) status = of_the_sky(shade, face, around, row, absorbed, shade->light, failure);
    if (!status) status = read_array(&tables->surface, ABSORPTANCE, face, row, &absorbs, failure);
    if (!status) status = read_array(&tables->surface, EMISSIVITY, face, row, &emits, failure);
    if (status) return status;
    sine_and_cosine(face[SLOPE], &cosine);
    double below = (1 - cosine) / 2, albedo = tables->surface.numbers[SKY_GROUND_ALBEDO];
    for (size_t k = 0; k < SKY_STEPS; k++)
        absorbed[k] += below * (absorbs * albedo * shade->sunlight[k] + emits * shade->ground[k]);
    return SKY_OK;
}

int32_t SKYSHINE_NAME(skyshine_absorbed)(const SkyTables *tables, size_t count, const SkyFaces *faces, const SkySurroundings *around,
                                         int32_t each, double *absorbed, void *scratch, SkyFailure *failure);
SKYSHINE_EXPORT int32_t SKYSHINE_NAME(skyshine_absorbed)(const SkyTables *tables, size_t count, const SkyFaces *faces, const SkySurroundings *around,
                                         int32_t each, double *absorbed, void *scratch, SkyFailure *failure) {
    Shade *shade = scratch;
    double face[5] = {0};
    int32_t status = begin_light(shade, tables, failure);
    for (size_t i = 0; i < count && !status; i++) {
        size_t row = each ? i : 0;
        Around of = {around->shaded + row * SKY_STEPS, around->sky_view[row], around->facing ? around->facing[row] : NOT_A_NUMBER,
                     around->facing_emissivity ? around->facing_emissivity[row] : NOT_A_NUMBER};
        if (!(of.facing_emissivity == of.facing_emissivity)) of.facing_emissivity = WALL_EMISSIVITY;
        face_of(faces, i, face);
        status = absorbed_of(shade, face, &of, i && !each, i, absorbed + i * SKY_STEPS, failure);
    }
    return status;
}

int32_t SKYSHINE_NAME(skyshine_shaded)(const SkyTables *tables, const double *face, double sky_view, size_t row, double *kelvin,
                                       void *scratch, SkyFailure *failure) {
    Shade *shade = scratch;
    double heat[SKY_STEPS], all_day[SKY_STEPS], limit;
    Around around = {all_day, sky_view, NOT_A_NUMBER, WALL_EMISSIVITY};
    for (size_t k = 0; k < SKY_STEPS; k++) all_day[k] = 1;
    int32_t status = begin_light(shade, tables, failure);
    if (!status) status = absorbed_of(shade, face, &around, 0, row, heat, failure);
    if (!status) status = limit_of(tables, face, row, &limit, failure);
    if (!status) status = sunlit_day(shade, face, row, shade->sunlit, failure);
    if (!status) status = change(shade, face, heat, shade->sunlit, limit, row, failure);
    return status ? status : moved_temperature(shade, face, limit, row, kelvin, failure);
}
