# How every target of the project is built: C++17 (ViSP 3.5.0's headers are not C++20), warnings as
# errors, dependencies' headers as system headers. Of planar_options, which stays in this build,
# users of the installed library see nothing.

add_library(planar_options INTERFACE)
target_compile_features(planar_options INTERFACE cxx_std_17)
target_compile_options(planar_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
  -Woverloaded-virtual -Wold-style-cast -Werror -ffunction-sections -fdata-sections)
# The Python module is a shared library of the rooms. Functions still call their neighbours directly.
target_compile_options(planar_options INTERFACE -fPIC -fno-semantic-interposition)
# GCC collects its garbage at 128 MB and so at almost every template: later, it compiles an eighth faster.
target_compile_options(planar_options INTERFACE
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=524288;--param=ggc-min-expand=200>)
target_include_directories(planar_options INTERFACE ${PROJECT_SOURCE_DIR}/src)

# These need further libraries, Cairo 11, the others 110 to 220, such as GDAL, and so take up to 0.15 s of a program's
# start.
# planar_light() keeps them away from programs and tests that do not call them.
set(weighty visp_robot visp_vision opencv_imgcodecs PkgConfig::CAIRO)

# planar_weigh(LIST): replaces weighty libraries in the list by themselves for all but light programs.
function(planar_weigh list)
  foreach(library ${weighty})
    list(TRANSFORM ${list} REPLACE "^${library}$"
         "$<$<NOT:$<BOOL:$<TARGET_PROPERTY:PLANAR_LIGHT>>>:${library}>")
  endforeach()
  set(${list} "${${list}}" PARENT_SCOPE)
endfunction()

# ViSP's package publishes plain variables; this target carries its headers as system headers.
set(visp visp_core visp_blob visp_robot visp_vs)
planar_weigh(visp)
add_library(planar_visp INTERFACE)
target_include_directories(planar_visp SYSTEM INTERFACE ${VISP_INCLUDE_DIRS})
target_link_libraries(planar_visp INTERFACE ${visp})

# planar_precompiled(NAME LINKS packages HEADERS their headers ... [LEVEL -O1]): headers that many files
# include, compiled once for the targets that planar_precompile() names. A file still includes what it
# uses. GCC takes the level of optimisation from the compiled headers: LEVEL is that of these targets in
# a release, where it is not the usual one.
function(planar_precompiled name)
  cmake_parse_arguments(PCH "" "LEVEL" "LINKS;HEADERS" ${ARGN})
  set(source ${PROJECT_BINARY_DIR}/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "")
  add_library(${name} OBJECT ${source})
  set_target_properties(${name} PROPERTIES CXX_STANDARD 17 CXX_EXTENSIONS OFF)
  target_link_libraries(${name} PRIVATE planar_options Eigen3::Eigen fmt::fmt ${PCH_LINKS})
  set_property(GLOBAL PROPERTY PLANAR_LEVEL_${name} $<$<CONFIG:Release>:${PCH_LEVEL}>)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:${PCH_LEVEL}>)
  list(TRANSFORM PCH_HEADERS REPLACE "(.+)" "<\\1>")
  target_precompile_headers(${name} PRIVATE
    <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional> <limits>
    <map> <memory> <mutex> <optional> <random> <set> <sstream> <stdexcept> <string> <thread>
    <variant> <vector> <Eigen/Geometry> <fmt/format.h> ${PCH_HEADERS})
endfunction()

# planar_precompile(TARGET NAME): GCC takes the compiled headers only together with the macros that
# they were compiled with, hence fmt's.
function(planar_precompile target name)
  get_property(level GLOBAL PROPERTY PLANAR_LEVEL_${name})
  target_compile_options(${target} PRIVATE ${level})
  target_link_libraries(${target} PRIVATE fmt::fmt)
  target_precompile_headers(${target} REUSE_FROM ${name})
endfunction()

planar_precompiled(planar_room_headers LINKS opencv_core HEADERS opencv2/core.hpp)
# Programs and the rooms above the loop are large and compute little: -O1 takes a sixth off.
# (CLI11's headers hold objects that each file would have to build: compiled beforehand they save nothing.)
planar_precompiled(planar_program_headers
  LINKS nlohmann_json::nlohmann_json opencv_core
  HEADERS nlohmann/json.hpp opencv2/core.hpp LEVEL -O1)

