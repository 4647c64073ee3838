# SPDX-License-Identifier: Apache-2.0
# OpenVDB comes with a module of its own, which asks for all of Boost; its headers need no more than TBB and Imath, which OpenEXR
# brings. Gives the target OpenVDB::openvdb.
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h)
find_library(OPENVDB_LIBRARY openvdb)
find_path(OPENVDB_TBB_INCLUDE_DIR tbb/global_control.h)
find_library(OPENVDB_TBB_LIBRARY tbb)
mark_as_advanced(OPENVDB_INCLUDE_DIR OPENVDB_LIBRARY OPENVDB_TBB_INCLUDE_DIR OPENVDB_TBB_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenVDB REQUIRED_VARS OPENVDB_LIBRARY OPENVDB_INCLUDE_DIR OPENVDB_TBB_LIBRARY OPENVDB_TBB_INCLUDE_DIR)
if(OpenVDB_FOUND AND NOT TARGET OpenVDB::openvdb)
  add_library(OpenVDB::openvdb UNKNOWN IMPORTED)
  set_target_properties(OpenVDB::openvdb PROPERTIES IMPORTED_LOCATION "${OPENVDB_LIBRARY}"
                        INTERFACE_INCLUDE_DIRECTORIES "${OPENVDB_INCLUDE_DIR};${OPENVDB_TBB_INCLUDE_DIR}"
                        INTERFACE_LINK_LIBRARIES "${OPENVDB_TBB_LIBRARY};Imath::Imath")
endif()
