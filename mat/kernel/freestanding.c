/* The functions that a compiler may call of itself, for a library that is linked without any other. The empty assembly
 * keeps the compiler from replacing the loops by calls of these very functions. */
#include <stddef.h>
#include <stdint.h>

#define BARRIER __asm__ volatile("" ::: "memory")

typedef uint64_t Word __attribute__((aligned(1), may_alias));

void *memcpy(void *restrict to, const void *restrict from, size_t count) {
#if defined(__x86_64__)
    void *at = to;
    __asm__ volatile("rep movsb" : "+D"(at), "+S"(from), "+c"(count) : : "memory");
#else
    unsigned char *at = to;
    const unsigned char *source = from;
    for (; count >= sizeof(Word); count -= sizeof(Word), at += sizeof(Word), source += sizeof(Word)) {
        *(Word *)at = *(const Word *)source;
        BARRIER;
    }
    for (; count; count--) {
        *at++ = *source++;
        BARRIER;
    }
#endif
    return to;
}

void *memmove(void *to, const void *from, size_t count) {
    unsigned char *at = to;
    const unsigned char *source = from;
    if ((uintptr_t)at - (uintptr_t)source >= count) return memcpy(to, from, count);
    while (count--) {
        at[count] = source[count];
        BARRIER;
    }
    return to;
}

void *memset(void *to, int value, size_t count) {
#if defined(__x86_64__)
    void *at = to;
    __asm__ volatile("rep stosb" : "+D"(at), "+c"(count) : "a"(value) : "memory");
#else
    unsigned char *at = to;
    Word word = (unsigned char)value * UINT64_C(0x0101010101010101);
    for (; count >= sizeof(Word); count -= sizeof(Word), at += sizeof(Word)) {
        *(Word *)at = word;
        BARRIER;
    }
    while (count--) {
        *at++ = (unsigned char)value;
        BARRIER;
    }
#endif
    return to;
}

int memcmp(const void *left, const void *right, size_t count) {
    const unsigned char *a = left, *b = right;
    for (; count; count--, a++, b++) {
        if (*a != *b) return *a < *b ? -1 : 1;
        BARRIER;
    }
    return 0;
}

#if defined(_WIN32)
int DllMainCRTStartup(void *library, unsigned long reason, void *reserved);
int DllMainCRTStartup(void *library, unsigned long reason, void *reserved) {
    (void)library, (void)reason, (void)reserved;
    return 1;
}

/* Compilers call this before a frame of more than a page, whose size is in rax: Windows commits a stack page by page, so
 * each page is touched from the top. All registers are as before. */
__asm__(".globl ___chkstk_ms\n"
        "___chkstk_ms:\n"
        "    push %rax\n"
        "    push %rcx\n"
        "    lea 24(%rsp), %rcx\n"
        "1:  cmp $4096, %rax\n"
        "    jbe 2f\n"
        "    sub $4096, %rcx\n"
        "    orb $0, (%rcx)\n"
        "    sub $4096, %rax\n"
        "    jmp 1b\n"
        "2:  sub %rax, %rcx\n"
        "    orb $0, (%rcx)\n"
        "    pop %rcx\n"
        "    pop %rax\n"
        "    ret\n");
#endif
