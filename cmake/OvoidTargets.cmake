# SPDX-License-Identifier: Apache-2.0
# The flags every target shares, and how a folder of src/ becomes a part of the library.

add_library(ovoid_flags INTERFACE)
# -ffp-contract=off: results do not depend on what the compiler chooses to fuse; SIMD code asks for fused operations by name.
target_compile_options(ovoid_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                             -ffp-contract=off)

# ovoid_part(name DEPENDS parts... LINK libraries...): an object library of the folder's sources (x_test.cpp files belong to tests/).
function(ovoid_part name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;LINK" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  if(NOT sources)  # a part of headers alone; CMake wants at least one source
    set(sources ${CMAKE_CURRENT_BINARY_DIR}/${name}_headers_only.cpp)
    file(CONFIGURE OUTPUT ${sources} CONTENT "// ${name} has headers only.\n")
  endif()
  add_library(${name} OBJECT ${sources})
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR}/include ${CMAKE_SOURCE_DIR}/src)
  target_link_libraries(${name} PUBLIC Eigen3::Eigen PRIVATE ovoid_flags fmt::fmt ${ARG_LINK})
  set_property(GLOBAL APPEND PROPERTY OVOID_PARTS ${name})
  set_property(GLOBAL APPEND PROPERTY OVOID_LINK ${ARG_LINK})
endfunction()
