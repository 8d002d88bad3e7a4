/* A texture, from whose texels materials are read. */
#ifndef TEXTURE_H
#define TEXTURE_H

#include <stddef.h>
#include <stdint.h>

enum { COMPONENTS = 3, LEVELS = 32 };

/* One mip level: three codes and three weights a texel. */
struct level {
    size_t height, width;
    uint16_t *codes, *weights;
};

struct texture {
    const char *path;
    struct level levels[LEVELS];
};

/* Open a .tmm file and read its level 0, or end with a message. */
void open_texture(struct texture *texture, const char *path);

/* Codes and shares of the materials at a point, in texels of level 0 from the top left corner; returns how many. */
size_t mixture_at(struct texture *texture, double across, double down, double level, double *codes, double *shares);

#endif
