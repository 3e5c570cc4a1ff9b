# Several source files in one compilation. Two thirds of the time of a file go into the same headers and the same templates of Eigen, which a batch reads once.
set(STICTION_UNITY 8 CACHE STRING "Source files in one compilation, at most; 0 compiles each file alone")

# stiction_batches(OUT NAME PREFIX ALONE file… SOURCES file…)
# Sets OUT to the sources of a target: batches of SOURCES, and those ALONE that have definitions of their own or names of another file.
# NAME is part of the names of the batches, as targets may share a folder.
# PREFIX leads to the sources from an include directory. Batches name no folder of this machine, so that another clone hits the same cache.
function(stiction_batches out name prefix)
  cmake_parse_arguments(A "" "" "SOURCES;ALONE" ${ARGN})
  if(A_ALONE)
    list(REMOVE_ITEM A_SOURCES ${A_ALONE})
  endif()
  list(LENGTH A_SOURCES n)
  if(STICTION_UNITY LESS 2 OR n LESS 2)
    list(APPEND A_SOURCES ${A_ALONE})
    set(${out} ${A_SOURCES} PARENT_SCOPE)
    return()
  endif()
  # Batches of equal size, as one long one would keep other processors waiting.
  math(EXPR batches "(${n} + ${STICTION_UNITY} - 1) / ${STICTION_UNITY}")
  set(files ${A_ALONE})
  foreach(batch RANGE 1 ${batches})
    math(EXPR begin "${n} * (${batch} - 1) / ${batches}")
    math(EXPR length "${n} * ${batch} / ${batches} - ${begin}")
    list(SUBLIST A_SOURCES ${begin} ${length} part)
    set(content "")
    foreach(source IN LISTS part)
      string(APPEND content "#include \"${prefix}${source}\"\n")
    endforeach()
    set(file ${CMAKE_CURRENT_BINARY_DIR}/batch_${name}_${batch}.cpp)
    file(CONFIGURE OUTPUT ${file} CONTENT "${content}" @ONLY)
    set_source_files_properties(${file} PROPERTIES COMPILE_OPTIONS "-Wno-shadow;-Wno-subobject-linkage")  # names of one file in another, and types of a file in an included one; the preset dev compiles each alone
    list(APPEND files ${file})
  endforeach()
  set(${out} ${files} PARENT_SCOPE)
endfunction()
