# Where the locked Python environment keeps the C++ libraries that its wheels carry (Pinocchio, Coal, Eigen, yaml-cpp …).
find_package(Threads REQUIRED)
set(STICTION_VENV "${CMAKE_SOURCE_DIR}/.venv" CACHE PATH "Python environment made by `make setup`")
file(GLOB cmeel_prefix "${STICTION_VENV}/lib/python3*/site-packages/cmeel.prefix")
if(NOT cmeel_prefix)
  message(FATAL_ERROR "no C++ dependencies under ${STICTION_VENV}: run `make setup` first, or pass -DSTICTION_VENV=…")
endif()
list(PREPEND CMAKE_PREFIX_PATH ${cmeel_prefix})
set(CMAKE_FIND_PACKAGE_PREFER_CONFIG ON)
list(APPEND CMAKE_BUILD_RPATH ${cmeel_prefix}/lib)
find_package(Eigen3 REQUIRED CONFIG)
find_package(pinocchio REQUIRED CONFIG)
find_package(coal REQUIRED CONFIG)
find_package(yaml-cpp REQUIRED CONFIG)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)

# MuJoCo's wheel carries headers and library, but no CMake configuration.
file(GLOB mujoco_folder "${STICTION_VENV}/lib/python3*/site-packages/mujoco")
file(GLOB mujoco_library "${mujoco_folder}/libmujoco.so.*" "${mujoco_folder}/libmujoco.*.dylib")
if(NOT mujoco_library)
  message(FATAL_ERROR "no MuJoCo library under ${STICTION_VENV}: run `make setup`")
endif()
add_library(mujoco::mujoco SHARED IMPORTED)
set_target_properties(mujoco::mujoco PROPERTIES
  IMPORTED_LOCATION ${mujoco_library}
  INTERFACE_INCLUDE_DIRECTORIES ${mujoco_folder}/include)

# CoACD's wheel is a Python package over one shared library. It is loaded at its first use and never linked: docs/decisions/0009-convex-decomposition.md.
file(GLOB coacd_library "${STICTION_VENV}/lib/python3*/site-packages/coacd/lib_coacd.*")
file(GLOB coacd_metadata "${STICTION_VENV}/lib/python3*/site-packages/coacd-*.dist-info")
if(NOT coacd_library OR NOT coacd_metadata MATCHES "coacd-([0-9.]+)\\.dist-info")
  message(FATAL_ERROR "no CoACD library under ${STICTION_VENV}: run `make setup`")
endif()
set(coacd_version ${CMAKE_MATCH_1})
