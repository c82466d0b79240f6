# planar_install_library(EXCEPT ROOM...): what `cmake --install BUILD --component library` hands to
# other projects: one static library per room but these, their headers, and the package planar_servo
# with a target planar_servo::ROOM for each and planar_servo::planar_servo for all. `--component api`
# has Doxygen make the pages of those headers.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

function(planar_install_library)
  cmake_parse_arguments(LIBRARY "" "" "EXCEPT" ${ARGN})
  get_property(rooms GLOBAL PROPERTY PLANAR_ROOMS)
  list(REMOVE_ITEM rooms ${LIBRARY_EXCEPT})
  set(package ${CMAKE_INSTALL_LIBDIR}/cmake/planar_servo)

  add_library(planar_library INTERFACE)
  set_target_properties(planar_library PROPERTIES EXPORT_NAME planar_servo)
  set_target_properties(planar_visp PROPERTIES EXPORT_NAME visp)
  set(targets planar_library planar_visp)
  foreach(room ${rooms})
    set_target_properties(planar_${room} PROPERTIES EXPORT_NAME ${room})
    target_link_libraries(planar_library INTERFACE planar_${room})
    list(APPEND targets planar_${room})
    set(folder ${PROJECT_SOURCE_DIR}/src/planar_servo/${room})
    string(APPEND DOXYGEN_INPUT " \"${folder}\"")
    install(DIRECTORY ${folder} COMPONENT library
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/planar_servo FILES_MATCHING PATTERN *.h)
  endforeach()
  install(TARGETS ${targets} EXPORT planar_servo COMPONENT library
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/planar_servo
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT planar_servo NAMESPACE planar_servo:: FILE planar_servo-targets.cmake
          DESTINATION ${package} COMPONENT library)

  set(version ${PROJECT_BINARY_DIR}/planar_servo-config-version.cmake)
  write_basic_package_version_file(${version} COMPATIBILITY SameMinorVersion)
  install(FILES ${version} ${PROJECT_SOURCE_DIR}/cmake/planar_servo-config.cmake
          DESTINATION ${package} COMPONENT library)

  configure_file(${PROJECT_SOURCE_DIR}/doc/Doxyfile.in ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)
  install(CODE "set(pages \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DOCDIR}\")
                file(MAKE_DIRECTORY \"\${pages}\")
                execute_process(COMMAND \"\${CMAKE_COMMAND}\" -E env \"DOXYGEN_OUTPUT=\${pages}\"
                                        doxygen \"${PROJECT_BINARY_DIR}/Doxyfile\"
                                COMMAND_ERROR_IS_FATAL ANY)" COMPONENT api EXCLUDE_FROM_ALL)
endfunction()
