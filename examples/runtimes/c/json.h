/* A small reader of JSON, so that the example needs no library beside HDF5: a tree of values, looked up by key. */
#ifndef JSON_H
#define JSON_H

enum json_kind { JSON_NULL, JSON_FALSE, JSON_TRUE, JSON_NUMBER, JSON_TEXT, JSON_LIST, JSON_OBJECT };

struct json {
    enum json_kind kind;
    double number;
    char *text;             /* of a text */
    char *key;              /* of a member of an object */
    struct json *children;  /* of a list or an object: the first one */
    struct json *next;      /* sibling */
};

/* The tree of a text that ends in 0; NULL where it is not JSON. Its memory lives as long as the process. */
struct json *json_parse(const char *text);

/* A member of an object; NULL where there is none. */
const struct json *json_get(const struct json *object, const char *key);

#endif
