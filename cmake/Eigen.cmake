# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
#
# Finds Eigen's headers: in EDGEFUSION_EIGEN_PREFIX; else, when the Python module is built, in the PyPI package
# cmeel-eigen beside the interpreter, which every build through pip has; else a system Eigen.
if(NOT EDGEFUSION_EIGEN_PREFIX AND EDGEFUSION_PYTHON)
  find_package(Python REQUIRED COMPONENTS Interpreter)
  execute_process(
    COMMAND "${Python_EXECUTABLE}" -c
      "import pathlib, sys; print(next((p for d in sys.path if (p := pathlib.Path(d) / 'cmeel.prefix').is_dir()), ''))"
    OUTPUT_VARIABLE EDGEFUSION_EIGEN_PREFIX OUTPUT_STRIP_TRAILING_WHITESPACE)
endif()

if(EDGEFUSION_EIGEN_PREFIX)
  # NO_DEFAULT_PATH: a system Eigen of another version must not win over the pinned one.
  find_path(EDGEFUSION_EIGEN_INCLUDE Eigen/Core PATHS "${EDGEFUSION_EIGEN_PREFIX}/include/eigen3" NO_DEFAULT_PATH)
else()
  find_path(EDGEFUSION_EIGEN_INCLUDE Eigen/Core PATH_SUFFIXES eigen3)
endif()
if(NOT EDGEFUSION_EIGEN_INCLUDE)
  message(FATAL_ERROR "Eigen not found: pip install cmeel-eigen and pass "
    "-DEDGEFUSION_EIGEN_PREFIX=<site-packages>/cmeel.prefix, or install libeigen3-dev")
endif()

add_library(edgefusion_eigen INTERFACE)
target_include_directories(edgefusion_eigen SYSTEM INTERFACE "${EDGEFUSION_EIGEN_INCLUDE}")
