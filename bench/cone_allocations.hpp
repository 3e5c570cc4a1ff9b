#pragma once

namespace stiction::bench {

/// Heap allocations of this process so far (malloc, calloc, realloc, aligned forms and operator new, which uses them).
/// Always 0 where counts_allocations() is false. Linking this library replaces malloc in the program: programs that measure only.
long allocations();

/// False under a sanitizer, which brings its own malloc, and without glibc.
bool counts_allocations();

}  // namespace stiction::bench
