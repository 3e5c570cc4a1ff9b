# What `cmake --install` copies. Components: program (with its data), python, development (library, headers, CMake package), bench (`stiction-bench`, where it is built).
include(CMakePackageConfigHelpers)

install(DIRECTORY tasks models scenarios DESTINATION ${STICTION_INSTALL_DATADIR} COMPONENT program)
install(DIRECTORY experiments DESTINATION ${STICTION_INSTALL_DATADIR} COMPONENT program PATTERN __pycache__ EXCLUDE)
install(DIRECTORY python/stiction_view python/examples DESTINATION ${STICTION_INSTALL_DATADIR}/python COMPONENT program PATTERN __pycache__ EXCLUDE)

install(DIRECTORY src/stiction DESTINATION ${STICTION_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN *.hpp)
set(package_dir ${STICTION_INSTALL_LIBDIR}/cmake/stiction)
install(EXPORT stiction NAMESPACE stiction:: FILE stictionTargets.cmake DESTINATION ${package_dir} COMPONENT development)
get_property(STICTION_OWN_LIBRARIES GLOBAL PROPERTY STICTION_OWN_LIBRARIES)
configure_package_config_file(cmake/stictionConfig.cmake.in ${CMAKE_BINARY_DIR}/stictionConfig.cmake
  INSTALL_DESTINATION ${package_dir} PATH_VARS STICTION_INSTALL_DATADIR STICTION_INSTALL_PACKAGESDIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/stictionConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/stictionConfig.cmake ${CMAKE_BINARY_DIR}/stictionConfigVersion.cmake DESTINATION ${package_dir} COMPONENT development)
