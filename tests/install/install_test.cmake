# SPDX-License-Identifier: Apache-2.0
# Installs the build tree into a fresh folder, then configures, builds and runs the examples against it and nothing else.
# Fails if a header, a dependency of the package file or the program is missing from what gets installed.
#   cmake -DSOURCE=... -DBUILD=... -DWORK=... -DPYTHON=... [-DHARDENED=--hardened] [-DWIDE=-mavx] [-DVTK=ON] [-DMAPPERS=FOLDER -DMAPPERS_PYTHON=...] -P install_test.cmake

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

# None of it looks for libraries where it is called, and releases are hardened.
run(${PYTHON} ${SOURCE}/scripts/check_binaries.py ${HARDENED} ${prefix})

file(GLOB_RECURSE public RELATIVE ${SOURCE}/include ${SOURCE}/include/*)
file(GLOB_RECURSE installed RELATIVE ${prefix}/include ${prefix}/include/ovoid/*)
if(NOT "${public}" STREQUAL "${installed}")
  message(FATAL_ERROR "installed headers differ from include/:\n${installed}\n${public}")
endif()

foreach(completion bash-completion/completions/ovoid zsh/site-functions/_ovoid fish/vendor_completions.d/ovoid.fish)
  if(NOT EXISTS ${prefix}/share/${completion})
    message(FATAL_ERROR "share/${completion} is not installed")
  endif()
endforeach()

run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE}/examples -B ${WORK}/build
    -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=${FLAGS} -Wall -Wextra -Werror")
run(${CMAKE_COMMAND} --build ${WORK}/build)

function(expect_picture path)
  file(READ ${path} signature LIMIT 4 HEX)
  if(NOT signature STREQUAL "89504e47")
    message(FATAL_ERROR "${path} is no PNG: it starts with ${signature}")
  endif()
endfunction()

set(volume ${WORK}/volume.nrrd)
run(${prefix}/bin/ovoid make marschner-lobb --size 32 -o ${volume})
run(${WORK}/build/01_volume_to_png/volume_to_png ${volume} ${WORK}/picture.png)
expect_picture(${WORK}/picture.png)
run(${WORK}/build/02_looks/looks ${volume} ${WORK}/looks)
foreach(look default ramp own brightest)
  expect_picture(${WORK}/looks-${look}.png)
endforeach()
run(${WORK}/build/03_time_steps/time_steps ${volume} ${WORK}/step)
expect_picture(${WORK}/step0.png)
run(${WORK}/build/04_brick_source/brick_source ${WORK}/gyroid.png)
expect_picture(${WORK}/gyroid.png)
run(${WORK}/build/05_profile/profile ${volume})
run(${WORK}/build/06_embedding/embedding ${volume} ${WORK}/embedded.png)
expect_picture(${WORK}/embedded.png)
run(${prefix}/bin/ovoid make blobs -o ${WORK}/blobs.ply)
run(${WORK}/build/01_volume_to_png/volume_to_png ${WORK}/blobs.ply ${WORK}/blobs.png)
expect_picture(${WORK}/blobs.png)
if(VTK)  # ovoid-read is found from where the library lies
  run(${prefix}/bin/ovoid make fin -o ${WORK}/fin.vtu)
  run(${WORK}/build/01_volume_to_png/volume_to_png ${WORK}/fin.vtu ${WORK}/fin.png)
  expect_picture(${WORK}/fin.png)
endif()
run(${WORK}/build/07_mesh/mesh ${WORK}/mesh.png)
expect_picture(${WORK}/mesh.png)
run(${WORK}/build/08_particles/particles ${WORK}/particles.png)
expect_picture(${WORK}/particles.png)

# The mappers for VTK find the installed library from where they lie.
if(MAPPERS)
  set(ENV{PYTHONPATH} ${prefix}/${MAPPERS})
  run(${MAPPERS_PYTHON} -c "from ovoid_vtk.vtkOvoid import vtkOvoidVolumeMapper; print(vtkOvoidVolumeMapper())")
endif()

# A program built for wider registers than the library draws the same bytes: both see one layout of everything public.
if(WIDE)
  run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE}/examples/07_mesh -B ${WORK}/wide
      -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=${FLAGS} ${WIDE}")
  run(${CMAKE_COMMAND} --build ${WORK}/wide)
  run(${WORK}/wide/mesh ${WORK}/wide.png)
  file(SHA256 ${WORK}/mesh.png here)
  file(SHA256 ${WORK}/wide.png wide)
  if(NOT here STREQUAL wide)
    message(FATAL_ERROR "a program built with ${WIDE} draws another picture")
  endif()
endif()
