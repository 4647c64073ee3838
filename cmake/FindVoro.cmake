# SPDX-License-Identifier: Apache-2.0
# Voro++ comes without a CMake package. Gives the target Voro::voro.
find_path(VORO_INCLUDE_DIR voro++/voro++.hh)
find_library(VORO_LIBRARY voro++)
mark_as_advanced(VORO_INCLUDE_DIR VORO_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Voro REQUIRED_VARS VORO_LIBRARY VORO_INCLUDE_DIR)
if(Voro_FOUND AND NOT TARGET Voro::voro)
  add_library(Voro::voro UNKNOWN IMPORTED)
  set_target_properties(Voro::voro PROPERTIES IMPORTED_LOCATION "${VORO_LIBRARY}"
                        INTERFACE_INCLUDE_DIRECTORIES "${VORO_INCLUDE_DIR}")
endif()
