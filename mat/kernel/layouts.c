/* What the files of each kind must have, and the databases that a caller fills from them. */
#include "export.h"
#include "pixel_tables.h"

typedef struct {
    const char *name;
    const char *axes[SKY_AXES];
    double least, most;
    int32_t group;
} Layout;

#define ANY -INFINITE, INFINITE
#define COLUMN "material", "response_altitude", "response_slope", "response_hour"
static const Layout SURFACE[] = {
    {"temperature", {"material", "altitude", "azimuth", "slope", "time"}, 1, 1e4, 0},
    {"response_kernel", {COLUMN, "lag"}, ANY, 1},
    {"response_temperature", {COLUMN}, 0, 1e4, 1},
    {"heat_loss_slope", {COLUMN}, 1e-6, INFINITE, 1},
    {"heat_loss_excess", {COLUMN, "temperature_offset"}, ANY, 1},
    {"solar_absorptance", {"material"}, 0, 1, 5},
    {"thermal_emissivity", {"material"}, 0, 1, 5},
    {"melting_heat", {COLUMN}, 0, INFINITE, 1},
    {"highest_temperature", {"material"}, 1, 1e4, 1},
    {"direct_normal_irradiance", {"altitude", "forcing_time"}, 0, INFINITE, 5},
    {"diffuse_irradiance", {"altitude", "forcing_time"}, 0, INFINITE, 5},
    {"sky_irradiance", {"altitude", "forcing_time"}, 0, INFINITE, 5},
    {"air_temperature", {"altitude", "forcing_time"}, 1, 1e4, 5},
    {"solar_elevation", {"forcing_time"}, -90, 90, 5},
    {"solar_azimuth", {"forcing_time"}, -360, 360, 5},
    {"aureole_share", {"forcing_time"}, 0, 1, 5},
    {"film_heat_loss", {COLUMN, "temperature_offset"}, ANY, 2},
    {"film_evaporation", {COLUMN, "temperature_offset"}, ANY, 2},
    {"film_sunlight", {COLUMN}, ANY, 2},
    {"absorbed_sunlight", {COLUMN}, 0, INFINITE, 2},
    {"film_capacity", {"material"}, 0, INFINITE, 2},
    {"rain", {"forcing_time"}, 0, INFINITE, 2},
    {"film_before", {"material", "response_altitude", "response_slope"}, 0, INFINITE, 3},
    {"sun_elevation", {"track_time"}, -90, 90, 4},
    {"sun_azimuth", {"track_time"}, -1080, 1080, 4},
    {"sun_distance", {"track_time"}, 0.9, 1.1, 4},
    {"moon_elevation", {"track_time"}, -90, 90, 4},
    {"moon_azimuth", {"track_time"}, -1080, 1080, 4},
    {"moon_distance", {"track_time"}, 3e5, 4.5e5, 4},
    {"moon_phase_angle", {"track_time"}, 0, 180, 4},
    {"moon_illuminated_fraction", {"track_time"}, 0, 1, 4},
    {0},
};
static const Layout BAND[] = {
    {"blackbody_radiance", {"temperature"}, 0, INFINITE, 0},
    {"reflectance", {"material"}, 0, 1, 0},
    {"specular_fraction", {"material"}, 0, 1, 0},
    {"shininess", {"material"}, 0, INFINITE, 0},
    {"normalisation", {"material"}, 0, INFINITE, 0},
    {"reflectance_spectrum", {"material", "band_wavelength"}, 0, 1, 0},
    {"emission_share", {"planck_temperature", "band_wavelength"}, 0, 1.00001, 0},
    {0},
};
#define RAY "share", "height_root", "direction"
static const Layout AIR[] = {
    {"effective_radius", {"height_root"}, 1e-3, INFINITE, 0},
    {"log_mean_extinction", {"absorber", RAY}, -200, 200, 0},
    {"absorber_factor", {"channel", "absorber"}, ANY, 0},
    {"channel_weight", {"channel"}, 0, 1.00001, 0},
    {"thermal_reference", {"channel"}, 0, INFINITE, 0},
    {"thermal_ratio", {RAY}, 0, INFINITE, 0},
    {"source_reference", {"channel"}, 0, INFINITE, 0},
    {"scattered_ratio", {"source_part", RAY}, ANY, 0},
    {"source_factor", {"source_part", "source_elevation", "scattering_angle"}, ANY, 0},
    {"source_rise", {"target_height"}, -90, 90, 0},
    {"direct_light", {"direct_light_part", "target_height", "elevation_above_rise"}, ANY, 0},
    {"direct_light_factor", {"channel", "direct_light_part"}, ANY, 0},
    {"thermal_sky", {"thermal_sky_part", "surface_height"}, ANY, 0},
    {"thermal_sky_factor", {"channel", "thermal_sky_part"}, ANY, 0},
    {"scattered_sky", {"scattered_sky_part", "surface_height", "sky_source_elevation"}, ANY, 0},
    {"scattered_sky_factor", {"channel", "scattered_sky_part"}, ANY, 0},
    {"thermal_wavelength_share", {"channel", "band_wavelength"}, 0, 1.00001, 0},
    {"source_wavelength_share", {"channel", "band_wavelength"}, 0, 1.00001, 0},
    {"thermal_harmonics", {"thermal_harmonics_part", "surface_height", "harmonic"}, ANY, 1},
    {"thermal_harmonics_factor", {"channel", "thermal_harmonics_part"}, ANY, 1},
    {"scattered_harmonics", {"scattered_harmonics_part", "surface_height", "sky_source_elevation", "harmonic"}, ANY, 1},
    {"scattered_harmonics_factor", {"channel", "scattered_harmonics_part"}, ANY, 1},
    {"ground_harmonics", {"ground_harmonics_part", "surface_height", "zonal_harmonic"}, ANY, 1},
    {"ground_harmonics_factor", {"channel", "ground_harmonics_part"}, ANY, 1},
    {"ground_emission", {"ground_temperature", "channel"}, 0, INFINITE, 1},
    {"end_rise", {RAY}, -1, 1, 2},
    {0},
};
static const Layout *const LAYOUTS[] = {SURFACE, BAND, AIR};

