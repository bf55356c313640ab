// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
//
// Python's arguments as the core takes them: types and shapes checked, what is wrong named.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <Eigen/Core>
#include <string>

#include "edgefusion/refuse.hpp"

namespace edgefusion {

namespace py = pybind11;

template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

inline std::string shape_of(const py::array& array) {
  std::string text = "[";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i ? ", " : "") + std::to_string(array.shape(i));
  return text + "]";
}

inline std::string type_of(const py::array& array) {
  return py::str(array.dtype()).cast<std::string>();
}

// NumPy's array of anything that it takes for one.
inline py::array array_of(const char* name, const py::object& object) {
  py::array array = py::array::ensure(object);
  if (!array)
    refuse(name, ": expected an array of numbers, got ",
           py::type::of(object).attr("__name__").cast<std::string>());
  return array;
}

// The values as doubles; texts, complex numbers and truths are none.
inline Array<double> doubles(const char* name, const py::object& object) {
  const py::array array = array_of(name, object);
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    refuse(name, ": expected real numbers, got ", type_of(array));
  Array<double> values = Array<double>::ensure(array);
  if (!values) throw py::error_already_set();
  return values;
}

// `rows` < 0: any number of rows.
inline void expect_shape(const char* name, const py::array& array, py::ssize_t rows, py::ssize_t columns) {
  if (array.ndim() == 2 && (rows < 0 || array.shape(0) == rows) && array.shape(1) == columns) return;
  refuse(name, ": expected shape [", rows < 0 ? "n" : std::to_string(rows), ", ", columns, "], got ",
         shape_of(array));
}

inline Array<double> rows_of(const char* name, const py::object& object, py::ssize_t columns) {
  Array<double> values = doubles(name, object);
  expect_shape(name, values, -1, columns);
  return values;
}

// `n` < 0: any length.
inline Array<double> vector_of(const char* name, const py::object& object, py::ssize_t n = -1) {
  Array<double> values = doubles(name, object);
  if (values.ndim() != 1 || (n >= 0 && values.shape(0) != n))
    refuse(name, ": expected shape [", n < 0 ? "n" : std::to_string(n), "], got ", shape_of(values));
  return values;
}

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> matrix(const char* name, const py::object& object) {
  const Array<double> values = doubles(name, object);
  expect_shape(name, values, Rows, Columns);
  return Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>(values.data());
}

}  // namespace edgefusion
