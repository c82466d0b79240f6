# planar_install_library(EXCEPT ROOM... HEADERS PATTERN...): what `cmake --install BUILD --component
# library` hands to other projects: one static library per room but these, the headers below
# src/planar_servo of these names (without .h) with all that they include, and the package
# planar_servo with a target planar_servo::ROOM for each and planar_servo::planar_servo for all.
# `--component api` has Doxygen make the pages of those headers.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# planar_public_headers(VARIABLE PATTERN...): these headers of planar_servo and all that they include,
# relative to src.
function(planar_public_headers variable)
  set(src ${PROJECT_SOURCE_DIR}/src)
  list(TRANSFORM ARGN REPLACE "(.+)" "${src}/planar_servo/\\1.h")
  file(GLOB open CONFIGURE_DEPENDS RELATIVE ${src} ${ARGN})
  set(headers "")
  while(open)
    list(POP_FRONT open header)
    if(header IN_LIST headers)
      continue()
    endif()
    list(APPEND headers ${header})
    file(STRINGS ${src}/${header} included REGEX "^#include \"planar_servo/")
    list(TRANSFORM included REPLACE "^#include \"(.*)\".*" "\\1")
    list(APPEND open ${included})
  endwhile()
  set(${variable} ${headers} PARENT_SCOPE)
endfunction()

function(planar_install_library)
  cmake_parse_arguments(LIBRARY "" "" "EXCEPT;HEADERS" ${ARGN})
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
  endforeach()
  planar_public_headers(headers ${LIBRARY_HEADERS})
  foreach(header ${headers})
    string(APPEND DOXYGEN_INPUT " \"${PROJECT_SOURCE_DIR}/src/${header}\"")
    cmake_path(GET header PARENT_PATH folder)
    install(FILES ${PROJECT_SOURCE_DIR}/src/${header} COMPONENT library
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder})
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