# planar_room(NAME [COMPUTES] LINKS rooms and packages others may see [PRIVATE_LINKS hidden ones])
# One library per room, of every source in its folder; without sources it is headers only. The link
# list is the dependency rule (see doc/architecture.md): it names every room that the room includes,
# and only rooms above it in src/CMakeLists.txt. The test "house" holds the includes against it.
function(planar_room name)
  cmake_parse_arguments(ROOM "COMPUTES" "" "LINKS;PRIVATE_LINKS" ${ARGN})
  foreach(link ${ROOM_LINKS} ${ROOM_PRIVATE_LINKS})
    if(link MATCHES "^planar_" AND NOT TARGET ${link})
      message(FATAL_ERROR "the room ${name} links ${link}, which does not stand above it")
    endif()
  endforeach()
  set(private_links ${ROOM_PRIVATE_LINKS})
  planar_weigh(private_links)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS *.cpp)
  if(sources)
    add_library(planar_${name} STATIC ${sources})
    set_target_properties(planar_${name} PROPERTIES CXX_STANDARD 17 CXX_EXTENSIONS OFF
                          UNITY_BUILD ${PLANAR_UNITY} UNITY_BUILD_BATCH_SIZE 12)
    target_compile_features(planar_${name} PUBLIC cxx_std_17)
    target_link_libraries(planar_${name} PUBLIC $<BUILD_INTERFACE:planar_options> ${ROOM_LINKS}
                                         PRIVATE ${private_links})
    if(ROOM_COMPUTES)
      planar_precompile(planar_${name} planar_room_headers)
    else()
      planar_precompile(planar_${name} planar_program_headers)
    endif()
  else()
    add_library(planar_${name} INTERFACE)
    target_compile_features(planar_${name} INTERFACE cxx_std_17)
    target_link_libraries(planar_${name} INTERFACE $<BUILD_INTERFACE:planar_options> ${ROOM_LINKS})
  endif()
  set_property(GLOBAL APPEND PROPERTY PLANAR_ROOMS ${name})
  set_property(GLOBAL PROPERTY PLANAR_LINKS_${name} ${ROOM_LINKS})
  set_property(GLOBAL PROPERTY PLANAR_PRIVATE_LINKS_${name} ${ROOM_PRIVATE_LINKS})
endfunction()

# planar_forbid(NAME ROOM...): the room must not link these, not even through others.
function(planar_forbid name)
  set(seen ${name})
  set(open ${name})
  while(open)
    list(POP_FRONT open room)
    get_property(links GLOBAL PROPERTY PLANAR_LINKS_${room})
    get_property(private_links GLOBAL PROPERTY PLANAR_PRIVATE_LINKS_${room})
    foreach(link ${links} ${private_links})
      string(REGEX REPLACE "^planar_" "" linked ${link})
      if(linked IN_LIST ARGN)
        message(FATAL_ERROR "the room ${name} must not link ${linked}; it does through ${room}")
      endif()
      if(link MATCHES "^planar_" AND NOT linked IN_LIST seen)
        list(APPEND seen ${linked})
        list(APPEND open ${linked})
      endif()
    endforeach()
  endwhile()
endfunction()

# planar_wall(FOLDER OTHER...): no file in this folder of a room includes one of these folders.
function(planar_wall folder)
  set_property(GLOBAL APPEND PROPERTY PLANAR_WALLS ${folder})
  string(REPLACE ";" "|" others "${ARGN}")
  set_property(GLOBAL PROPERTY PLANAR_BEHIND_${folder} ${others})
endfunction()

# planar_write_house(FILE): the rooms, their links and walls, for cmake/check_house.cmake.
function(planar_write_house file)
  get_property(rooms GLOBAL PROPERTY PLANAR_ROOMS)
  set(text "set(rooms ${rooms})\n")
  foreach(room ${rooms})
    get_property(links GLOBAL PROPERTY PLANAR_LINKS_${room})
    get_property(private_links GLOBAL PROPERTY PLANAR_PRIVATE_LINKS_${room})
    string(APPEND text "set(links_${room} ${links})\nset(private_links_${room} ${private_links})\n")
  endforeach()
  get_property(walls GLOBAL PROPERTY PLANAR_WALLS)
  string(APPEND text "set(walls ${walls})\n")
  foreach(folder ${walls})
    get_property(others GLOBAL PROPERTY PLANAR_BEHIND_${folder})
    string(APPEND text "set(behind_${folder} \"${others}\")\n")
  endforeach()
  file(WRITE ${file} "${text}")
endfunction()

