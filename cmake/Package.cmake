# SPDX-License-Identifier: Apache-2.0
# One .deb of everything that is installed (`make package`). What its programs and its library link is found by dpkg-shlibdeps;
# HDF5, which the library loads by name, is among it because ovoid-read links the same one.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ovoid)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "The Ovoid authors <nobody@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "volume rendering straight from the points of the data")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Draws scans, meshes and particles by splatting: a program, its window, and a C++ library.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})  # libovoid is in no package yet
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libvulkan1, libgl1")  # loaded by name, and done without
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libeigen3-dev, ffmpeg, zenity | kdialog")  # for programs with the library; for films; the window's dialog for files
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
# The mappers for VTK (component vtk) would make the package depend on VTK's Python: they are installed by hand.
set(CPACK_INSTALL_CMAKE_PROJECTS "${CMAKE_BINARY_DIR};ovoid;Unspecified;/")
include(CPack)
