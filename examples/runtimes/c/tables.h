/* The tables of a state, a band and a source. */
#ifndef SKYSHINE_TABLES_H
#define SKYSHINE_TABLES_H

#include "database.h"

struct skyshine_tables {
    struct database surface, band, air;
    SkyTables *kernel;
    struct block *memory;
};

#endif
