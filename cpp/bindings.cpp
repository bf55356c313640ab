// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
//
// The bindings files are the only ones that know Python: they check types and shapes, name what is wrong, release the
// GIL, hand over pointers. Here are perception and the simulator; navigation is in bindings_navigation.cpp.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "bindings_arguments.hpp"
#include "bindings_navigation.hpp"
#include "edgefusion/box.hpp"
#include "edgefusion/boxes.hpp"
#include "edgefusion/camera.hpp"
#include "edgefusion/crops.hpp"
#include "edgefusion/dbscan.hpp"
#include "edgefusion/nearest_range.hpp"
#include "edgefusion/projection.hpp"
#include "edgefusion/raycast.hpp"
#include "edgefusion/refuse.hpp"
#include "edgefusion/split.hpp"

using namespace edgefusion;

namespace {

std::array<float, 3> triple(const char* name, const py::object& object) {
  const Array<double> values = vector_of(name, object, 3);
  const double* v = values.data();
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

// OpenCV hands coefficients out as a row or as a column.
std::vector<double> coefficients(const py::object& distortion) {
  const Array<double> values = doubles("distortion", distortion);
  const bool line =
      values.ndim() == 1 || (values.ndim() == 2 && (values.shape(0) == 1 || values.shape(1) == 1));
  if (!line) refuse("distortion: expected shape [n], [1, n] or [n, 1], got ", shape_of(values));
  return {values.data(), values.data() + values.size()};
}

Camera camera_of(const py::object& K, const py::object& distortion) {
  return Camera(matrix<3, 3>("K", K), coefficients(distortion));
}

// A frame is never copied, so its type must be right already.
Image image_view(const py::object& object) {
  if (!py::isinstance<py::array>(object))
    refuse("image: expected a uint8 array, got ", py::type::of(object).attr("__name__").cast<std::string>());
  const auto image = py::reinterpret_borrow<py::array>(object);
  if (!py::isinstance<py::array_t<std::uint8_t>>(image))
    refuse("image: expected uint8, got ", type_of(image));
  if (image.ndim() != 3 || image.shape(2) != 3)
    refuse("image: expected shape [height, width, 3], got ", shape_of(image));
  if (std::max(image.shape(0), image.shape(1)) > kMaxImageSide)
    refuse("image: expected at most ", kMaxImageSide, " pixels a side, got shape ", shape_of(image));
  return {static_cast<const std::uint8_t*>(image.data()),
          static_cast<int>(image.shape(0)),
          static_cast<int>(image.shape(1)),
          image.strides(0),
          image.strides(1),
          image.strides(2)};
}

// Wide: of 64 bits. What a Box cannot hold cannot be inside an image either.
template <typename Wide>
std::vector<Box> narrowed(const py::array& array, const Image& image) {
  const Array<Wide> wide = Array<Wide>::ensure(array);
  if (!wide) throw py::error_already_set();
  const auto fits = [](Wide value) {
    return value <= Wide{std::numeric_limits<std::int32_t>::max()} &&
           (std::is_unsigned<Wide>::value ||
            value >= static_cast<Wide>(std::numeric_limits<std::int32_t>::min()));
  };
  std::vector<Box> boxes(static_cast<std::size_t>(array.shape(0)));
  const Wide* row = wide.data();
  for (std::size_t i = 0; i < boxes.size(); ++i, row += 4) {
    if (!std::all_of(row, row + 4, fits))
      refuse("boxes[", i, "]: (", row[0], ", ", row[1], ", ", row[2], ", ", row[3],
             ") is not inside the image; image ", image.width, " x ", image.height);
    boxes[i] = {static_cast<std::int32_t>(row[0]), static_cast<std::int32_t>(row[1]),
                static_cast<std::int32_t>(row[2]), static_cast<std::int32_t>(row[3])};
  }
  return boxes;
}

// Never rounded or wrapped: only integers, of any width. No boxes have no type, [] is no boxes.
std::vector<Box> boxes_of(const py::object& object, const Image& image) {
  const py::array array = array_of("boxes", object);
  const char kind = array.dtype().kind();
  const bool integers = kind == 'i' || kind == 'u';
  if (!integers && !(kind == 'f' && array.size() == 0))
    refuse("boxes: expected integers, got ", type_of(array));
  if (array.ndim() == 1 && array.size() == 0) return {};
  expect_shape("boxes", array, -1, 4);
  return kind == 'u' ? narrowed<std::uint64_t>(array, image) : narrowed<std::int64_t>(array, image);
}

Fit fit_named(const std::string& name) {
  if (name == "squash") return Fit::kSquash;
  if (name == "letterbox") return Fit::kLetterbox;
  if (name == "square-context") return Fit::kSquareContext;
  if (name == "shorter-side+centre") return Fit::kShorterSideCentre;
  refuse("fit: expected 'squash', 'letterbox', 'square-context' or 'shorter-side+centre', got '", name, "'");
}

Filter filter_named(const std::string& name) {
  if (name == "antialias") return Filter::kAntialias;
  if (name == "linear") return Filter::kLinear;
  refuse("filter: expected 'antialias' or 'linear', got '", name, "'");
}

py::array_t<std::int32_t> py_dbscan(const py::object& cloud, double eps, int min_points) {
  const Array<double> points = rows_of("points", cloud, 2);
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

py::array_t<std::int32_t> py_split_clusters(const py::object& cloud, const py::object& clusters,
                                            double sigma_m, double eps, int min_points) {
  const Array<double> points = rows_of("points", cloud, 2);
  const py::array given = array_of("labels", clusters);
  if (given.dtype().kind() != 'i') refuse("labels: expected integers, got ", type_of(given));
  if (given.ndim() != 1 || given.shape(0) != points.shape(0))
    refuse("labels: expected shape [", points.shape(0), "], got ", shape_of(given));
  const Array<std::int64_t> wide = Array<std::int64_t>::ensure(given);
  const auto n = static_cast<std::size_t>(points.shape(0));
  py::array_t<std::int32_t> labels(points.shape(0));
  const double* in = points.data();
  std::int32_t* out = labels.mutable_data();
  std::transform(wide.data(), wide.data() + n, out, [](std::int64_t label) {
    return static_cast<std::int32_t>(
        std::clamp<std::int64_t>(label, -2, std::numeric_limits<std::int32_t>::max()));
  });
  {
    py::gil_scoped_release release;
    split_clusters(in, n, {sigma_m, eps, min_points}, out);
  }
  return labels;
}

py::tuple py_project(const py::object& cloud, const Camera& camera, const py::object& T_camera_laser) {
  const Array<double> points = rows_of("points", cloud, 3);
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

py::array_t<double> py_project_paper(const py::object& cloud, const py::object& K, int width, int height) {
  const Array<double> points = rows_of("points", cloud, 3);
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

py::tuple py_candidate_boxes(const py::object& ranges, const py::object& angles, double step_rad,
                             const Camera& camera, const py::object& T_camera_laser,
                             const py::object& to_ground, int width, int height, const py::object& heights,
                             bool heights_are_metric, double width_step, bool on_ground, double min_visible) {
  const Array<double> ranges_m = vector_of("ranges_m", ranges);
  const Array<double> angles_rad = vector_of("angles_rad", angles, ranges_m.shape(0));
  const Eigen::Matrix4d T = matrix<4, 4>("T_camera_laser", T_camera_laser);
  const Array<double> ground = vector_of("to_ground", to_ground, 3);
  const Array<double> all_heights = vector_of("heights", heights);
  const Beams beams{ranges_m.data(), angles_rad.data(), static_cast<std::size_t>(ranges_m.shape(0)),
                    step_rad};
  const Eigen::Vector3d down(ground.data());
  const BoxRule rule{{all_heights.data(), all_heights.data() + all_heights.size()},
                     heights_are_metric,
                     width_step,
                     on_ground,
                     min_visible};
  std::vector<Box> boxes(rule.heights.size());
  std::vector<std::int32_t> indices(rule.heights.size());
  std::size_t n = 0;
  {
    py::gil_scoped_release release;
    n = candidate_boxes(beams, camera, T, down, width, height, rule, boxes.data(), indices.data());
  }
  py::array_t<std::int32_t> out({static_cast<py::ssize_t>(n), py::ssize_t{4}});
  py::array_t<std::int32_t> out_indices(static_cast<py::ssize_t>(n));
  std::memcpy(out.mutable_data(), boxes.data(), n * sizeof(Box));
  std::memcpy(out_indices.mutable_data(), indices.data(), n * sizeof(std::int32_t));
  return py::make_tuple(out, out_indices);
}

py::tuple py_nearest_range(const py::object& neighbours, double sigma_m) {
  const Array<double> ranges_m = vector_of("ranges_m", neighbours);
  const double* ranges = ranges_m.data();
  const auto n = static_cast<std::size_t>(ranges_m.shape(0));
  NearestRange nearest{};
  {
    py::gil_scoped_release release;
    nearest = nearest_range(ranges, n, sigma_m);
  }
  return py::make_tuple(nearest.range_m, nearest.sigma_m, nearest.index);
}

py::tuple py_raycast(const py::object& walls, const py::object& pose, double angle_min,
                     double angle_increment, py::ssize_t n, double range_max) {
  const Array<double> segments = rows_of("segments", walls, 4);
  const Array<double> place = vector_of("pose", pose, 3);
  if (n < 0) refuse("n: expected at least 0, got ", n);
  const LaserPose laser{place.data()[0], place.data()[1], place.data()[2]};
  const Sweep sweep{angle_min, angle_increment, static_cast<std::size_t>(n), range_max};
  py::array_t<double> ranges(n);
  py::array_t<std::int32_t> hits(n);
  const double* in = segments.data();
  const auto m = static_cast<std::size_t>(segments.shape(0));
  double* out = ranges.mutable_data();
  std::int32_t* out_hits = hits.mutable_data();
  {
    py::gil_scoped_release release;
    raycast(in, m, laser, sweep, out, out_hits);
  }
  return py::make_tuple(ranges, hits);
}

py::array_t<float> crop_buffer(const std::optional<py::array>& out, py::ssize_t n, py::ssize_t size) {
  const std::array<py::ssize_t, 4> shape{n, 3, size, size};
  if (!out) return py::array_t<float>(shape);
  const bool fits = py::isinstance<py::array_t<float, py::array::c_style>>(*out) && out->writeable() &&
                    out->ndim() == 4 && std::equal(shape.begin(), shape.end(), out->shape());
  if (!fits)
    refuse("out: expected a writeable contiguous float32 array [", n, ", 3, ", size, ", ", size, "], got ",
           type_of(*out), " ", shape_of(*out));
  return py::reinterpret_borrow<py::array_t<float>>(*out);
}

py::array_t<float> py_crops(const py::object& image, const py::object& boxes, int size,
                            const py::object& mean, const py::object& std, const std::string& fit,
                            const std::string& filter, double crop_fraction,
                            const std::optional<py::array>& out) {
  const Image view = image_view(image);
  const std::vector<Box> rows = boxes_of(boxes, view);
  if (size < 1) refuse("size: expected at least 1, got ", size);
  const CropOptions options{size,           triple("mean", mean), triple("std", std),
                            fit_named(fit), filter_named(filter), crop_fraction};
  py::array_t<float> result = crop_buffer(out, static_cast<py::ssize_t>(rows.size()), size);
  float* pixels = result.mutable_data();
  {
    py::gil_scoped_release release;
    crops(view, rows.data(), rows.size(), options, pixels);
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
      .def(py::init(&camera_of), py::arg("K"), py::arg("distortion") = py::tuple())
      .def_property_readonly("max_radius", &Camera::max_radius);

  m.def("project", &py_project, py::arg("points"), py::arg("camera"), py::arg("T_camera_laser"));
  m.def(
      "project",
      [](const py::object& points, const py::object& K, const py::object& distortion,
         const py::object& T_camera_laser) {
        return py_project(points, camera_of(K, distortion), T_camera_laser);
      },
      py::arg("points"), py::arg("K"), py::arg("distortion"), py::arg("T_camera_laser"));
  m.def("project_paper", &py_project_paper, py::arg("points"), py::arg("K"), py::arg("width"),
        py::arg("height"));

  m.def("candidate_boxes", &py_candidate_boxes, py::arg("ranges_m"), py::arg("angles_rad"),
        py::arg("step_rad"), py::arg("camera"), py::arg("T_camera_laser"), py::arg("to_ground"),
        py::arg("width"), py::arg("height"), py::arg("heights"), py::arg("heights_are_metric") = false,
        py::arg("width_step") = 0.0, py::arg("on_ground") = true, py::arg("min_visible") = 0.25);

  m.def("nearest_range", &py_nearest_range, py::arg("ranges_m"), py::arg("sigma_m"));

  m.def("split_clusters", &py_split_clusters, py::arg("points"), py::arg("labels"), py::arg("sigma_m"),
        py::arg("eps"), py::arg("min_points"));

  m.def("raycast", &py_raycast, py::arg("segments"), py::arg("pose"), py::arg("angle_min"),
        py::arg("angle_increment"), py::arg("n"), py::arg("range_max"));

  m.def("crops", &py_crops, py::arg("image"), py::arg("boxes"), py::arg("size"), py::arg("mean"),
        py::arg("std"), py::arg("fit") = "squash", py::arg("filter") = "antialias",
        py::arg("crop_fraction") = 1.0, py::arg("out") = py::none());

  bind_navigation(m);
}
