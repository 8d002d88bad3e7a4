/* A runtime's reader of the databases with libhdf5: the radiance of the pixels of a scene.
 *
 * Usage: runtime SCENE.json
 *
 * The scene and the result are described in ../README.md. Equation numbers are those of DSTO-TN-0193. */
#include "json.h"

#include <hdf5.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { AXES = 5, KEPT = 32, NAME = 64, PATH_SIZE = 4096 };

static void fail(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    exit(1);
}

static void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) fail("no memory is left");
    return memory;
}

struct axis {
    char name[NAME], own[NAME], interpolation[NAME];
    double *nodes, period;
    size_t count;
    int clamps;
};

/* Neighbouring nodes of a value and the weight of the upper one. */
struct place {
    size_t lower, upper;
    double weight;
};

struct array {
    char name[NAME];
    float *values;
    size_t count;
};

/* One file; axes and arrays are read when they are first asked for. */
struct database {
    hid_t file;
    const char *path;
    const struct json *clamped;
    struct axis axes[KEPT];
    struct array arrays[KEPT];
    size_t axis_count, array_count;
};

/* A text attribute, of variable or of fixed length; empty where there is none. */
static void read_text(hid_t item, const char *name, char *to)
{
    *to = 0;
    if (H5Aexists(item, name) <= 0) return;
    hid_t attribute = H5Aopen(item, name, H5P_DEFAULT), stored = H5Aget_type(attribute);
    if (H5Tis_variable_str(stored) > 0) {
        char *text = NULL;
        hid_t type = H5Tcopy(H5T_C_S1);
        H5Tset_size(type, H5T_VARIABLE);
        H5Tset_cset(type, H5Tget_cset(stored));
        if (H5Aread(attribute, type, &text) >= 0 && text) {
            snprintf(to, NAME, "%s", text);
            H5free_memory(text);
        }
        H5Tclose(type);
    } else if (H5Tget_class(stored) == H5T_STRING && H5Tget_size(stored) < NAME) {
        if (H5Aread(attribute, stored, to) < 0) *to = 0;
    }
    H5Tclose(stored);
    H5Aclose(attribute);
}

static void *read_values(const struct database *database, const char *name, hid_t type, size_t size, size_t *count)
{
    hid_t dataset = H5Dopen2(database->file, name, H5P_DEFAULT);
    if (dataset < 0) fail("%s: lacks '%s'", database->path, name);
    hid_t space = H5Dget_space(dataset);
    *count = (size_t)H5Sget_simple_extent_npoints(space);
    void *values = allocate(*count, size);
    if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) fail("%s: '%s' cannot be read", database->path, name);
    H5Sclose(space);
    H5Dclose(dataset);
    return values;
}

static int is_listed(const struct json *list, const char *name)
{
    for (const struct json *each = list ? list->children : NULL; each; each = each->next)
        if (each->kind == JSON_TEXT && !strcmp(each->text, name)) return 1;
    return 0;
}

/* The quantity's own axis where the file has one, else the one that quantities share. */
static const struct axis *axis_of(struct database *database, const char *quantity, const char *name)
{
    char own[NAME];
    snprintf(own, NAME, "%s_%s", quantity, name);
    for (size_t i = 0; i < database->axis_count; ++i)
        if (!strcmp(database->axes[i].own, own)) return &database->axes[i];
    if (database->axis_count == KEPT) fail("%s: more than %d axes", database->path, KEPT);
    struct axis *axis = &database->axes[database->axis_count++];
    const char *kept = H5Lexists(database->file, own, H5P_DEFAULT) > 0 ? own : name;
    snprintf(axis->name, NAME, "%s", name);
    snprintf(axis->own, NAME, "%s", own);
    axis->nodes = read_values(database, kept, H5T_NATIVE_DOUBLE, sizeof(double), &axis->count);
    if (!axis->count) fail("%s: the axis '%s' has no node", database->path, name);
    char policy[NAME];
    hid_t dataset = H5Dopen2(database->file, kept, H5P_DEFAULT);
    read_text(dataset, "interpolation", axis->interpolation);
    read_text(dataset, "out_of_range", policy);
    if (H5Aexists(dataset, "period") > 0) {
        hid_t attribute = H5Aopen(dataset, "period", H5P_DEFAULT);
        H5Aread(attribute, H5T_NATIVE_DOUBLE, &axis->period);
        H5Aclose(attribute);
    }
    H5Dclose(dataset);
    axis->clamps = !strcmp(policy, "clamp") || is_listed(database->clamped, name);
    return axis;
}

