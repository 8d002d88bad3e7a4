#include "json.h"

#include <stdlib.h>
#include <string.h>

enum { DEPTH_LIMIT = 64 };

typedef void *allocator(size_t count, size_t size);

static struct json *value(const char **at, int depth, allocator *allocate);

static void skip(const char **at)
{
    while (**at && strchr(" \t\r\n", **at)) ++*at;
}

static int hexadecimal(const char *at, unsigned *code)
{
    char digits[5] = {0}, *end;
    for (int i = 0; i < 4; ++i) {
        if (!at[i]) return 0;
        digits[i] = at[i];
    }
    *code = (unsigned)strtoul(digits, &end, 16);
    return end == digits + 4;
}

/* One code point as UTF-8; a lone half of a surrogate pair is kept as its three bytes. */
static char *encode(char *to, unsigned code)
{
    if (code < 0x80) {
        *to++ = (char)code;
    } else if (code < 0x800) {
        *to++ = (char)(0xC0 | code >> 6);
        *to++ = (char)(0x80 | (code & 0x3F));
    } else {
        *to++ = (char)(0xE0 | code >> 12);
        *to++ = (char)(0x80 | (code >> 6 & 0x3F));
        *to++ = (char)(0x80 | (code & 0x3F));
    }
    return to;
}

static char *text(const char **at, allocator *allocate)
{
    static const char names[] = "\"\\/bfnrt", meant[] = "\"\\/\b\f\n\r\t";
    size_t length = 1; /* up to the closing quote: the rest of the file is no measure of a text */
    while ((*at)[length] && (*at)[length] != '"') length += (*at)[length] == '\\' && (*at)[length + 1] ? 2 : 1;
    char *start = allocate(length, 1), *to = start;
    for (++*at; **at && **at != '"'; ++*at) {
        if (**at != '\\') {
            *to++ = **at;
            continue;
        }
        ++*at;
        const char *found = **at ? strchr(names, **at) : NULL;
        unsigned code;
        if (found) {
            *to++ = meant[found - names];
        } else if (**at == 'u' && hexadecimal(*at + 1, &code) && code) {
            to = encode(to, code);
            *at += 4;
        } else {
            return NULL;
        }
    }
    *to = 0;
    if (**at != '"') return NULL;
    ++*at;
    return start;
}

static int members(const char **at, struct json *parent, char end, int depth, allocator *allocate)
{
    struct json **last = &parent->children;
    ++*at;
    skip(at);
    if (**at == end) {
        ++*at;
        return 1;
    }
    for (;;) {
        char *key = NULL;
        skip(at);
        if (end == '}') {
            if (**at != '"' || !(key = text(at, allocate))) return 0;
            skip(at);
            if (*(*at)++ != ':') return 0;
        }
        if (!(*last = value(at, depth + 1, allocate))) return 0;
        (*last)->key = key;
        last = &(*last)->next;
        skip(at);
        if (**at == end) {
            ++*at;
            return 1;
        }
        if (*(*at)++ != ',') return 0;
    }
}

static int word(const char **at, const char *name)
{
    size_t length = strlen(name);
    if (strncmp(*at, name, length)) return 0;
    *at += length;
    return 1;
}

static int fill(const char **at, struct json *one, int depth, allocator *allocate)
{
    if (**at == '{' || **at == '[') {
        one->kind = **at == '{' ? JSON_OBJECT : JSON_LIST;
        return members(at, one, **at == '{' ? '}' : ']', depth, allocate);
    }
    if (**at == '"') {
        one->kind = JSON_TEXT;
        return (one->text = text(at, allocate)) != NULL;
    }
    if (word(at, "null")) return 1;
    if (word(at, "false")) return one->kind = JSON_FALSE, 1;
    if (word(at, "true")) return one->kind = JSON_TRUE, 1;
    char *end;
    if (!**at || !strchr("-0123456789", **at)) return 0;
    one->kind = JSON_NUMBER;
    one->number = strtod(*at, &end);
    if (end == *at) return 0;
    *at = end;
    return 1;
}

static struct json *value(const char **at, int depth, allocator *allocate)
{
    skip(at);
    struct json *one = depth < DEPTH_LIMIT ? allocate(1, sizeof *one) : NULL;
    return one && fill(at, one, depth, allocate) ? one : NULL;
}

struct json *sky_json_parse(const char *given, allocator *allocate)
{
    struct json *root = value(&given, 0, allocate);
    skip(&given);
    return *given ? NULL : root;
}

const struct json *sky_json_get(const struct json *object, const char *key)
{
    for (const struct json *child = object ? object->children : NULL; child; child = child->next)
        if (child->key && !strcmp(child->key, key)) return child;
    return NULL;
}
