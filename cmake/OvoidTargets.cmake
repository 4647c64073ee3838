# SPDX-License-Identifier: Apache-2.0
# The flags every target shares, and how a folder of src/ becomes a part of the library.

add_library(ovoid_flags INTERFACE)
# -ffp-contract=off: results do not depend on what the compiler chooses to fuse; SIMD code asks for fused operations by name.
target_compile_options(ovoid_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                             -ffp-contract=off)

# Of sources that are put together the compiler takes each one's own types for types that others could see.
if(CMAKE_UNITY_BUILD)
  target_compile_options(ovoid_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()

# ovoid_precompile(target owner headers...): the first target asked for under a name of `owner` compiles the headers, the rest reuse them.
function(ovoid_precompile target owner)
  get_property(first GLOBAL PROPERTY ${owner})
  if(first)
    target_precompile_headers(${target} REUSE_FROM ${first})
  else()
    target_precompile_headers(${target} PRIVATE ${ARGN})
    set_property(GLOBAL PROPERTY ${owner} ${target})
  endif()
endfunction()

# ovoid_part(name FOLDERS folders... LINK libraries...): an object library of the sources in this folder and in those (x_test.cpp files belong to tests/).
function(ovoid_part name)
  cmake_parse_arguments(ARG "" "" "FOLDERS;LINK" ${ARGN})
  list(TRANSFORM ARG_FOLDERS REPLACE "(.+)" "${CMAKE_CURRENT_SOURCE_DIR}/\\1/*.cpp" OUTPUT_VARIABLE patterns)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp ${patterns})
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  if(NOT sources)  # a part of headers alone; CMake wants at least one source
    set(sources ${CMAKE_CURRENT_BINARY_DIR}/${name}_headers_only.cpp)
    file(CONFIGURE OUTPUT ${sources} CONTENT "// ${name} has headers only.\n")
  endif()
  add_library(${name} OBJECT ${sources})
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR}/include ${CMAKE_SOURCE_DIR}/src)
  target_link_libraries(${name} PUBLIC Eigen3::Eigen PRIVATE ovoid_flags fmt::fmt ${ARG_LINK})
  if(OVOID_PCH)
    ovoid_precompile(${name} OVOID_PCH_OF_PARTS <Eigen/Core> <Eigen/Geometry> <fmt/format.h> <algorithm> <functional> <memory> <string>)
  endif()
  set_property(GLOBAL APPEND PROPERTY OVOID_PARTS ${name})
  set_property(GLOBAL APPEND PROPERTY OVOID_LINK ${ARG_LINK})
endfunction()

# Under AddressSanitizer, programs unload no library: see the source.
function(ovoid_unloads_nothing target)
  if(CMAKE_CXX_FLAGS MATCHES "fsanitize=address")
    target_sources(${target} PRIVATE ${CMAKE_SOURCE_DIR}/tests/support/unload_nothing.cpp)
    target_link_options(${target} PRIVATE -Wl,--export-dynamic-symbol=dlclose)  # libraries shall find it
  endif()
endfunction()

# The instruction sets for which a part's SIMD sources are compiled; all parts must agree. Scalar, SSE4, AVX2 and AVX-512 on x86; those
# between bring nothing here but compile time.
function(ovoid_simd_targets part)
  if(OVOID_SIMD STREQUAL "scalar")
    target_compile_definitions(${part} PRIVATE HWY_COMPILE_ONLY_SCALAR)
  elseif(OVOID_SIMD STREQUAL "one")
    target_compile_definitions(${part} PRIVATE HWY_COMPILE_ONLY_STATIC)
    if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
      target_compile_definitions(${part} PRIVATE HWY_BASELINE_TARGETS=HWY_AVX2)
    endif()
  else()
    target_compile_definitions(${part} PRIVATE "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_AVX3_DL)")
  endif()
endfunction()
