# cmake -DSRC=the folder of the rooms -P check_faces.cmake
# Fails when a header of the library makes its users compile what only our source files need: a
# matrix decomposition, OpenCV beyond its matrices and rectangles, or JSON. Exceptions: base/core/pose.h needs Eigen/Geometry, which brings decompositions of its own; a vpRobot
# needs ViSP's header.
cmake_minimum_required(VERSION 3.25)
set(library base geometry lamps learn calibration hardware loop files machine)
string(CONCAT heavy "^#include [<\"](Eigen/(Cholesky|Dense|Eigenvalues|LU|QR|SVD|Sparse.*)|"
                    "opencv2/([a-bd-z]|calib3d|core/utils).*|nlohmann/json\\.hpp|spdlog/.*|CLI/.*|"
                    "yaml-cpp/.*)[>\"]")
set(faults "")

foreach(room ${library})
  file(GLOB_RECURSE headers RELATIVE ${SRC} ${SRC}/${room}/*.h)
  if(NOT headers)
    string(APPEND faults "${room}: has no headers\n")
  endif()
  foreach(header ${headers})
    file(STRINGS ${SRC}/${header} includes REGEX "${heavy}")
    if(includes)
      string(APPEND faults "${header}: ${includes} belongs in a source file\n")
    endif()
  endforeach()
endforeach()

if(faults)
  message(FATAL_ERROR "${faults}")
endif()
