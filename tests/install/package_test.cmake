# SPDX-License-Identifier: Apache-2.0
# Makes the .deb, installs it into an empty root, and draws with the program that lies there: samples by the library alone, and a
# mesh that its ovoid-read reads. Fails if a file or a dependency is missing, or if anything of the build tree is used.
#   cmake -DBUILD=... -DWORK=... -P package_test.cmake

file(REMOVE_RECURSE ${WORK})
set(root ${WORK}/root)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    string(JOIN " " command ${ARGN})
    message(FATAL_ERROR "${command}\nended with ${status}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_CPACK_COMMAND} --config ${BUILD}/CPackConfig.cmake -B ${WORK}/made)
file(GLOB package ${WORK}/made/*.deb)
run(dpkg-deb --extract ${package} ${root})

# What it links, and what the library loads by name.
run(dpkg-deb --field ${package} Depends)
foreach(needed libc6 libstdc++6 libpng16 libhdf5 libvtk9)
  string(FIND "${output}" ${needed} place)
  if(place EQUAL -1)
    message(FATAL_ERROR "the package does not depend on ${needed}:\n${output}")
  endif()
endforeach()

file(GLOB library ${root}/usr/lib/libovoid.so.*.*.*)
foreach(file ${root}/usr/bin/ovoid ${root}/usr/bin/ovoid-viewer ${root}/usr/libexec/ovoid/ovoid-read ${library})
  run(ldd ${file})
  if(output MATCHES "not found" OR output MATCHES "${BUILD}/(bin|src)")
    message(FATAL_ERROR "${file} links what the package does not bring:\n${output}")
  endif()
  if(NOT file MATCHES "ovoid-read$|libovoid" AND NOT output MATCHES "${root}/usr/[^ ]*libovoid")
    message(FATAL_ERROR "${file} does not find the package's own library:\n${output}")
  endif()
endforeach()
foreach(file include/ovoid/ovoid.h lib/cmake/ovoid/ovoid-config.cmake share/doc/ovoid/copyright)
  if(NOT EXISTS ${root}/usr/${file})
    message(FATAL_ERROR "usr/${file} is not in the package")
  endif()
endforeach()

set(ovoid ${CMAKE_COMMAND} -E env --unset=OVOID_READER --unset=LD_LIBRARY_PATH ${root}/usr/bin/ovoid)
foreach(sample marschner-lobb.nrrd fin.vtu)
  string(REGEX REPLACE "\\..*" "" name ${sample})
  run(${ovoid} make ${name} -o ${WORK}/${sample})
  run(${ovoid} render ${WORK}/${sample} -o ${WORK}/${name}.png --size 128x96)
  file(READ ${WORK}/${name}.png signature LIMIT 4 HEX)
  if(NOT signature STREQUAL "89504e47")
    message(FATAL_ERROR "${name}.png is no PNG: it starts with ${signature}")
  endif()
endforeach()
