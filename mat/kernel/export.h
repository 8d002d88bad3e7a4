/* Names of the library's functions: those compiled for eight lanes end in _8, those for four in _4. */
#ifndef SKYSHINE_EXPORT_H
#define SKYSHINE_EXPORT_H

#if defined(SKYSHINE_EXPORT) /* stated by a library that has the kernel inside */
#elif defined(_WIN32)
#define SKYSHINE_EXPORT __declspec(dllexport)
#else
#define SKYSHINE_EXPORT __attribute__((visibility("default")))
#endif

#define SKYSHINE_JOIN_(name, lanes) name##_##lanes
#define SKYSHINE_JOIN(name, lanes) SKYSHINE_JOIN_(name, lanes)
#define SKYSHINE_NAME(name) SKYSHINE_JOIN(name, LANES)

#endif
