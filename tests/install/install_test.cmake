# SPDX-License-Identifier: Apache-2.0
# Installs the build tree into a fresh folder, then configures, builds and runs the first example against it and nothing else.
# Fails if a header, a dependency of the package file or the program is missing from what gets installed.
#   cmake -DSOURCE=... -DBUILD=... -DWORK=... -P install_test.cmake

file(REMOVE_RECURSE ${WORK})
set(prefix ${WORK}/prefix)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    string(JOIN " " command ${ARGN})
    message(FATAL_ERROR "${command}\nended with ${status}:\n${output}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})

file(GLOB_RECURSE public RELATIVE ${SOURCE}/include ${SOURCE}/include/*)
file(GLOB_RECURSE installed RELATIVE ${prefix}/include ${prefix}/include/*)
if(NOT "${public}" STREQUAL "${installed}")
  message(FATAL_ERROR "installed headers differ from include/:\n${installed}\n${public}")
endif()

run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE}/examples/01_volume_to_png -B ${WORK}/build
    -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=${FLAGS}")
run(${CMAKE_COMMAND} --build ${WORK}/build)

run(${prefix}/bin/ovoid make marschner-lobb --size 32 -o ${WORK}/volume.nrrd)
run(${WORK}/build/volume_to_png ${WORK}/volume.nrrd ${WORK}/picture.png)
file(READ ${WORK}/picture.png signature LIMIT 4 HEX)
if(NOT signature STREQUAL "89504e47")
  message(FATAL_ERROR "the example's picture is no PNG: it starts with ${signature}")
endif()
