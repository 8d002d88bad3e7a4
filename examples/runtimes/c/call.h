/* A call of the library: what it took is given back at its end, also where it fails in the middle. */
#ifndef SKYSHINE_CALL_H
#define SKYSHINE_CALL_H

#include "skyshine.h"

#include <hdf5.h>
#include <setjmp.h>
#include <stddef.h>

/* Memory of a call or of a handle; the bytes follow the header. */
struct block {
    struct block *before, *after;
    max_align_t bytes[];
};

struct call {
    jmp_buf failed;
    skyshine_status kind, status; /* of a failure, and of the call */
    char message[SKYSHINE_MESSAGE];
    struct block *blocks;
    hid_t *ids;
    size_t id_count, id_room;
    int files; /* the HDF5 library is asked */
    H5E_auto2_t report;
    void *report_data;
    struct call *outer;
};

/* Begin a call whose failures are of a kind; `sky_end` follows, and between them `if (!setjmp(call.failed)) ...`. */
void sky_begin(struct call *call, skyshine_status kind);

/* Give back what the call took and did not keep. */
skyshine_status sky_end(struct call *call, skyshine_error *error);

/* Leave the call of this thread with a message of one line. */
#if defined __GNUC__
__attribute__((format(printf, 1, 2)))
#endif
_Noreturn void sky_fail(const char *format, ...);

/* Zeroed memory of the call; it is released with the call unless the call keeps it. */
void *sky_allocate(size_t count, size_t size);
void sky_release(void *memory);

/* The memory that this call holds: it now lives as long as its new owner, which releases it. */
struct block *sky_keep(void);
void sky_release_all(struct block *blocks);

/* An identifier of the HDF5 library, which is released with the call. */
hid_t sky_id(hid_t id);

#endif