/* How the format reads axes; all others are linear, without a period. */
static const struct {
    const char *name;
    int32_t rule, or_rule;
    double period;
} RULES[] = {
    {"material", SKY_EXACT, SKY_EXACT, 0},          {"harmonic", SKY_EXACT, SKY_EXACT, 0},
    {"zonal_harmonic", SKY_EXACT, SKY_EXACT, 0},    {"channel", SKY_EXACT, SKY_EXACT, 0},
    {"absorber", SKY_EXACT, SKY_EXACT, 0},          {"source_part", SKY_EXACT, SKY_EXACT, 0},
    {"direct_light_part", SKY_EXACT, SKY_EXACT, 0}, {"thermal_sky_part", SKY_EXACT, SKY_EXACT, 0},
    {"scattered_sky_part", SKY_EXACT, SKY_EXACT, 0}, {"thermal_harmonics_part", SKY_EXACT, SKY_EXACT, 0},
    {"scattered_harmonics_part", SKY_EXACT, SKY_EXACT, 0}, {"ground_harmonics_part", SKY_EXACT, SKY_EXACT, 0},
    {"azimuth", SKY_PERIODIC, SKY_PERIODIC, 360},   {"time", SKY_PERIODIC, SKY_LINEAR, 24},
    {"response_hour", SKY_PERIODIC, SKY_PERIODIC, 24}, {"forcing_time", SKY_PERIODIC, SKY_PERIODIC, 24},
    {0, SKY_LINEAR, SKY_LINEAR, 0},
};
/* Read at the nearest node outside, whatever the file says: the coordinates of lines were bounded before. */
static const char *const INNER[] = {"share", "height_root", "direction", "surface_height", "target_height",
                                    "elevation_above_rise", "planck_temperature", 0};
