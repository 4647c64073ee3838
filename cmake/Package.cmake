# SPDX-License-Identifier: Apache-2.0
# `make package`: a .deb of everything that is installed, and one of the Python package where that is built. What programs and library
# link is found by dpkg-shlibdeps; HDF5, which the library loads by name, is among it because ovoid-read links the same one.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ovoid)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "The Ovoid authors <nobody@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "volume rendering straight from the points of the data")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})  # libovoid is in no package yet

# The mappers for VTK (component vtk) would make a package depend on VTK's Python: they are installed by hand.
set(CPACK_COMPONENTS_ALL Unspecified)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME ovoid)
set(CPACK_DEBIAN_UNSPECIFIED_FILE_NAME DEB-DEFAULT)
set(CPACK_COMPONENT_UNSPECIFIED_DESCRIPTION "Draws scans, meshes and particles by splatting: a program, its window, and a C++ library.")
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS "libvulkan1, libgl1")  # loaded by name, and done without
# For programs with the library; for films; the window's dialog for files.
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SUGGESTS "libeigen3-dev, ffmpeg, zenity | kdialog")
if(BUILD_SHARED_LIBS)  # for packages of programs that link it
  file(WRITE ${CMAKE_BINARY_DIR}/deb/ovoid/shlibs "libovoid ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} ovoid (= ${PROJECT_VERSION})\n")
  set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_CONTROL_EXTRA ${CMAKE_BINARY_DIR}/deb/ovoid/shlibs)
endif()

if(TARGET ovoid_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  math(EXPR next_python "${Python_VERSION_MINOR} + 1")  # pybind11's modules are of one minor version
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-ovoid)
  set(CPACK_DEBIAN_PYTHON_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Draws volumetric data from Python: arrays and files in, pictures out.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "ovoid (= ${PROJECT_VERSION}), python3 (>= 3.${Python_VERSION_MINOR}~), python3 (<< 3.${next_python}), python3-numpy")
  # As Debian's packages of Python do: compiled when installed, and nothing left when removed.
  set(extra)
  foreach(script IN ITEMS "postinst configure py3compile" "prerm remove py3clean")
    string(REGEX MATCH "(.*) (.*) (.*)" script ${script})
    list(APPEND extra ${CMAKE_BINARY_DIR}/deb/python3-ovoid/${CMAKE_MATCH_1})
    file(CONFIGURE OUTPUT deb/python3-ovoid/${CMAKE_MATCH_1} @ONLY CONTENT [[#!/bin/sh
set -e
if [ "$1" = @CMAKE_MATCH_2@ ] && command -v @CMAKE_MATCH_3@ >/dev/null; then
  @CMAKE_MATCH_3@ -p python3-ovoid
fi
]])
  endforeach()
  file(CHMOD ${extra} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${extra})
endif()
include(CPack)
