// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
//
// The only file that knows Python: checks shapes, names what is wrong, releases the GIL, hands over pointers.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "edgefusion/boxes.hpp"
#include "edgefusion/crops.hpp"
#include "edgefusion/dbscan.hpp"
#include "edgefusion/nearest_range.hpp"
#include "edgefusion/projection.hpp"

namespace py = pybind11;
using namespace edgefusion;

namespace {

template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

std::string shape_of(const py::array& array) {
  std::string text = "[";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i ? ", " : "") + std::to_string(array.shape(i));
  return text + "]";
}

// `columns` < 0: a vector of any length; `rows` < 0: any number of rows.
void expect_shape(const char* name, const py::array& array, py::ssize_t rows, py::ssize_t columns) {
  const bool vector = columns < 0;
  const bool fits = array.ndim() == (vector ? 1 : 2) && (rows < 0 || array.shape(0) == rows) &&
                    (vector || array.shape(1) == columns);
  if (fits) return;
  const std::string first = rows < 0 ? "n" : std::to_string(rows);
  throw std::invalid_argument(std::string(name) + ": expected shape [" + first +
                              (vector ? "" : ", " + std::to_string(columns)) + "], got " + shape_of(array));
}

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> matrix(const char* name, const Array<double>& array) {
  expect_shape(name, array, Rows, Columns);
  return Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>(array.data());
}

Eigen::Vector3d vector3(const char* name, const Array<double>& array) {
  expect_shape(name, array, 3, -1);
  return Eigen::Map<const Eigen::Vector3d>(array.data());
}

// A frame is never copied, so its type must be right already.
Image image_view(const py::array& image) {
  if (!py::isinstance<py::array_t<std::uint8_t>>(image))
    throw std::invalid_argument("image: expected uint8, got " + py::str(image.dtype()).cast<std::string>());
  if (image.ndim() != 3 || image.shape(2) != 3)
    throw std::invalid_argument("image: expected shape [height, width, 3], got " + shape_of(image));
  return {static_cast<const std::uint8_t*>(image.data()),
          static_cast<int>(image.shape(0)),
          static_cast<int>(image.shape(1)),
          image.strides(0),
          image.strides(1),
          image.strides(2)};
}

Fit fit_named(const std::string& name) {
  if (name == "squash") return Fit::kSquash;
  if (name == "letterbox") return Fit::kLetterbox;
  if (name == "square-context") return Fit::kSquareContext;
  if (name == "shorter-side+centre") return Fit::kShorterSideCentre;
  throw std::invalid_argument(
      "fit: expected 'squash', 'letterbox', 'square-context' or 'shorter-side+centre', got '" + name + "'");
}

Filter filter_named(const std::string& name) {
  if (name == "antialias") return Filter::kAntialias;
  if (name == "linear") return Filter::kLinear;
  throw std::invalid_argument("filter: expected 'antialias' or 'linear', got '" + name + "'");
}

py::array_t<std::int32_t> py_dbscan(const Array<double>& points, double eps, int min_points) {
  expect_shape("points", points, -1, 2);
  const auto n = static_cast<std::size_t>(points.shape(0));
  py::array_t<std::int32_t> labels(points.shape(0));
  const double* in = points.data();
  std::int32_t* out = labels.mutable_data();
  {
    py::gil_scoped_release release;
    dbscan(in, n, eps, min_points, out);
  }
  return labels;
}

py::tuple py_project(const Array<double>& points, const Camera& camera, const Array<double>& T_camera_laser) {
  expect_shape("points", points, -1, 3);
  const Eigen::Matrix4d T = matrix<4, 4>("T_camera_laser", T_camera_laser);
  const py::ssize_t n = points.shape(0);
  py::array_t<double> pixels({n, py::ssize_t{2}});
  py::array_t<std::uint8_t> marks(n);
  const double* in = points.data();
  double* out = pixels.mutable_data();
  std::uint8_t* out_marks = marks.mutable_data();
  {
    py::gil_scoped_release release;
    project(in, static_cast<std::size_t>(n), camera, T, out, out_marks);
  }
  return py::make_tuple(pixels, marks);
}

py::array_t<double> py_project_paper(const Array<double>& points, const Array<double>& K, int width,
                                     int height) {
  expect_shape("points", points, -1, 3);
  const Eigen::Matrix3d intrinsics = matrix<3, 3>("K", K);
  py::array_t<double> pixels({points.shape(0), py::ssize_t{2}});
  const double* in = points.data();
  double* out = pixels.mutable_data();
  const auto n = static_cast<std::size_t>(points.shape(0));
  {
    py::gil_scoped_release release;
    project_paper(in, n, intrinsics, width, height, out);
  }
  return pixels;
}

py::tuple py_candidate_boxes(const Array<double>& ranges_m, const Array<double>& angles_rad, double step_rad,
                             const Camera& camera, const Array<double>& T_camera_laser,
                             const Array<double>& to_ground, int width, int height,
                             const std::vector<double>& heights, bool heights_are_metric, double width_step,
                             bool on_ground, double min_visible) {
  expect_shape("ranges_m", ranges_m, -1, -1);
  expect_shape("angles_rad", angles_rad, ranges_m.shape(0), -1);
  const Eigen::Matrix4d T = matrix<4, 4>("T_camera_laser", T_camera_laser);
  const Eigen::Vector3d ground = vector3("to_ground", to_ground);
  const Beams beams{ranges_m.data(), angles_rad.data(), static_cast<std::size_t>(ranges_m.shape(0)),
                    step_rad};
  const BoxRule rule{heights, heights_are_metric, width_step, on_ground, min_visible};
  std::vector<Box> boxes(heights.size());
  std::vector<std::int32_t> indices(heights.size());
  std::size_t n = 0;
  {
    py::gil_scoped_release release;
    n = candidate_boxes(beams, camera, T, ground, width, height, rule, boxes.data(), indices.data());
  }
  py::array_t<std::int32_t> out({static_cast<py::ssize_t>(n), py::ssize_t{4}});
  py::array_t<std::int32_t> out_indices(static_cast<py::ssize_t>(n));
  std::memcpy(out.mutable_data(), boxes.data(), n * sizeof(Box));
  std::memcpy(out_indices.mutable_data(), indices.data(), n * sizeof(std::int32_t));
  return py::make_tuple(out, out_indices);
}

