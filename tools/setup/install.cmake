# Rules of `cmake --install`. The install components have the names of the Debian packages
# (tools/setup/debian).

# The documentation, where its targets were built.
foreach(documentation guide reference)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/${documentation}/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/${documentation}
          COMPONENT rhoray-doc OPTIONAL)
endforeach()

if(NOT RHORAY_PROGRAMS)
  return()
endif()
install(TARGETS rhoray RUNTIME COMPONENT rhoray)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT rhoray)
install(DIRECTORY ${PROJECT_BINARY_DIR}/manuals/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT rhoray)
set(completions ${PROJECT_SOURCE_DIR}/tools/rhoray/completions)
install(FILES ${completions}/rhoray.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME rhoray
        COMPONENT rhoray)
install(FILES ${completions}/_rhoray DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT rhoray)
install(FILES ${completions}/rhoray.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
        COMPONENT rhoray)
install(FILES ${PROJECT_SOURCE_DIR}/tools/paraview/rho_file.py ${PROJECT_SOURCE_DIR}/tools/paraview/rhoray_reader.py
        DESTINATION ${CMAKE_INSTALL_DATADIR}/rhoray/paraview COMPONENT rhoray)

# rhoray_install_component(PACKAGE TARGET...): worker programs and modules; those that are not built
# are skipped.
function(rhoray_install_component package)
  foreach(target ${ARGN})
    if(TARGET ${target})
      install(TARGETS ${target} RUNTIME DESTINATION ${RHORAY_COMPONENT_DIR} LIBRARY DESTINATION ${RHORAY_COMPONENT_DIR}
              COMPONENT ${package})
    endif()
  endforeach()
endfunction()
rhoray_install_component(rhoray-import rhoray_import_worker rhoray_slices_worker rhoray-vdb-worker)
rhoray_install_component(rhoray-mesh rhoray-tetgen-worker rhoray-repair-worker rhoray-validate-worker)
rhoray_install_component(rhoray-pictures rhoray_pictures_module)