static const float *array_of(struct database *database, const char *name, size_t *count)
{
    for (size_t i = 0; i < database->array_count; ++i)
        if (!strcmp(database->arrays[i].name, name)) return *count = database->arrays[i].count, database->arrays[i].values;
    if (database->array_count == KEPT) fail("%s: more than %d arrays", database->path, KEPT);
    struct array *array = &database->arrays[database->array_count++];
    snprintf(array->name, NAME, "%s", name);
    array->values = read_values(database, name, H5T_NATIVE_FLOAT, sizeof(float), &array->count);
    *count = array->count;
    return array->values;
}

static double modulo(double value, double period)
{
    return value - period * floor(value / period);
}

static struct place locate(const struct axis *axis, double value)
{
    if (!isfinite(value)) fail("%s: found a value that is not finite; allowed: finite numbers", axis->name);
    size_t count = axis->count;
    if (!strcmp(axis->interpolation, "exact")) {
        for (size_t i = 0; i < count; ++i)
            if (axis->nodes[i] == value) return (struct place){i, i, 0.0};
        fail("%s: found %g; allowed: a code of the file", axis->name, value);
    }
    const double first = axis->nodes[0];
    int periodic = !strcmp(axis->interpolation, "linear_periodic");
    if (periodic) value = first + modulo(value - first, axis->period);
    if (!strcmp(axis->interpolation, "linear") && axis->period > 0) value -= axis->period * floor((value - first) / axis->period);
    if (!strcmp(axis->interpolation, "linear_folded"))
        value = fabs(modulo(value + axis->period / 2, axis->period) - axis->period / 2);
    const double last = periodic ? first + axis->period : axis->nodes[count - 1];
    if (!axis->clamps && !(value >= first && value <= last)) fail("%s: found %g; allowed: %g to %g", axis->name, value, first, last);
    value = fmin(fmax(value, first), last);
    size_t lower = 0, above = count;
    while (above - lower > 1) {
        size_t middle = (lower + above) / 2;
        if (axis->nodes[middle] <= value) lower = middle;
        else above = middle;
    }
    if (!periodic && lower == count - 1 && count > 1) --lower;
    if (!periodic && count == 1) return (struct place){0, 0, 0.0};
    size_t upper = (lower + 1) % count;
    double end = upper ? axis->nodes[upper] : last;
    return (struct place){lower, upper, (value - axis->nodes[lower]) / (end - axis->nodes[lower])};
}

/* Linear interpolation in every axis: the weighted sum over the corners of one cell. */
static double value_at(struct database *database, const char *quantity, size_t axes, const char *const *names, const double *where)
{
    struct place places[AXES];
    size_t sizes[AXES], count, expected = 1;
    const float *values = array_of(database, quantity, &count);
    for (size_t k = 0; k < axes; ++k) {
        const struct axis *axis = axis_of(database, quantity, names[k]);
        places[k] = locate(axis, where[k]);
        expected *= sizes[k] = axis->count;
    }
    if (expected != count) fail("%s: '%s' does not fit its axes", database->path, quantity);
    double total = 0.0;
    for (unsigned corner = 0; corner < 1u << axes; ++corner) {
        double share = 1.0;
        size_t index = 0;
        for (size_t k = 0; k < axes; ++k) {
            int up = corner >> k & 1;
            share *= up ? places[k].weight : 1.0 - places[k].weight;
            index = index * sizes[k] + (up ? places[k].upper : places[k].lower);
        }
        if (share != 0.0) total += share * values[index];
    }
    return total;
}

