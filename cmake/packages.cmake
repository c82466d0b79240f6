# The target `packages` writes the Debian packages into build/packages of the checkout, from what is
# built there: planar-servo is what is installed without a component, libplanar-servo-dev the component
# library, python3-planar-servo the component python where there is one. tools/package builds all.
# Included last: it looks at the rooms, programs and components of all folders.
include(GNUInstallDirs)

set(DEBIAN_MAINTAINER "planar-servo maintainers <maintainers@planar-servo.invalid>")
if(DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
  set(DEBIAN_MAINTAINER "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
string(TIMESTAMP DEBIAN_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)

# planar_package(COMPONENT NAME SECTION SYNOPSIS DESCRIPTION [DEPENDS]): one Debian package, with the
# copyright and the changelog that each must have.
function(planar_package component name section synopsis description)
  string(TOUPPER ${component} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${synopsis}\n${description}" PARENT_SCOPE)
  string(JOIN ", " depends ${ARGN})
  set(CPACK_DEBIAN_${key}_PACKAGE_DEPENDS "${depends}" PARENT_SCOPE)
  set(papers ${PROJECT_BINARY_DIR}/debian/${name})
  configure_file(${PROJECT_SOURCE_DIR}/cmake/debian/changelog.in ${papers}/changelog @ONLY)
  execute_process(COMMAND gzip -9nf ${papers}/changelog COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${papers}/changelog.gz ${PROJECT_SOURCE_DIR}/cmake/debian/copyright
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
endfunction()

planar_package(programs planar-servo science
  "position a planar arm to hundredths of a millimetre by one camera"
  "A camera above the arm watches two small lamps on its tool and corrects its
position. For one afternoon a laser tracker teaches the programs how camera and
arm err. They calibrate, position, certify, and rehearse all of it on virtual
cells, of which this package has some, with the report of a run.")
planar_package(library libplanar-servo-dev libdevel
  "visual servo of planar arms - headers and static libraries"
  "Finds lamps in images, fits cameras and error maps, and positions a planar arm
with them. CMake finds the package planar_servo and its target
planar_servo::planar_servo."
  libaravis-dev libeigen3-dev libfmt-dev libmodbus-dev libnlopt-cxx-dev libopencv-dev libspdlog-dev libssl-dev
  libusb-1.0-0-dev libvisp-dev libyaml-cpp-dev pkg-config)

set(CPACK_COMPONENTS_ALL programs library)
get_cmake_property(components COMPONENTS)
if(python IN_LIST components)
  planar_package(python python3-planar-servo python
    "visual servo of planar arms - Python module"
    "Finds lamps in images, fits cameras and error maps, and positions a planar arm
with them, in NumPy arrays."
    "python3 (>= 3.11)" "python3 (<< 3.12)" python3-numpy)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/debian/python/postinst
                                                ${PROJECT_SOURCE_DIR}/cmake/debian/python/prerm)
  install(DIRECTORY examples/python/ COMPONENT python EXCLUDE_FROM_ALL
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-planar-servo/examples
          PATTERN __pycache__ EXCLUDE)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-matplotlib)  # the examples plot
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR planar-servo)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_SOURCE_DIR}/build/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER ${DEBIAN_MAINTAINER})
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SOURCE planar-servo)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)

# What a reader may look at before the first run of their own.
set(sample ${PROJECT_BINARY_DIR}/sample)
add_custom_command(OUTPUT ${sample}/report.html
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${sample}
  COMMAND planar-experiment -q --cell calib/small/cell.yaml --grid circles:11x11:25mm --out ${sample}
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${sample}/recording/images
  DEPENDS planar-experiment calib/small/cell.yaml calib/small/truth.yaml
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} COMMENT "Running calib/small for its report" VERBATIM)
install(DIRECTORY ${sample} DESTINATION ${CMAKE_INSTALL_DOCDIR} OPTIONAL)
install(FILES README.md CHANGELOG.md CONTRIBUTING.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY doc DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN *.in EXCLUDE)
# The pages link to the benchmarks' tables.
install(DIRECTORY bench DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN *.md
        PATTERN .venv EXCLUDE)
install(DIRECTORY examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libplanar-servo-dev/examples
        COMPONENT library PATTERN python EXCLUDE)
install(DIRECTORY calib DESTINATION ${CMAKE_INSTALL_DATADIR}/planar-servo)

add_custom_target(packages
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${CPACK_PACKAGE_DIRECTORY}
  COMMAND ${CMAKE_CPACK_COMMAND} --config CPackConfig.cmake
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${CPACK_PACKAGE_DIRECTORY}/_CPack_Packages
  DEPENDS ${sample}/report.html WORKING_DIRECTORY ${PROJECT_BINARY_DIR} USES_TERMINAL VERBATIM)
get_property(rooms GLOBAL PROPERTY PLANAR_ROOMS)
list(TRANSFORM rooms PREPEND planar_)
add_dependencies(packages programs ${rooms})
if(python IN_LIST components)
  add_dependencies(packages python)
endif()
