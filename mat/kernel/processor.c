/* What the processor can do, and from which sources this library is. Compiled for any processor of its kind. */
#include <stdint.h>

#include "export.h"

#ifndef SKYSHINE_SOURCES
#define SKYSHINE_SOURCES ""
#endif

/* Digest of the sources, 64 hexadecimal digits; empty where the build did not state it. */
SKYSHINE_EXPORT const char *skyshine_sources(void) { return SKYSHINE_SOURCES; }

#if defined(__x86_64__)

static void cpuid(uint32_t leaf, uint32_t registers[4]) {
    __asm__ volatile("cpuid"
                     : "=a"(registers[0]), "=b"(registers[1]), "=c"(registers[2]), "=d"(registers[3])
                     : "a"(leaf), "c"(0));
}

/* Bits of Intel's manual, volume 2, CPUID and XGETBV: AVX2 of the processor, and an operating system that keeps the
 * upper halves of the registers. */
static int eight_lanes(void) {
    const uint32_t saves_state = 1u << 27, avx = 1u << 28, avx2 = 1u << 5, sse_and_avx_state = 6;
    uint32_t registers[4], low, high;
    cpuid(0, registers);
    if (registers[0] < 7) return 0;
    cpuid(1, registers);
    if ((registers[2] & (saves_state | avx)) != (saves_state | avx)) return 0;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    if ((low & sse_and_avx_state) != sse_and_avx_state) return 0;
    cpuid(7, registers);
    return (registers[1] & avx2) != 0;
}

#else

static int eight_lanes(void) { return 0; }

#endif

/* Numbers of a vector for which this processor has instructions: 8 with AVX2, else 4. */
SKYSHINE_EXPORT int skyshine_lanes(void) { return eight_lanes() ? 8 : 4; }
