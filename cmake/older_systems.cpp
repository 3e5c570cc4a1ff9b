// Linked into the program and the module of a wheel (older_systems.cmake). Two functions have a second version on newer systems, which does the
// same and which the linker takes. Systems with glibc 2.34 and the C++ library of GCC 11 have the first version alone, so that we name it.
#include <condition_variable>
#include <mutex>

__asm__(".symver first_hypot, hypot@GLIBC_2.2.5");
__asm__(".symver first_wait, _ZNSt18condition_variable4waitERSt11unique_lockISt5mutexE@GLIBCXX_3.4.11");

extern "C" {

double first_hypot(double x, double y);
double __wrap_hypot(double x, double y) { return first_hypot(x, y); }

void first_wait(std::condition_variable* self, std::unique_lock<std::mutex>* lock);
void __wrap__ZNSt18condition_variable4waitERSt11unique_lockISt5mutexE(std::condition_variable* self, std::unique_lock<std::mutex>* lock) {
  first_wait(self, lock);
}

}  // extern "C"
