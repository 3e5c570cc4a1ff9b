option(STICTION_RELOCATABLE "Compile in no path of this machine, and link copies of the shared libraries (wheels)" OFF)

# Where the locked Python environment keeps the C++ libraries that its wheels carry (Pinocchio, Coal, Eigen, yaml-cpp …).
find_package(Threads REQUIRED)
set(STICTION_VENV "${CMAKE_SOURCE_DIR}/.venv" CACHE PATH "Python environment made by `make setup`")
if(NOT SKBUILD)
  file(GLOB site_packages_of_venv "${STICTION_VENV}/lib/python3*/site-packages")
endif()
# A wheel is built against the packages of the Python that builds it, which its backend puts on CMAKE_PREFIX_PATH.
find_path(STICTION_SITE_PACKAGES NAMES cmeel.prefix/include/yaml-cpp/yaml.h HINTS ${site_packages_of_venv} DOC "Folder of the Python packages that carry the C++ dependencies")
if(NOT STICTION_SITE_PACKAGES)
  message(FATAL_ERROR "no C++ dependencies under ${STICTION_VENV}: run `make setup` first, or pass -DSTICTION_VENV=…")
endif()
set(cmeel_prefix ${STICTION_SITE_PACKAGES}/cmeel.prefix)
list(PREPEND CMAKE_PREFIX_PATH ${cmeel_prefix})
set(CMAKE_FIND_PACKAGE_PREFER_CONFIG ON)
list(APPEND CMAKE_BUILD_RPATH ${cmeel_prefix}/lib)
find_package(Eigen3 REQUIRED CONFIG)
if(STICTION_BUILD_TESTS OR STICTION_BUILD_BENCH)  # oracles
  find_package(pinocchio REQUIRED CONFIG)
  find_package(coal REQUIRED CONFIG)
endif()
find_package(yaml-cpp REQUIRED CONFIG)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)

# MuJoCo's wheel carries headers and library, but no CMake configuration.
set(mujoco_folder ${STICTION_SITE_PACKAGES}/mujoco)
file(GLOB mujoco_library "${mujoco_folder}/libmujoco.so.*" "${mujoco_folder}/libmujoco.*.dylib")
if(NOT mujoco_library)
  message(FATAL_ERROR "no MuJoCo library under ${STICTION_SITE_PACKAGES}: run `make setup`")
endif()
add_library(mujoco::mujoco SHARED IMPORTED)
set_target_properties(mujoco::mujoco PROPERTIES
  IMPORTED_LOCATION ${mujoco_library}
  INTERFACE_INCLUDE_DIRECTORIES ${mujoco_folder}/include)
stiction_own_copy(yaml-cpp::yaml-cpp fmt::fmt mujoco::mujoco)

# CoACD's wheel is a Python package over one shared library. It is loaded at its first use and never linked: docs/decisions/0009-convex-decomposition.md.
file(GLOB coacd_library "${STICTION_SITE_PACKAGES}/coacd/lib_coacd.*")
file(GLOB coacd_metadata "${STICTION_SITE_PACKAGES}/coacd-*.dist-info")
if(NOT coacd_library OR NOT coacd_metadata MATCHES "coacd-([0-9.]+)\\.dist-info")
  message(FATAL_ERROR "no CoACD library under ${STICTION_SITE_PACKAGES}: run `make setup`")
endif()
set(coacd_version ${CMAKE_MATCH_1})
cmake_path(GET coacd_library FILENAME coacd_file)

# Where an installation finds what it does not find beside itself. A wheel names no folder of the machine that built it.
if(STICTION_RELOCATABLE)
  set(compiled_in_coacd ${coacd_file})
else()
  set(compiled_in_source ${CMAKE_SOURCE_DIR})
  set(compiled_in_tasks ${CMAKE_SOURCE_DIR}/tasks)
  set(compiled_in_packages ${cmeel_prefix}/share)
  set(compiled_in_coacd ${coacd_library})
  set(compiled_in_python ${STICTION_VENV}/bin/python)
endif()