static const double CODES[HARMONICS] = {0, 10, 11, 20, 21, 22, 40, 41, 42, 43, 44}, ZONAL_CODES[ZONAL] = {0, 10, 20, 40};
static const double LAST_CODE = 65535;
static const double TOP_KM = 100, FARTHEST_KM = 100000; /* where air ends; of observers in space */
static const double SUM_TOLERANCE = 1e-5; /* of shares in single precision */

static int same(const char *a, const char *b) {
    while (*a && *a == *b) a++, b++;
    return *a == *b;
}

SKYSHINE_EXPORT size_t skyshine_database_size(void) { return sizeof(SkyDatabase); }

SKYSHINE_EXPORT void skyshine_database_begin(SkyDatabase *database, int32_t kind) {
    *database = (SkyDatabase){.kind = kind};
    for (int k = 0; k < SKY_NUMBERS; k++) database->numbers[k] = k < SKY_CLAMP_RANGE ? NOT_A_NUMBER : 0;
}

SKYSHINE_EXPORT const char *skyshine_array_name(int32_t kind, int32_t array) { return LAYOUTS[kind][array].name; }
SKYSHINE_EXPORT int32_t skyshine_array_group(int32_t kind, int32_t array) { return LAYOUTS[kind][array].group; }
SKYSHINE_EXPORT const char *skyshine_axis_name(int32_t kind, int32_t array, int32_t axis) {
    return axis < SKY_AXES ? LAYOUTS[kind][array].axes[axis] : 0;
}

SKYSHINE_EXPORT void skyshine_set_array(SkyDatabase *database, int32_t array, const float *values) {
    Array *of = &database->arrays[array];
    of->values = values;
    while (of->rank < SKY_AXES && LAYOUTS[database->kind][array].axes[of->rank]) of->rank++;
}

SKYSHINE_EXPORT void skyshine_set_axis(SkyDatabase *database, int32_t array, int32_t axis, const double *nodes, size_t count,
                                       int32_t rule, double period, double dark_below, int32_t clamps) {
    const char *name = LAYOUTS[database->kind][array].axes[axis];
    for (int k = 0; INNER[k]; k++) clamps |= same(INNER[k], name);
    database->arrays[array].axes[axis] = (Axis){.name = name, .nodes = nodes, .count = count, .period = period,
                                                .dark_below = dark_below, .rule = rule, .clamps = clamps};
}

SKYSHINE_EXPORT void skyshine_set_number(SkyDatabase *database, int32_t number, double value) {
    if (number == SKY_ALTITUDE_LAST && value >= TOP_KM) value = FARTHEST_KM; /* it serves observers in space */
    database->numbers[number] = value;
}

SKYSHINE_EXPORT int32_t skyshine_has(const SkyDatabase *database, const char *array) {
    const Layout *layout = LAYOUTS[database->kind];
    for (int32_t i = 0; layout[i].name; i++)
        if (same(layout[i].name, array)) return database->arrays[i].values != 0;
    return 0;
}

