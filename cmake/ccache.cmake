# ccache where it is installed. Paths under the source folder are made relative, so that another clone of the repository hits the same cache.
find_program(STICTION_CCACHE ccache)
if(STICTION_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${STICTION_CCACHE})
endif()