static void open_database(struct database *database, const char *folder, const struct json *scene, const char *key, const char *prefix)
{
    const struct json *name = json_get(scene, key);
    if (!name || name->kind != JSON_TEXT) fail("the scene lacks '%s'", key);
    char *path = allocate(PATH_SIZE, 1), filetype[NAME], version[NAME];
    snprintf(path, PATH_SIZE, "%s%s", name->text[0] == '/' ? "" : folder, name->text);
    database->path = path;
    database->clamped = json_get(scene, "clamp");
    database->file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (database->file < 0) fail("%s: is not a readable HDF5 file", path);
    read_text(database->file, "filetype", filetype);
    read_text(database->file, "format_version", version);
    int fits = !strcmp(filetype, prefix) || (!strcmp(prefix, "atmq") && !strcmp(filetype, "lunar_atmq"));
    const char *format = strcmp(prefix, "atmq") ? "1." : "2.";
    if (!fits || strncmp(version, format, 2)) fail("%s: holds '%s' %s; allowed: %s %sx", path, filetype, version, prefix, format);
}

/* Code of a material given by code or by name. */
static double material_code(struct database *database, const struct json *given)
{
    if (given && given->kind == JSON_NUMBER) return given->number;
    if (!given || given->kind != JSON_TEXT) fail("the scene lacks 'material'");
    size_t count, at = 0;
    hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    char **names = read_values(database, "material_name", type, sizeof(char *), &count);
    while (at < count && strcmp(names[at], given->text)) ++at;
    if (at == count) fail("material: found '%s'; allowed: a name of the file", given->text);
    for (size_t i = 0; i < count; ++i) H5free_memory(names[i]);
    free(names);
    H5Tclose(type);
    return axis_of(database, "material_name", "material")->nodes[at];
}