static int32_t check_axis(const SkyDatabase *database, const Axis *axis, SkyFailure *failure) {
    int rule = 0;
    while (RULES[rule].name && !same(RULES[rule].name, axis->name)) rule++;
    int known = axis->nodes && axis->count && (axis->rule == RULES[rule].rule || axis->rule == RULES[rule].or_rule);
    known = known && axis->period == RULES[rule].period;
    for (size_t i = 0; known && i < axis->count; i++)
        known = is_finite(axis->nodes[i]) && (!i || axis->nodes[i] > axis->nodes[i - 1]);
    double first = known ? axis->nodes[0] : 0, last = known ? axis->nodes[axis->count - 1] : 0;
    if (axis->rule == SKY_PERIODIC) known = known && last < first + axis->period;
    if (axis->period > 0) known = known && last <= first + axis->period;
    int zonal = same(axis->name, "zonal_harmonic");
    if (zonal || same(axis->name, "harmonic")) {
        known = known && (zonal ? axis->count == 3 || axis->count == ZONAL : axis->count == 6 || axis->count == HARMONICS);
        for (size_t i = 0; known && i < axis->count; i++) known = axis->nodes[i] == (zonal ? ZONAL_CODES : CODES)[i];
    } else if (axis->rule == SKY_EXACT) {
        known = known && first >= 1 && last <= LAST_CODE;
    }
    if (same(axis->name, "source_elevation")) known = known && axis->dark_below >= -90 && axis->dark_below <= 0;
    if (known) return SKY_OK;
    return refuse(failure, SKY_NODES, database->kind, 0, axis->name, NOT_A_NUMBER, first, last);
}

/* An axis is the same in all arrays. */
static int32_t check_same(const SkyDatabase *database, const Axis *axis, SkyFailure *failure) {
    for (int32_t i = 0; i < SKY_ARRAYS; i++)
        for (int32_t k = 0; k < database->arrays[i].rank; k++) {
            const Axis *other = &database->arrays[i].axes[k];
            int equal = !same(other->name, axis->name) || other->count == axis->count;
            for (size_t n = 0; equal && n < axis->count && same(other->name, axis->name); n++) equal = other->nodes[n] == axis->nodes[n];
            if (!equal) return refuse(failure, SKY_NODES, database->kind, 0, axis->name, NOT_A_NUMBER, 0, 0);
        }
    return SKY_OK;
}

static int32_t check_values(const SkyDatabase *database, int32_t number, SkyFailure *failure) {
    const Layout *layout = &LAYOUTS[database->kind][number];
    const Array *array = &database->arrays[number];
    size_t count = 1;
    for (int32_t k = 0; k < array->rank; k++) count *= array->axes[k].count;
    for (size_t i = 0; i < count; i++) {
        double value = array->values[i];
        if (!is_finite(value) || value < layout->least || value > layout->most)
            return refuse(failure, SKY_VALUES, database->kind, i, layout->name, value, layout->least, layout->most);
    }
    return SKY_OK;
}

/* Rows of shares sum to 1. */
static int32_t check_sums(const SkyDatabase *database, int32_t number, SkyFailure *failure) {
    const Array *array = &database->arrays[number];
    size_t rows = array->rank > 1 ? array->axes[0].count : 1, count = array->axes[array->rank - 1].count;
    for (size_t i = 0; i < rows; i++) {
        double sum = 0;
        for (size_t b = 0; b < count; b++) sum += array->values[i * count + b];
        if (!(sum - 1 <= SUM_TOLERANCE && 1 - sum <= SUM_TOLERANCE))
            return refuse(failure, SKY_SUM, database->kind, i, LAYOUTS[database->kind][number].name, sum, 1, 1);
    }
    return SKY_OK;
}

static int32_t check_number(const SkyDatabase *database, int32_t number, const char *name, double least, double most,
                            SkyFailure *failure) {
    double value = database->numbers[number];
    if (value >= least && value <= most) return SKY_OK;
    return refuse(failure, SKY_NUMBER, database->kind, 0, name, value, least, most);
}

