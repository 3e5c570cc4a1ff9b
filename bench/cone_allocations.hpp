#pragma once

namespace stiction::bench {

/// Heap allocations of this process so far (malloc, calloc, realloc, aligned forms and operator new, which uses them).
/// Always 0 under a sanitizer or without glibc. Linking this library replaces malloc in the program: programs that measure only.
long allocations();

}  // namespace stiction::bench
