# SPDX-License-Identifier: Apache-2.0
# The volume mappers of bindings/vtk, by VTK's rules for modules: the library vtkOvoid and the Python module ovoid_vtk.vtkOvoid.
include(GNUInstallDirs)
vtk_module_scan(MODULE_FILES ${CMAKE_SOURCE_DIR}/bindings/vtk/vtk.module PROVIDES_MODULES mapper_modules
                REQUEST_MODULES Ovoid::VolumeMappers ENABLE_TESTS OFF)
vtk_module_build(MODULES ${mapper_modules} PACKAGE vtkOvoid LIBRARY_DESTINATION ${CMAKE_INSTALL_LIBDIR} INSTALL_HEADERS OFF
                 TARGETS_COMPONENT vtk ENABLE_WRAPPING ON USE_EXTERNAL OFF)
vtk_module_python_default_destination(python_destination)
vtk_module_wrap_python(MODULES ${mapper_modules} PYTHON_PACKAGE ovoid_vtk MODULE_DESTINATION ${python_destination}
                       TARGET Ovoid::PythonMappers COMPONENT vtk INSTALL_HEADERS OFF)
# From ${python_destination}/ovoid_vtk to where the library is installed.
cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_LIBDIR BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX}/${python_destination}/ovoid_vtk
           OUTPUT_VARIABLE to_library)
# And where it is built.
cmake_path(RELATIVE_PATH CMAKE_LIBRARY_OUTPUT_DIRECTORY BASE_DIRECTORY ${CMAKE_BINARY_DIR}/${python_destination}/ovoid_vtk
           OUTPUT_VARIABLE to_built_library)
set_target_properties(vtkOvoidPython PROPERTIES INSTALL_RPATH "$ORIGIN/${to_built_library};$ORIGIN/${to_library}" UNITY_BUILD OFF)
set(mapper_python_path ${CMAKE_BINARY_DIR}/${python_destination})  # for the tests, beside what is built
