#pragma once

/// Before a function of plain loops: it is compiled a second time, for AVX2 and FMA, and the
/// program takes at its start the version that suits the processor. The two round differently.
#if defined(__x86_64__)
#define PLANAR_AVX2_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define PLANAR_AVX2_CLONES
#endif
