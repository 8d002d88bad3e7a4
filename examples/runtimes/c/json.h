/* A small reader of JSON, so that no library is needed beside HDF5: a tree of values, looked up by key. */
#ifndef JSON_H
#define JSON_H

#include <stddef.h>

enum json_kind { JSON_NULL, JSON_FALSE, JSON_TRUE, JSON_NUMBER, JSON_TEXT, JSON_LIST, JSON_OBJECT };

struct json {
    enum json_kind kind;
    double number;
    char *text;             /* of a text */
    char *key;              /* of a member of an object */
    struct json *children;  /* of a list or an object: the first one */
    struct json *next;      /* sibling */
};

/* The tree of a text that ends in 0; NULL where it is not JSON. Its memory, zeroed, comes from `allocate`, which does not
 * return where there is none, and is the caller's. */
struct json *sky_json_parse(const char *text, void *(*allocate)(size_t count, size_t size));

/* A member of an object; NULL where there is none. */
const struct json *sky_json_get(const struct json *object, const char *key);

#endif
