# SPDX-License-Identifier: Apache-2.0
# pybind11 for the distribution's Python, which has numpy and may not be the first that is found.
find_program(OVOID_PYTHON_PROGRAM NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH DOC "The Python that the package is for")
set(pybind11_FOUND OFF)
if(OVOID_PYTHON_PROGRAM AND BUILD_SHARED_LIBS)
  set(Python_EXECUTABLE ${OVOID_PYTHON_PROGRAM})
  find_package(Python QUIET COMPONENTS Interpreter Development.Module)
  if(Python_FOUND)
    find_package(pybind11 QUIET CONFIG)
  endif()
endif()
