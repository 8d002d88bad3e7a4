/* A program that uses the library by its public calls: prints the results of all of them at one place, as JSON.
 *
 * Usage: user FOLDER SURFACE BAND ATMOSPHERE */
#include <skyshine.h>

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { THREADS = 4, TURNS = 50 };

static const skyshine_line LINE = {1.3, 0.6, -12, 30, 70};
static const double HOURS[][2] = {{10, 14}};
static skyshine_pixel pixel = {.materials = 2, .share = {0.75, 0.25}, .temperature = {NAN, 301}, .surface_altitude = 0.5, .surface_azimuth = 200,
                               .surface_slope = 20, .time = 14.5, .range = 1.2, .centre_range = 1.3, .centre_elevation = -12, .altitude = 0.6,
                               .source_elevation = 30, .source_azimuth = 70, .source_heading = 150, .normal = {0.3, -0.2, 0.9},
                               .to_source = {0.5, 0.5, 0.6}, .to_observer = {-0.1, -0.9, 0.3}};

static void check(skyshine_status status, const skyshine_error *error)
{
    if (status == SKYSHINE_OK && error->status == SKYSHINE_OK) return;
    fprintf(stderr, "%s\n", error->message);
    exit(1);
}

/* Every thread must find the same. */
static void *read_often(void *tables)
{
    skyshine_terms *terms = calloc(TURNS, sizeof *terms);
    for (int k = 0; k < TURNS; ++k) {
        double wrong;
        skyshine_pixel_radiance(tables, &pixel, &terms[k], NULL);
        skyshine_apparent_temperature(tables, -1.0, &wrong, NULL);
        if (memcmp(&terms[k], &terms[0], sizeof *terms)) terms[0].radiance = NAN;
    }
    return terms;
}

int main(int count, char **arguments)
{
    skyshine_error error;
    skyshine_tables *tables, *listed;
    const int32_t *codes;
    const char *const *names;
    double value, other = -1;
    if (count != 5) return 2;
    check(skyshine_open(arguments[1], 1, 1, SKYSHINE_SUN, (const char *const[]){"range", NULL}, &listed, &error), &error);
    printf("{\"listed\": %zu, \"ranges\": [", skyshine_materials(listed, NULL, NULL));
    const double refusals[] = {-1.0, -INFINITY, INFINITY, NAN};
    for (size_t k = 0; k < sizeof refusals / sizeof *refusals; ++k) {
        skyshine_line wrong = LINE;
        wrong.range = refusals[k];
        const skyshine_status status = skyshine_transmittance(listed, &wrong, &value, &error);
        printf("%s[%d, \"%s\"]", k ? ", " : "", status, error.message);
    }
    printf("], ");
    skyshine_close(listed);
    check(skyshine_open_files(arguments[2], arguments[3], arguments[4], NULL, &tables, &error), &error);
    const size_t materials = skyshine_materials(tables, &codes, &names);
    printf("\"materials\": [");
    for (size_t k = 0; k < materials; ++k) printf("%s[%d, \"%s\"]", k ? ", " : "", (int)codes[k], names[k]);
    const skyshine_face face = {codes[0], 0.5, 200, 20, 14.5};
    const skyshine_surroundings around = {HOURS, 1, 0.6, 310, NAN};
    check(skyshine_temperature(tables, &face, &value, &error), &error);
    printf("], \"temperature\": %.17g, ", value);
    check(skyshine_shaded_temperature(tables, &face, &around, &value, &error), &error);
    printf("\"shaded_temperature\": %.17g, ", value);
    check(skyshine_transmittance(tables, &LINE, &value, &error), &error);
    printf("\"transmittance\": %.17g, ", value);
    check(skyshine_path_radiance(tables, &LINE, &value, &error), &error);
    printf("\"path_radiance\": %.17g, ", value);
    check(skyshine_ambient_radiance(tables, &LINE, 20, 50, &value, &error), &error);
    printf("\"ambient_radiance\": %.17g, ", value);
    check(skyshine_direct_radiance(tables, &LINE, &value, &error), &error);
    printf("\"direct_radiance\": %.17g, ", value);
    skyshine_terms terms;
    pixel.material[0] = codes[0];
    pixel.material[1] = codes[1];
    check(skyshine_pixel_radiance(tables, &pixel, &terms, &error), &error);
    printf("\"pixel_radiance\": %.17g, ", terms.radiance);
    check(skyshine_apparent_temperature(tables, terms.radiance, &value, &error), &error);
    printf("\"apparent_temperature\": %.17g, ", value);

    pthread_t threads[THREADS];
    int alike = 1;
    for (int k = 0; k < THREADS; ++k) pthread_create(&threads[k], NULL, read_often, tables);
    for (int k = 0; k < THREADS; ++k) {
        void *found;
        pthread_join(threads[k], &found);
        alike = alike && ((skyshine_terms *)found)->radiance == terms.radiance;
        free(found);
    }
    const skyshine_face steep = {codes[0], 0.5, 200, 400, 14.5};
    const skyshine_status refused = skyshine_temperature(tables, &steep, &other, &error);
    printf("\"threads_alike\": %s, \"refused\": [%d, \"%s\"], \"untouched\": %s, ", alike ? "true" : "false", refused, error.message,
           other == -1 ? "true" : "false");
    skyshine_tables *none = NULL;
    if (skyshine_open_files(arguments[3], arguments[3], arguments[4], NULL, &none, &error) != SKYSHINE_FILE_ERROR) return 3;
    skyshine_frame *frame;
    double radiance[1];
    const double lists[] = {1.0, 0.5, 200, 20};
    const skyshine_view view = {.altitude = 0.6, .centre_range = 1.3, .centre_elevation = -12, .source_elevation = 30, .source_heading = 70, .time = 14.5};
    const skyshine_pixels pixels = {codes, lists, NULL, NULL, lists + 1, lists + 2, lists + 3, NULL};
    check(skyshine_frame_open(tables, &view, &frame, &error), &error);
    check(skyshine_frame_radiance(frame, &pixels, 1, radiance, &error), &error);
    skyshine_frame_close(frame);
    const skyshine_status missing = skyshine_open("/nowhere", 1, 1, SKYSHINE_SUN, NULL, &none, &error);
    printf("\"missing\": [%d, \"%s\"]}\n", missing, none ? "opened" : error.message);
    skyshine_close(tables);
    return 0;
}