static double number(const struct json *object, const char *key)
{
    const struct json *found = json_get(object, key);
    if (!found || found->kind != JSON_NUMBER) fail("the scene lacks the number '%s'", key);
    return found->number;
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void direction(const struct json *pixel, const char *key, double *unit)
{
    const struct json *list = json_get(pixel, key), *part = list ? list->children : NULL;
    for (int k = 0; k < 3; ++k, part = part->next) {
        if (!part || part->kind != JSON_NUMBER) fail("'%s' must be three numbers", key);
        unit[k] = part->number;
    }
    double length = sqrt(dot(unit, unit));
    if (!(length > 0.0) || !isfinite(length)) fail("'%s' must be three finite numbers that are not all 0", key);
    for (int k = 0; k < 3; ++k) unit[k] /= length;
}

/* Equations (37) and (38): chi of the half vector to the power of the shininess. */
static double lobe(const double *normal, const double *to_source, const double *to_observer, double shininess)
{
    double between[3];
    for (int k = 0; k < 3; ++k) between[k] = to_source[k] + to_observer[k];
    double length = sqrt(dot(between, between));
    double chi = length > 0.0 ? dot(between, normal) / length : 0.0;
    return pow(fmin(fmax(chi, 0.0), 1.0), shininess);
}

/* Equation (44). */
static long pixel_value(double radiance, const struct json *scene)
{
    double size = pow(2.0, number(scene, "bits"));
    double share = fmin(fmax(radiance / number(scene, "gain"), 0.0), 1.0);
    double value = trunc(size * number(scene, "buffer_gain") * (share - number(scene, "offset")) - 0.5);
    return (long)fmin(fmax(value, 0.0), size - 1.0);
}

static double material_property(struct database *band, const char *name, double code)
{
    static const char *const axes[] = {"material"};
    return value_at(band, name, 1, axes, &code);
}

/* Angle between line of sight and source, all in degree. */
static double scattering_angle(double elevation, double source_elevation, double azimuth)
{
    const double degree = acos(-1.0) / 180.0;
    const double apart = sin((elevation - source_elevation) * degree / 2), turn = sin(azimuth * degree / 2);
    const double half = apart * apart + cos(elevation * degree) * cos(source_elevation * degree) * turn * turn;
    return 2.0 * asin(sqrt(fmin(fmax(half, 0.0), 1.0))) / degree;
}

/* Equations (1) to (44) for one pixel. */
static void print_pixel(const struct json *scene, struct database *surface, struct database *band, struct database *air, const struct json *given)
{
    static const char *const face_axes[] = {"material", "altitude", "azimuth", "slope", "time"};
    static const char *const warm_axes[] = {"temperature"};
    static const char *const air_axes[] = {"range", "altitude", "elevation", "source_elevation", "source_azimuth"};
    const double code = material_code(band, json_get(given, "material"));
    const double face[] = {code, number(given, "surface_altitude"), number(given, "surface_azimuth"), number(given, "surface_slope"), number(given, "time")};
    const double centre[] = {number(given, "centre_range"), number(given, "altitude"), number(given, "centre_elevation"),
                             number(given, "source_elevation"), number(given, "source_azimuth")};
    const double temperature = value_at(surface, "temperature", 5, face_axes, face);
    const double blackbody = value_at(band, "blackbody_radiance", 1, warm_axes, &temperature); /* (7) */
    const double rho = material_property(band, "reflectance", code), fraction = material_property(band, "specular_fraction", code);
    const double beta = value_at(air, "beta_star", 3, air_axes, centre);
    const double depth = 5.5 * number(given, "range") / beta, tau = exp(-depth); /* (9) */
    const char *path_axes[] = {"range", "altitude", "elevation", "source_elevation", "source_azimuth"};
    double along[] = {centre[0], centre[1], centre[2], centre[3], centre[4]};
    if (H5Lexists(air->file, "scattering_angle", H5P_DEFAULT) > 0) {
        path_axes[4] = "scattering_angle";
        along[4] = scattering_angle(centre[2], centre[3], centre[4]);
    }
    const double path = value_at(air, "path_radiance_ratio", 5, path_axes, along) * -expm1(-depth); /* (11) */
    const double skyshine = value_at(air, "ambient_radiance", 4, air_axes, centre) * rho * tau; /* (19) */
    double normal[3], to_source[3], to_observer[3];
    direction(given, "normal", normal);
    direction(given, "to_source", to_source);
    direction(given, "to_observer", to_observer);
    const double incidence = fmax(dot(normal, to_source), 0.0);
    const double direct = incidence > 0.0 ? value_at(air, "direct_radiance", 4, air_axes, centre) * rho * tau : 0.0;
    const double thermal = blackbody * (1.0 - rho) * tau; /* (6) */
    const double diffuse = direct * incidence * (1.0 - fraction); /* (34) */
    const double shape = lobe(normal, to_source, to_observer, material_property(band, "shininess", code));
    const double specular = direct * shape * fraction * material_property(band, "normalisation", code); /* (35) */
    const double radiance = diffuse + specular + skyshine + thermal + path; /* (1) */
    printf("{\"temperature\": %.17g, \"blackbody_radiance\": %.17g, \"beta_star\": %.17g, \"transmittance\": %.17g, "
           "\"thermal\": %.17g, \"path\": %.17g, \"skyshine\": %.17g, \"diffuse\": %.17g, \"specular\": %.17g, "
           "\"radiance\": %.17g, \"pixel_value\": %ld}",
           temperature, blackbody, beta, tau, thermal, path, skyshine, diffuse, specular, radiance, pixel_value(radiance, scene));
}

static char *read_whole(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) fail("%s: cannot be read", path);
    size_t size = 0, room = 4096;
    char *text = allocate(room, 1);
    while (!feof(file) && !ferror(file)) {
        if (room - size < 2 && !(text = realloc(text, room *= 2))) fail("no memory is left");
        size += fread(text + size, 1, room - size - 1, file);
    }
    fclose(file);
    text[size] = 0;
    return text;
}

int main(int count, char **arguments)
{
    if (count != 2) fail("usage: runtime SCENE.json");
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const struct json *scene = json_parse(read_whole(arguments[1]));
    if (!scene) fail("%s: is not JSON", arguments[1]);
    char folder[PATH_SIZE];
    const char *slash = strrchr(arguments[1], '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - arguments[1] + 1) : 0, arguments[1]);
    static struct database surface, band, air;
    open_database(&surface, folder, scene, "surface", "htt");
    open_database(&band, folder, scene, "band", "band");
    open_database(&air, folder, scene, "atmosphere", "atmq");
    const struct json *pixels = json_get(scene, "pixels");
    if (!pixels || pixels->kind != JSON_LIST) fail("the scene lacks the list 'pixels'");
    printf("{\"pixels\": [");
    for (const struct json *each = pixels->children; each; each = each->next) {
        print_pixel(scene, &surface, &band, &air, each);
        if (each->next) printf(", ");
    }
    printf("]}\n");
    return 0;
}