static int32_t check_air(const SkyDatabase *air, SkyFailure *failure) {
    const struct {
        int32_t number;
        const char *name;
        double least, most;
    } NUMBERS[] = {
        {SKY_GROUND_ALTITUDE, "ground_altitude_km", -1, 10},
        {SKY_SCALE_HEIGHT, "scale_height_km", 1e-12, 1000},
        {SKY_RANGE_FIRST, "range_km", 0, 1e9},
        {SKY_RANGE_LAST, "range_km", air->numbers[SKY_RANGE_FIRST], 1e9},
        {SKY_ALTITUDE_FIRST, "altitude_km", -1, 1e9},
        {SKY_ALTITUDE_LAST, "altitude_km", air->numbers[SKY_ALTITUDE_FIRST], 1e9},
        {SKY_GROUND_EMISSIVITY, "ground_emissivity", 0, 1e300},
        {SKY_GROUND_TEMPERATURE, "ground_temperature", 0, 1e300},
        {SKY_GROUND_RADIANCE, "ground_radiance", 0, 1e300},
    };
    int tilted = air->arrays[SCATTERED_HARMONICS].values != 0;
    for (int k = 0; k < (tilted ? 9 : 6); k++) {
        int32_t status = check_number(air, NUMBERS[k].number, NUMBERS[k].name, NUMBERS[k].least, NUMBERS[k].most, failure);
        if (status) return status;
    }
    int32_t status = check_sums(air, CHANNEL_WEIGHT, failure);
    if (!status) status = check_sums(air, THERMAL_SHARE, failure);
    if (!status) status = check_sums(air, SOURCE_SHARE, failure);
    if (status || !tilted) return status;
    const Axis *codes = &air->arrays[SCATTERED_HARMONICS].axes[3], *zonal = &air->arrays[GROUND_HARMONICS].axes[2];
    if ((codes->count == 6) == (zonal->count == 3)) return SKY_OK;
    return refuse(failure, SKY_NODES, SKY_AIR, 0, zonal->name, NOT_A_NUMBER, 0, 0);
}

/* Whether a database has an array of a group. */
static int has_group(const SkyDatabase *database, int32_t group) {
    const Layout *layout = LAYOUTS[database->kind];
    for (int32_t i = 0; layout[i].name; i++)
        if (layout[i].group == group && database->arrays[i].values) return 1;
    return 0;
}

int32_t skyshine_groups_check(const SkyDatabase *database, SkyFailure *failure) {
    const Layout *layout = LAYOUTS[database->kind];
    for (int32_t i = 0; layout[i].name; i++)
        if (!database->arrays[i].values && has_group(database, layout[i].group))
            return refuse(failure, SKY_LACKS, database->kind, 0, layout[i].name, 0, 0, 0);
    return SKY_OK;
}

SKYSHINE_EXPORT int32_t skyshine_database_check(const SkyDatabase *database, SkyFailure *failure) {
    const Layout *layout = LAYOUTS[database->kind];
    int32_t lacking = skyshine_groups_check(database, failure);
    if (lacking) return lacking;
    for (int32_t i = 0; layout[i].name; i++) {
        const Array *array = &database->arrays[i];
        int needed = layout[i].group == 0;
        if (database->kind == SKY_SURFACE) {
            /* Light and response are of no use without each other; a film needs both, what was on it before the film. */
            if (layout[i].group == 1 || layout[i].group == 5) needed = has_group(database, 1) || has_group(database, 5) || has_group(database, 2);
            if (layout[i].group == 2) needed = has_group(database, 3);
        }
        if (!array->values && needed) return refuse(failure, SKY_LACKS, database->kind, 0, layout[i].name, 0, 0, 0);
        if (!array->values) continue;
        for (int32_t k = 0; k < array->rank; k++) {
            int32_t status = check_axis(database, &array->axes[k], failure);
            if (!status) status = check_same(database, &array->axes[k], failure);
            if (status) return status;
        }
        int32_t status = check_values(database, i, failure);
        if (status) return status;
    }
    if (database->kind == SKY_AIR) return check_air(database, failure);
    if (database->kind == SKY_BAND) return check_sums(database, EMISSION_SHARE, failure);
    const double *numbers = database->numbers;
    if (!database->arrays[KERNEL].values || !(numbers[SKY_GROUND_CODE] > 0)) return SKY_OK;
    int32_t status = check_number(database, SKY_GROUND_EMISSIVITY, "ground_emissivity", 0, 1, failure);
    return status ? status : check_number(database, SKY_GROUND_ALBEDO, "ground_albedo", 0, 1, failure);
}
