/* A call fails with longjmp to its beginning: the readers then need not carry a status through every level. The call of a
 * thread is known to that thread alone. */
#include "call.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static _Thread_local struct call *current;

void sky_begin(struct call *call, skyshine_status kind)
{
    memset(call, 0, sizeof *call);
    call->kind = kind;
    call->outer = current;
    call->files = kind == SKYSHINE_FILE_ERROR;
    current = call;
    if (!call->files) return;
    H5Eget_auto2(H5E_DEFAULT, &call->report, &call->report_data);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

skyshine_status sky_end(struct call *call, skyshine_error *error)
{
    while (call->id_count) H5Idec_ref(call->ids[--call->id_count]);
    free(call->ids);
    sky_release_all(call->blocks);
    if (call->files) H5Eset_auto2(H5E_DEFAULT, call->report, call->report_data);
    current = call->outer;
    if (error) {
        error->status = call->status;
        memcpy(error->message, call->message, sizeof error->message);
    }
    return call->status;
}

void sky_fail(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(current->message, sizeof current->message, format, arguments);
    va_end(arguments);
    for (char *at = current->message; *at; ++at)
        if ((unsigned char)*at < ' ') *at = '?';
    if (!current->status) current->status = current->kind;
    longjmp(current->failed, 1);
}

void *sky_allocate(size_t count, size_t size)
{
    struct block *block = NULL;
    if (size == 0 || count <= (SIZE_MAX - sizeof *block) / size) block = calloc(1, sizeof *block + count * size);
    if (!block) {
        current->status = SKYSHINE_NO_MEMORY;
        sky_fail("no memory is left");
    }
    block->after = current->blocks;
    if (block->after) block->after->before = block;
    return (current->blocks = block)->bytes;
}

void sky_release(void *memory)
{
    if (!memory) return;
    struct block *block = (struct block *)((char *)memory - offsetof(struct block, bytes));
    if (block->after) block->after->before = block->before;
    if (block->before) block->before->after = block->after;
    else current->blocks = block->after;
    free(block);
}

struct block *sky_keep(void)
{
    struct block *blocks = current->blocks;
    current->blocks = NULL;
    return blocks;
}

void sky_release_all(struct block *blocks)
{
    while (blocks) {
        struct block *after = blocks->after;
        free(blocks);
        blocks = after;
    }
}

hid_t sky_id(hid_t id)
{
    if (id < 0) return id;
    if (current->id_count == current->id_room) {
        const size_t room = 2 * current->id_room + 64;
        hid_t *ids = realloc(current->ids, room * sizeof *ids);
        if (!ids) {
            H5Idec_ref(id);
            current->status = SKYSHINE_NO_MEMORY;
            sky_fail("no memory is left");
        }
        current->ids = ids;
        current->id_room = room;
    }
    return current->ids[current->id_count++] = id;
}
