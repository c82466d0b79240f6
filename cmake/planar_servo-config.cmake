# find_package(planar_servo): targets planar_servo::ROOM, and planar_servo::planar_servo for all rooms.
# The packages are those that the rooms link; C++ sees only Eigen, OpenCV's core and ViSP.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4)
find_dependency(OpenCV 4.5 COMPONENTS core imgproc calib3d aruco)
find_dependency(NLopt)
find_dependency(yaml-cpp)
find_dependency(fmt)
find_dependency(spdlog)
find_dependency(OpenSSL 3 COMPONENTS Crypto)
find_dependency(Threads)
find_dependency(OpenMP COMPONENTS CXX)
find_dependency(PkgConfig)
pkg_check_modules(LIBUSB QUIET IMPORTED_TARGET libusb-1.0)
pkg_check_modules(ARAVIS QUIET IMPORTED_TARGET aravis-0.8)
pkg_check_modules(MODBUS QUIET IMPORTED_TARGET libmodbus)

# In a function, because ViSP's package changes the caller's C++ standard and compiler flags.
function(planar_servo_find_visp)
  find_package(VISP 3.5 QUIET COMPONENTS visp_core visp_blob visp_robot visp_vs)
  set(VISP_FOUND ${VISP_FOUND} PARENT_SCOPE)
endfunction()
planar_servo_find_visp()

foreach(package LIBUSB ARAVIS MODBUS VISP)
  if(NOT ${package}_FOUND)
    set(planar_servo_FOUND FALSE)
    set(planar_servo_NOT_FOUND_MESSAGE "planar_servo needs ${package}, which is not installed")
    return()
  endif()
endforeach()

include(${CMAKE_CURRENT_LIST_DIR}/planar_servo-targets.cmake)
