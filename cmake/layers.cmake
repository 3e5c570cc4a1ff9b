# Layers of the library, lowest first. A layer links to and includes from layers below it only; anything else stops the build.
set(STICTION_LAYERS core cone world contact dynamics trajopt sensing control simulation planning execution tasks)
# Libraries that only the named layers may include: library=layer or library=layer+layer.
set(STICTION_OWNED_LIBRARIES pinocchio=world mujoco=world+simulation)
set(STICTION_LAYER_CHECK ${CMAKE_CURRENT_LIST_DIR}/check_layer.cmake)

add_library(stiction_flags INTERFACE)
target_compile_features(stiction_flags INTERFACE cxx_std_20)
# Coal was built for 16-byte alignment: every target that is compiled with AVX must agree about the layout of Eigen members. Dynamic Eigen
# objects must not cross that border all the same (docs/decisions/0001-dependencies.md).
target_compile_definitions(stiction_flags INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
# Warnings are for this project, not for those that use the installed library.
target_compile_options(stiction_flags INTERFACE $<BUILD_INTERFACE:-Wall> $<BUILD_INTERFACE:-Wextra> $<BUILD_INTERFACE:-Wshadow> $<BUILD_INTERFACE:-Wnon-virtual-dtor>)
if(STICTION_WERROR)
  target_compile_options(stiction_flags INTERFACE $<BUILD_INTERFACE:-Werror>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 reports accesses that never happen: past the end in Eigen's vectorised copies of small vectors, overlaps in std::string (PR105329).
    target_compile_options(stiction_flags INTERFACE
      $<BUILD_INTERFACE:-Wno-error=array-bounds> $<BUILD_INTERFACE:-Wno-error=stringop-overflow>
      $<BUILD_INTERFACE:-Wno-error=maybe-uninitialized> $<BUILD_INTERFACE:-Wno-error=restrict>)
    if(STICTION_SANITIZE)  # under the thread sanitizer: uses after a free in Eigen's destructors
      target_compile_options(stiction_flags INTERFACE $<BUILD_INTERFACE:-Wno-error=use-after-free>)
    endif()
  endif()
endif()
if(STICTION_MARCH)
  target_compile_options(stiction_flags INTERFACE -march=${STICTION_MARCH})
endif()
target_include_directories(stiction_flags INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/src> $<INSTALL_INTERFACE:${STICTION_INSTALL_INCLUDEDIR}>)
target_link_libraries(stiction_flags INTERFACE Eigen3::Eigen Threads::Threads)
set_target_properties(stiction_flags PROPERTIES EXPORT_NAME flags)
install(TARGETS stiction_flags EXPORT stiction)

include(${CMAKE_CURRENT_LIST_DIR}/unity.cmake)

# stiction_layer(NAME SOURCES … ALONE file… USES layer… PRIVATE_LINK target…)
# Compiles the sources in batches (unity.cmake), and those of ALONE each by itself: they define names of other files or have definitions of their own.
# ALONE ALL: the compiler optimises each file of an inner loop by itself, and the same whatever files are beside it.
function(stiction_layer name)
  cmake_parse_arguments(A "" "" "SOURCES;ALONE;USES;PRIVATE_LINK" ${ARGN})
  if(A_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "layer '${name}': unknown arguments ${A_UNPARSED_ARGUMENTS}")
  endif()
  list(FIND STICTION_LAYERS ${name} rank)
  if(rank EQUAL -1)
    message(FATAL_ERROR "'${name}' is not a layer of stiction")
  endif()
  foreach(dep IN LISTS A_USES)
    list(FIND STICTION_LAYERS ${dep} dep_rank)
    if(dep_rank EQUAL -1 OR NOT dep_rank LESS rank)
      message(FATAL_ERROR "layer '${name}' may not use '${dep}'")
    endif()
  endforeach()
  foreach(target IN LISTS A_PRIVATE_LINK)
    if(target MATCHES "^stiction")
      message(FATAL_ERROR "layer '${name}' names '${target}' in PRIVATE_LINK: layers belong in USES")
    endif()
  endforeach()

  if(A_SOURCES)
    set(scope PUBLIC)
    set(sources ${A_SOURCES})
    if(NOT A_ALONE STREQUAL "ALL")
      stiction_batches(sources ${name} stiction/${name}/ ALONE ${A_ALONE} SOURCES ${A_SOURCES})
    endif()
    add_library(stiction_${name} STATIC ${sources})
    target_link_libraries(stiction_${name} PRIVATE ${A_PRIVATE_LINK})
  else()  # headers only
    set(scope INTERFACE)
    add_library(stiction_${name} INTERFACE)
  endif()
  add_library(stiction::${name} ALIAS stiction_${name})
  set_target_properties(stiction_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS stiction_${name} EXPORT stiction ARCHIVE DESTINATION ${STICTION_INSTALL_LIBDIR} COMPONENT development)
  list(TRANSFORM A_USES PREPEND stiction:: OUTPUT_VARIABLE lower)
  target_link_libraries(stiction_${name} ${scope} stiction_flags ${lower})

  # All headers lie under src/, so the linker alone would not see a forbidden include: the files are looked at whenever they change.
  file(GLOB_RECURSE files CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.hpp ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  set(stamp ${CMAKE_CURRENT_BINARY_DIR}/layer_${name}.checked)
  string(REPLACE ";" "," uses "${A_USES}")
  string(REPLACE ";" "," owned "${STICTION_OWNED_LIBRARIES}")
  add_custom_command(OUTPUT ${stamp}
    COMMAND ${CMAKE_COMMAND} -DNAME=${name} -DUSES=${uses} -DOWNED=${owned} -DFOLDER=${CMAKE_CURRENT_SOURCE_DIR} -DSTAMP=${stamp}
            -P ${STICTION_LAYER_CHECK}
    DEPENDS ${files} ${STICTION_LAYER_CHECK} ${CMAKE_CURRENT_SOURCE_DIR}/CMakeLists.txt
    COMMENT "Layer rule: ${name}" VERBATIM)
  add_custom_target(check_layer_${name} DEPENDS ${stamp})
  add_dependencies(stiction_${name} check_layer_${name})
endfunction()

# stiction_test(NAME SOURCES … ALONE … LINK target… [LABELS …]) adds one GoogleTest program.
# Compiles the sources in batches, and those ALONE each by itself (unity.cmake).
function(stiction_test name)
  cmake_parse_arguments(A "" "" "SOURCES;ALONE;LINK;LABELS" ${ARGN})
  if(A_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "test '${name}': unknown arguments ${A_UNPARSED_ARGUMENTS}")
  endif()
  cmake_path(GET CMAKE_CURRENT_SOURCE_DIR FILENAME folder)
  stiction_batches(sources ${name} ${folder}/ ALONE ${A_ALONE} SOURCES ${A_SOURCES})
  add_executable(${name} ${sources})
  target_link_libraries(${name} PRIVATE stiction_flags ${A_LINK} stiction_test_paths GTest::gtest_main)
  set(properties TIMEOUT 300 ENVIRONMENT "STICTION_CACHE=${CMAKE_BINARY_DIR}/cache")  # and not the one of who runs them
  if(A_LABELS)
    list(APPEND properties LABELS "${A_LABELS}")
  endif()
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()
