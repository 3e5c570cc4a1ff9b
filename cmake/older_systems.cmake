# stiction_for_older_systems(TARGET): what a wheel brings needs no newer system than it must.
execute_process(COMMAND getconf GNU_LIBC_VERSION OUTPUT_VARIABLE STICTION_LIBC OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
string(REGEX MATCH "^[a-z]*" STICTION_LIBC "${STICTION_LIBC}")  # glibc, or nothing

function(stiction_for_older_systems target)
  if(STICTION_RELOCATABLE AND STICTION_LIBC STREQUAL "glibc" AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_sources(${target} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/older_systems.cpp)
    target_link_options(${target} PRIVATE -Wl,--wrap=hypot -Wl,--wrap=_ZNSt18condition_variable4waitERSt11unique_lockISt5mutexE)
  endif()
endfunction()