# planar_main(TARGET ROOM...): a program that is installed, from tools/TARGET.cpp upon these rooms.
function(planar_main target)
  list(TRANSFORM ARGN PREPEND planar_ OUTPUT_VARIABLE rooms)
  string(REPLACE "-" "_" source ${target})
  add_executable(${target} ${source}.cpp)
  set_target_properties(${target} PROPERTIES CXX_STANDARD 17 CXX_EXTENSIONS OFF
                        RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  target_link_libraries(${target} PRIVATE planar_program ${rooms})
  planar_precompile(${target} planar_program_headers)
  add_dependencies(programs ${target})
  install(TARGETS ${target})
endfunction()

# planar_program(NAME ROOM...): the program planar-NAME.
function(planar_program name)
  planar_main(planar-${name} ${ARGN})
endfunction()

# planar_light(TARGET [LIBRARY...]): links a program without functions that it does not call and
# without the weighty libraries that only those need, except for these. A call that needs another one
# is then an undefined reference. Only an optimiser leaves out enough of what is not called.
function(planar_light target)
  if(CMAKE_BUILD_TYPE STREQUAL Release)
    set_target_properties(${target} PROPERTIES PLANAR_LIGHT ON)
    target_link_options(${target} PRIVATE -Wl,--gc-sections)
    target_link_libraries(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# CMake splits the name of a test case at a semicolon; what it then asks for does not exist and must
# not pass for a test.
set(must_match --warn NoTests)

# What tests/support/shared_data.cpp prints when a case ends for want of its data, which is no success.
set(lacks_data SKIP_REGULAR_EXPRESSION "skipped: no ")

# Devices that are served in real time cannot wait for a busy machine: other tests give way to them.
set(give_way nice -n 10)

# planar_test(ROOM SOURCES ... LINKS ... [PROPERTIES ...]): the test program of one room, every case
# known to ctest, with these properties. Each case is a process: weighty libraries that its room calls
# stand in LINKS, others are not loaded.
function(planar_test room)
  cmake_parse_arguments(TEST "" "" "SOURCES;LINKS;PROPERTIES" ${ARGN})
  add_executable(${room}_test ${TEST_SOURCES})
  set_target_properties(${room}_test PROPERTIES CXX_STANDARD 17 CXX_EXTENSIONS OFF
                        UNITY_BUILD ${PLANAR_UNITY} UNITY_BUILD_BATCH_SIZE 10
                        CROSSCOMPILING_EMULATOR "${give_way}")
  target_link_libraries(${room}_test PRIVATE planar_test_main ${TEST_LINKS})
  planar_precompile(${room}_test planar_test_headers)
  planar_light(${room}_test)
  catch_discover_tests(${room}_test TEST_PREFIX "${room}: " EXTRA_ARGS ${must_match}
                       PROPERTIES TIMEOUT 300 ${lacks_data} ${TEST_PROPERTIES})
endfunction()

# planar_wire_test(NAME SOURCES ... LINKS ...): a test program that talks to USB devices emulated
# below libusb. It runs under umockdev-wrapper; where that is absent ctest counts it as skipped. The
# wrapper's library comes before that of the address sanitizer, which minds unless it is told not to.
function(planar_wire_test name)
  cmake_parse_arguments(TEST "" "" "SOURCES;LINKS" ${ARGN})
  if(NOT TARGET planar_mock_usb)
    add_test(NAME "${name}: on the wire"
             COMMAND ${CMAKE_COMMAND} -E echo "skipped: umockdev is not installed")
    set_tests_properties("${name}: on the wire" PROPERTIES SKIP_REGULAR_EXPRESSION "^skipped")
    return()
  endif()
  add_executable(${name}_test ${TEST_SOURCES})
  set_target_properties(${name}_test PROPERTIES CXX_STANDARD 17 CXX_EXTENSIONS OFF
                        CROSSCOMPILING_EMULATOR
                        "env;ASAN_OPTIONS=verify_asan_link_order=0;${UMOCKDEV_WRAPPER}")
  target_link_libraries(${name}_test PRIVATE planar_test_main planar_wire_guard planar_mock_usb
                                             ${TEST_LINKS})
  planar_precompile(${name}_test planar_test_headers)
  planar_light(${name}_test)
  catch_discover_tests(${name}_test TEST_PREFIX "${name}: " EXTRA_ARGS ${must_match}
                       PROPERTIES TIMEOUT 300 SKIP_RETURN_CODE 77)
endfunction()

# planar_gige_test(NAME SOURCES ... LINKS ...): a test program that serves a GigE camera on a loopback
# of its own; ctest counts it as skipped where that is impossible.
function(planar_gige_test name)
  cmake_parse_arguments(TEST "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name}_test ${TEST_SOURCES})
  set_target_properties(${name}_test PROPERTIES CXX_STANDARD 17 CXX_EXTENSIONS OFF
    CROSSCOMPILING_EMULATOR ${PROJECT_SOURCE_DIR}/tests/support/loopback_only.sh)
  target_link_libraries(${name}_test PRIVATE planar_test_main planar_gige_guard planar_machine
                                             ${TEST_LINKS})
  planar_precompile(${name}_test planar_test_headers)
  planar_light(${name}_test)
  catch_discover_tests(${name}_test TEST_PREFIX "${name}: " EXTRA_ARGS ${must_match}
                       PROPERTIES TIMEOUT 300 SKIP_RETURN_CODE 77 RESOURCE_LOCK gige_camera)
endfunction()