py::tuple py_nearest_range(const Array<double>& ranges_m, double sigma_m) {
  expect_shape("ranges_m", ranges_m, -1, -1);
  if (ranges_m.shape(0) == 0) throw std::invalid_argument("ranges_m: expected at least one range, got none");
  if (!(sigma_m > 0.0))
    throw std::invalid_argument("sigma_m: expected above 0, got " + std::to_string(sigma_m));
  const double* ranges = ranges_m.data();
  const auto n = static_cast<std::size_t>(ranges_m.shape(0));
  NearestRange nearest{};
  {
    py::gil_scoped_release release;
    nearest = nearest_range(ranges, n, sigma_m);
  }
  return py::make_tuple(nearest.range_m, nearest.sigma_m, nearest.index);
}

py::array_t<float> crop_buffer(const std::optional<py::array>& out, py::ssize_t n, py::ssize_t size) {
  const std::array<py::ssize_t, 4> shape{n, 3, size, size};
  if (!out) return py::array_t<float>(shape);
  const bool fits = py::isinstance<py::array_t<float, py::array::c_style>>(*out) && out->writeable() &&
                    out->ndim() == 4 && std::equal(shape.begin(), shape.end(), out->shape());
  if (!fits)
    throw std::invalid_argument("out: expected a writeable contiguous float32 array [" + std::to_string(n) +
                                ", 3, " + std::to_string(size) + ", " + std::to_string(size) + "], got " +
                                py::str(out->dtype()).cast<std::string>() + " " + shape_of(*out));
  return py::reinterpret_borrow<py::array_t<float>>(*out);
}

py::array_t<float> py_crops(const py::array& image, const Array<std::int32_t>& boxes, int size,
                            const std::array<float, 3>& mean, const std::array<float, 3>& std,
                            const std::string& fit, const std::string& filter, double crop_fraction,
                            const std::optional<py::array>& out) {
  const Image view = image_view(image);
  expect_shape("boxes", boxes, -1, 4);
  if (size < 1) throw std::invalid_argument("size: expected at least 1, got " + std::to_string(size));
  const CropOptions options{size, mean, std, fit_named(fit), filter_named(filter), crop_fraction};
  py::array_t<float> result = crop_buffer(out, boxes.shape(0), size);
  const auto* first = reinterpret_cast<const Box*>(boxes.data());
  float* pixels = result.mutable_data();
  {
    py::gil_scoped_release release;
    crops(view, first, static_cast<std::size_t>(boxes.shape(0)), options, pixels);
  }
  return result;
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "The C++ core of edgefusion. Types and documentation: _core.pyi.";

  m.attr("VISIBLE") = static_cast<int>(Mark::kVisible);
  m.attr("BEHIND") = static_cast<int>(Mark::kBehind);
  m.attr("BEYOND") = static_cast<int>(Mark::kBeyond);

  m.def("dbscan", &py_dbscan, py::arg("points"), py::arg("eps"), py::arg("min_points"));

  py::class_<Camera>(m, "Camera")
      .def(py::init([](const Array<double>& K, const std::vector<double>& distortion) {
             return Camera(matrix<3, 3>("K", K), distortion);
           }),
           py::arg("K"), py::arg("distortion") = std::vector<double>{})
      .def_property_readonly("max_radius", &Camera::max_radius);

  m.def("project", &py_project, py::arg("points"), py::arg("camera"), py::arg("T_camera_laser"));
  m.def(
      "project",
      [](const Array<double>& points, const Array<double>& K, const std::vector<double>& distortion,
         const Array<double>& T_camera_laser) {
        return py_project(points, Camera(matrix<3, 3>("K", K), distortion), T_camera_laser);
      },
      py::arg("points"), py::arg("K"), py::arg("distortion"), py::arg("T_camera_laser"));
  m.def("project_paper", &py_project_paper, py::arg("points"), py::arg("K"), py::arg("width"),
        py::arg("height"));

  m.def("candidate_boxes", &py_candidate_boxes, py::arg("ranges_m"), py::arg("angles_rad"),
        py::arg("step_rad"), py::arg("camera"), py::arg("T_camera_laser"), py::arg("to_ground"),
        py::arg("width"), py::arg("height"), py::arg("heights"), py::arg("heights_are_metric") = false,
        py::arg("width_step") = 0.0, py::arg("on_ground") = true, py::arg("min_visible") = 0.25);

  m.def("nearest_range", &py_nearest_range, py::arg("ranges_m"), py::arg("sigma_m"));

  m.def("crops", &py_crops, py::arg("image"), py::arg("boxes"), py::arg("size"), py::arg("mean"),
        py::arg("std"), py::arg("fit") = "squash", py::arg("filter") = "antialias",
        py::arg("crop_fraction") = 1.0, py::arg("out") = py::none());
}
