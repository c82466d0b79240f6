#pragma once

/// Placed before a function of plain loops, compiles it a second time for AVX2 and FMA. The program
/// chooses the version for its processor when it starts. The two round differently.
#if defined(__x86_64__)
#define PLANAR_AVX2_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define PLANAR_AVX2_CLONES
#endif
