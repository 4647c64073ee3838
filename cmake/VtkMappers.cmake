# SPDX-License-Identifier: Apache-2.0
# The volume mappers of bindings/vtk, by VTK's rules for modules: the library vtkOvoid and the Python module ovoid_vtk.vtkOvoid.
include(GNUInstallDirs)
vtk_module_scan(MODULE_FILES ${CMAKE_SOURCE_DIR}/bindings/vtk/vtk.module PROVIDES_MODULES mapper_modules
                REQUEST_MODULES Ovoid::VolumeMappers ENABLE_TESTS OFF)
vtk_module_build(MODULES ${mapper_modules} PACKAGE vtkOvoid
                 LIBRARY_DESTINATION ${CMAKE_INSTALL_LIBDIR}
                 INSTALL_HEADERS OFF TARGETS_COMPONENT vtk
                 ENABLE_WRAPPING ON USE_EXTERNAL OFF)
vtk_module_wrap_python(MODULES ${mapper_modules} PYTHON_PACKAGE ovoid_vtk TARGET Ovoid::PythonMappers COMPONENT vtk
                       INSTALL_HEADERS OFF)
