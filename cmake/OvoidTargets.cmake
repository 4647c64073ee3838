# SPDX-License-Identifier: Apache-2.0
# The flags every target shares, and how a folder of src/ becomes a part of the library.

set(OVOID_IS_X86 OFF)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(OVOID_IS_X86 ON)
endif()

# What Debian builds its packages with (dpkg-buildflags with hardening=+all) and GCC does not do by itself: functions check their stack and
# the memory that they copy to, tables are read-only before main() begins, programs lie where the system likes. scripts/check_binaries.py
# reads the results. Beyond that -fstack-clash-protection: a frame that is larger than a page touches each of its pages. Sanitizers watch
# memory themselves. Not -fcf-protection: it does nothing beside a C library that is built without, as Debian's is.
include(CheckPIESupported)
check_pie_supported()
add_link_options(LINKER:-z,relro LINKER:-z,now)
if(NOT OVOID_SANITIZE)
  add_compile_options(-Wformat -Werror=format-security -fstack-protector-strong -fstack-clash-protection $<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE$<SEMICOLON>-D_FORTIFY_SOURCE=2>)
endif()

add_library(ovoid_flags INTERFACE)
# -ffp-contract=off: results do not depend on what the compiler chooses to fuse; SIMD code asks for fused operations by name.
target_compile_options(ovoid_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                             -ffp-contract=off)
# GCC takes an optional's value for uninitialised where it does not inline all that asks for it.
target_compile_options(ovoid_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
# clang warns of more: of an int64 that becomes a double (counts here are far below 2^53), and of members that are left to their defaults.
target_compile_options(ovoid_flags INTERFACE
  $<$<CXX_COMPILER_ID:Clang>:-Wno-implicit-int-float-conversion;-Wno-missing-field-initializers>)

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

# Code that no frame waits for: -O1 and -O2 take a quarter and a tenth of the compiler's time less than -O3. Under sanitizers all is -O1.
function(ovoid_optimise target level)
  if(level STREQUAL "0" AND OVOID_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  else()
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O${level}>)
    if(level STREQUAL "0")  # what is not optimised cannot be checked
      target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-U_FORTIFY_SOURCE>)
    endif()
  endif()
endfunction()

if(OVOID_SANITIZE)
  string(TOUPPER ${OVOID_SANITIZE} sanitizer)
  add_compile_definitions(OVOID_SANITIZED OVOID_SANITIZED_${sanitizer})  # compilers tell it by different names
endif()

# The library's code under sanitizers. UndefinedBehaviorSanitizer comes with AddressSanitizer, and traps: the calls that would say what is
# wrong take as long to compile again as the rest, and AddressSanitizer tells the line of a trap. Its checks that are AddressSanitizer's
# work, too, are left out. Of the parts a commit's checks leave those plain that read no files and make no models, or have no threads.
function(ovoid_sanitize target)
  set(plain_under_address "^ovoid_render")
  set(plain_under_thread "^ovoid_(io|fit|solid|scene|annotate)$")
  if(OVOID_SANITIZE AND NOT OVOID_SANITIZE_ALL AND target MATCHES "${plain_under_${OVOID_SANITIZE}}")
    target_compile_options(${target} PRIVATE -fno-sanitize=all)
  elseif(OVOID_SANITIZE STREQUAL "address")
    target_compile_options(${target} PRIVATE -fsanitize=undefined -fno-sanitize=null,object-size,vptr,function,pointer-overflow
                                             -fsanitize-trap=undefined)
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
  ovoid_sanitize(${name})
  if(OVOID_PCH)
    ovoid_precompile(${name} OVOID_PCH_OF_PARTS <Eigen/Core> <Eigen/Geometry> <fmt/format.h> <algorithm> <functional> <memory> <string>)
  endif()
  set_property(GLOBAL APPEND PROPERTY OVOID_PARTS ${name})
  set_property(GLOBAL APPEND PROPERTY OVOID_LINK ${ARG_LINK})
endfunction()

# Under AddressSanitizer, programs unload no library: see the source.
function(ovoid_unloads_nothing target)
  if(OVOID_SANITIZE STREQUAL "address")
    target_sources(${target} PRIVATE ${CMAKE_SOURCE_DIR}/tests/support/unload_nothing.cpp)
    target_link_options(${target} PRIVATE -Wl,--export-dynamic-symbol=dlclose)  # libraries shall find it
  endif()
endfunction()

# The SIMD targets of x86, by the names that OVOID_TARGET knows; Highway's other ones bring nothing here but compile time.
set(OVOID_X86_TARGETS scalar sse4 avx2 avx3)
if(OVOID_SIMD STREQUAL "few")
  set(OVOID_X86_TARGETS scalar avx2)
endif()

# ovoid_simd_sources(part sources... UNITS sources...): sources that Highway compiles once for each SIMD target. Of those under UNITS each
# target is a unit of its own, beside one that chooses among them and sees OVOID_SIMD_UNITS: they are dear, so compile beside each other,
# and none again because another target is wanted, too.
function(ovoid_simd_sources part)
  cmake_parse_arguments(ARG "" "" "UNITS" ${ARGN})
  set(sources ${ARG_UNPARSED_ARGUMENTS} ${ARG_UNITS})
  set_source_files_properties(${sources} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)  # no two fit into one unit
  if(OVOID_SIMD STREQUAL "scalar")
    set_source_files_properties(${sources} PROPERTIES COMPILE_DEFINITIONS HWY_COMPILE_ONLY_SCALAR)
    return()
  elseif(OVOID_SIMD STREQUAL "one")
    set_source_files_properties(${sources} PROPERTIES COMPILE_DEFINITIONS
      "HWY_COMPILE_ONLY_STATIC$<$<BOOL:${OVOID_IS_X86}>:$<SEMICOLON>HWY_BASELINE_TARGETS=HWY_AVX2>")
    return()
  elseif(NOT OVOID_IS_X86)
    return()
  endif()
  set(disabled HWY_SSSE3|HWY_AVX3_DL)
  if(OVOID_SIMD STREQUAL "few")
    string(APPEND disabled |HWY_SSE4|HWY_AVX3)
  endif()
  set_source_files_properties(${sources} PROPERTIES COMPILE_DEFINITIONS "HWY_DISABLED_TARGETS=(${disabled})")
  foreach(source IN LISTS ARG_UNITS)
    set_property(SOURCE ${source} APPEND PROPERTY COMPILE_DEFINITIONS OVOID_SIMD_UNITS)
    foreach(target IN LISTS OVOID_X86_TARGETS)
      set(baseline)
      if(NOT target STREQUAL "scalar")  # Highway's own choice where no flag promises more
        string(TOUPPER "#define HWY_BASELINE_TARGETS HWY_${target}\n" baseline)
        string(REPLACE "#DEFINE" "#define" baseline "${baseline}")
      endif()
      cmake_path(GET source STEM stem)
      set(unit ${CMAKE_CURRENT_BINARY_DIR}/${stem}.${target}.cpp)
      file(CONFIGURE OUTPUT ${unit} @ONLY CONTENT
           "#define HWY_COMPILE_ONLY_STATIC\n${baseline}#define OVOID_SIMD_UNIT\n#include \"${CMAKE_CURRENT_SOURCE_DIR}/${source}\"\n")
      target_sources(${part} PRIVATE ${unit})
      set_source_files_properties(${unit} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endforeach()
  endforeach()
endfunction()
