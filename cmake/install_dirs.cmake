# Where things go, and where what was installed finds its libraries (docs/decisions/0022-wheel.md).
#   an installation: bin/stiction, lib, include, share/stiction/{tasks,models,scenarios,experiments}, share/stiction/python/{stiction,stiction_view}
#   a wheel: the same folders inside the Python package `stiction`, which is the module, too
if(SKBUILD)
  set(STICTION_INSTALL_LIBDIR stiction/lib)
  set(STICTION_INSTALL_INCLUDEDIR stiction/include)
  set(STICTION_INSTALL_PACKAGESDIR .)  # the prefix is the folder of the Python packages
  set(STICTION_INSTALL_BINDIR stiction/bin)
  set(STICTION_INSTALL_DATADIR stiction/share/stiction)
  set(STICTION_INSTALL_MODULEDIR .)
else()
  set(STICTION_INSTALL_LIBDIR ${CMAKE_INSTALL_LIBDIR})
  set(STICTION_INSTALL_INCLUDEDIR ${CMAKE_INSTALL_INCLUDEDIR})
  set(STICTION_INSTALL_PACKAGESDIR ${STICTION_SITE_PACKAGES})
  set(STICTION_INSTALL_BINDIR ${CMAKE_INSTALL_BINDIR})
  set(STICTION_INSTALL_DATADIR share/stiction)
  set(STICTION_INSTALL_MODULEDIR share/stiction/python)
endif()

# stiction_set_install_rpath(TARGET FOLDER): of a target that goes to FOLDER, relative to the prefix.
function(stiction_set_install_rpath target folder)
  if(STICTION_RELOCATABLE)  # the prefix is the folder of the Python packages
    file(RELATIVE_PATH up /prefix/${folder} /prefix)
    set(rpath $ORIGIN/${up}stiction.libs)
  else()
    set(rpath ${cmeel_prefix}/lib ${mujoco_folder})
  endif()
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "${rpath}")
endfunction()
