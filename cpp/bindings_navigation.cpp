// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#include "bindings_navigation.hpp"

#include <cstddef>
#include <cstring>
#include <optional>
#include <vector>

#include "bindings_arguments.hpp"
#include "edgefusion/footprint.hpp"
#include "edgefusion/guard.hpp"
#include "edgefusion/manoeuvre.hpp"
#include "edgefusion/navigation_function.hpp"
#include "edgefusion/obstacle_map.hpp"

namespace edgefusion {
namespace {

py::array_t<double> points_array(const std::vector<double>& points) {
  py::array_t<double> array({static_cast<py::ssize_t>(points.size() / 2), py::ssize_t{2}});
  std::memcpy(array.mutable_data(), points.data(), points.size() * sizeof(double));
  return array;
}

Pose pose_of(const py::object& pose) {
  const Array<double> values = vector_of("pose", pose, 3);
  expect_finite("pose", values.data(), 3);
  return {values.data()[0], values.data()[1], values.data()[2]};
}

Footprint footprint_of(const py::object& corners) {
  const Array<double> rows = rows_of("footprint", corners, 2);
  return Footprint(rows.data(), static_cast<std::size_t>(rows.shape(0)));
}

// They wrap after 49 days.
std::uint32_t milliseconds(std::int64_t ns) {
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(ns) / 1'000'000U);
}

void insert(ObstacleMap& map, const py::object& poses, const py::object& ranges, double angle_min,
            double angle_increment, double range_min, double range_max, std::int64_t stamp_ns) {
  const Array<double> rows = rows_of("poses", poses, 3);
  const Array<float> values = Array<float>::ensure(array_of("ranges_m", ranges));
  if (!values || values.ndim() != 1 || values.shape(0) != rows.shape(0))
    refuse("ranges_m: expected shape [", rows.shape(0), "], got ", shape_of(array_of("ranges_m", ranges)));
  map.insert({rows.data(), values.data(), static_cast<std::size_t>(values.shape(0)), angle_min,
              angle_increment, range_min, range_max},
             milliseconds(stamp_ns));
}

py::array_t<double> ages(const ObstacleMap& map, const py::object& points, std::int64_t stamp_ns) {
  const Array<double> rows = rows_of("points", points, 2);
  py::array_t<double> result(rows.shape(0));
  for (py::ssize_t i = 0; i < rows.shape(0); ++i)
    result.mutable_data()[i] = map.age(rows.data()[2 * i], rows.data()[2 * i + 1], milliseconds(stamp_ns));
  return result;
}

py::array_t<double> all_points(const ObstacleMap& map) {
  std::vector<double> points;
  const MapWindow& w = map.window();
  for (std::size_t i = 0; i < w.size(); ++i) {
    if (map.at(i).evidence == 0) continue;
    points.push_back(static_cast<double>(map.at(i).x));
    points.push_back(static_cast<double>(map.at(i).y));
  }
  return points_array(points);
}

const char* outcome_name(const NavigationFunction& function) {
  switch (function.potential().outcome) {
    case Outcome::kEnclosed:
      return "enclosed";
    case Outcome::kOccupied:
      return "occupied";
    default:
      return "reached";
  }
}

void look(Guard& guard, const ObstacleMap& map, double x, double y, double reach, const py::object& moving) {
  const Array<double> rows = rows_of("moving", moving, 4);
  guard.look(map, x, y, reach, rows.data(), static_cast<std::size_t>(rows.shape(0)));
}

Motion motion_of(const py::object& motion) {
  const Array<double> values = vector_of("motion", motion, 5);
  const double* m = values.data();
  expect_finite("motion", m, 5);
  return {{m[0], m[1], m[2]}, m[3], m[4]};
}

// Either a value of the function or a pose is the target.
void begin(Manoeuvre& manoeuvre, const ObstacleMap& map, const NavigationFunction& function,
           const py::object& start, double margin, const py::object& others,
           const std::optional<double>& value, const py::object& pose, double position_tolerance,
           double heading_tolerance) {
  const Array<double> rows = rows_of("others", others, 2);
  if (value.has_value() == !pose.is_none()) refuse("value, pose: expected one of them, got both or none");
  const ManoeuvreTarget target{value.value_or(0.0), !value, value ? Pose{0.0, 0.0, 0.0} : pose_of(pose),
                               position_tolerance, heading_tolerance};
  manoeuvre.begin(map, function.potential(), pose_of(start), margin, target, rows.data(),
                  static_cast<std::size_t>(rows.shape(0)));
}

py::list legs_of(const Manoeuvre& manoeuvre) {
  py::list legs;
  for (const Leg& leg : manoeuvre.legs())
    legs.append(py::make_tuple(leg.way, leg.turn, py::make_tuple(leg.end.x, leg.end.y, leg.end.theta)));
  return legs;
}

py::tuple tuple_of(const Motion& m) {
  return py::make_tuple(m.pose.x, m.pose.y, m.pose.theta, m.v, m.w);
}

}  // namespace

void bind_navigation(py::module_& m) {
  py::class_<Footprint>(m, "Footprint")
      .def(py::init(&footprint_of), py::arg("corners_m"))
      .def_property_readonly("inscribed_m", &Footprint::inscribed)
      .def_property_readonly("circumscribed_m", &Footprint::circumscribed)
      .def("gap", &Footprint::gap, py::arg("x_m"), py::arg("y_m"));

  py::class_<ObstacleMap>(m, "ObstacleMap")
      .def(py::init<double>(), py::arg("cell_m"))
      .def("cover", &ObstacleMap::cover, py::arg("x_m"), py::arg("y_m"), py::arg("target_x_m"),
           py::arg("target_y_m"))
      .def("insert", &insert, py::arg("poses"), py::arg("ranges_m"), py::arg("angle_min"),
           py::arg("angle_increment"), py::arg("range_min_m"), py::arg("range_max_m"), py::arg("stamp_ns"))
      .def("ages", &ages, py::arg("points_m"), py::arg("stamp_ns"))
      .def(
          "stand",
          [](ObstacleMap& map, const Footprint& footprint, const py::object& pose, double inset) {
            map.stand(footprint, pose_of(pose), inset);
          },
          py::arg("footprint"), py::arg("pose"), py::arg("inset_m"))
      .def("avoid", &ObstacleMap::avoid, py::arg("x_m"), py::arg("y_m"), py::arg("radius_m"))
      .def("points", &all_points)
      .def("seen", &ObstacleMap::seen, py::arg("x_m"), py::arg("y_m"))
      .def_property_readonly("window", [](const ObstacleMap& map) {
        const MapWindow& w = map.window();
        return py::make_tuple(w.column, w.row, w.columns, w.rows);
      });

  py::class_<NavigationFunction>(m, "NavigationFunction")
      .def(py::init([](double blocked, double comfort, double weight) {
             return NavigationFunction({blocked, comfort, weight});
           }),
           py::arg("blocked_m"), py::arg("comfort_m"), py::arg("weight"))
      .def("begin", &NavigationFunction::begin, py::arg("map"), py::arg("goal_x_m"), py::arg("goal_y_m"),
           py::arg("tolerance_m"), py::arg("x_m"), py::arg("y_m"), py::call_guard<py::gil_scoped_release>())
      .def("advance", &NavigationFunction::advance, py::arg("map"), py::arg("cells"),
           py::call_guard<py::gil_scoped_release>())
      .def_property_readonly("running", &NavigationFunction::running)
      .def_property_readonly("outcome", &outcome_name)
      .def(
          "value",
          [](const NavigationFunction& function, double x, double y) {
            return function.potential().value(x, y);
          },
          py::arg("x_m"), py::arg("y_m"))
      .def(
          "descent",
          [](const NavigationFunction& function, double x, double y) {
            return function.potential().descent(x, y);
          },
          py::arg("x_m"), py::arg("y_m"))
      .def(
          "way",
          [](const NavigationFunction& function, double x, double y, double length, double reach) {
            std::vector<double> points;
            function.potential().way(x, y, length, reach, points);
            return points_array(points);
          },
          py::arg("x_m"), py::arg("y_m"), py::arg("length_m"), py::arg("reach_m"));

  py::class_<Guard>(m, "Guard")
      .def(py::init([](const Footprint& footprint, double acceleration, double yaw_acceleration) {
             return Guard(footprint, {acceleration, yaw_acceleration});
           }),
           py::arg("footprint"), py::arg("acceleration_mps2"), py::arg("yaw_acceleration_radps2"))
      .def("look", &look, py::arg("map"), py::arg("x_m"), py::arg("y_m"), py::arg("reach_m"),
           py::arg("moving"))
      .def(
          "gap", [](const Guard& guard, const py::object& pose) { return guard.gap(pose_of(pose)); },
          py::arg("pose"))
      .def(
          "free",
          [](const Guard& guard, const ObstacleMap& map, const py::object& motion, double v, double w,
             double hold, double margin,
             double linger) { return guard.free(map, motion_of(motion), {v, w}, hold, margin, linger); },
          py::arg("map"), py::arg("motion"), py::arg("v_mps"), py::arg("w_radps"), py::arg("hold_s"),
          py::arg("margin_m"), py::arg("linger_s") = 0.0)
      .def_property_readonly("stirs", &Guard::stirs)
      .def(
          "fits",
          [](const Guard& guard, const py::object& pose, double margin) {
            return guard.fits(pose_of(pose), margin);
          },
          py::arg("pose"), py::arg("margin_m"));

  py::class_<Manoeuvre>(m, "Manoeuvre")
      .def(py::init<const Footprint&>(), py::arg("footprint"))
      .def("begin", &begin, py::arg("map"), py::arg("function"), py::arg("start"), py::arg("margin_m"),
           py::arg("others"), py::arg("value_m") = py::none(), py::arg("pose") = py::none(),
           py::arg("position_tolerance_m") = 0.05, py::arg("heading_tolerance") = 0.05)
      .def(
          "advance",
          [](Manoeuvre& manoeuvre, const ObstacleMap& map, const NavigationFunction& function,
             std::size_t poses) { return manoeuvre.advance(map, function.potential(), poses); },
          py::arg("map"), py::arg("function"), py::arg("poses"), py::call_guard<py::gil_scoped_release>())
      .def_property_readonly("running", &Manoeuvre::running)
      .def_property_readonly("legs", &legs_of);

  m.def(
      "followed",
      [](const py::object& motion, double v, double w, double acceleration, double yaw_acceleration,
         double duration) {
        return tuple_of(followed(motion_of(motion), {v, w}, {acceleration, yaw_acceleration}, duration));
      },
      py::arg("motion"), py::arg("v_mps"), py::arg("w_radps"), py::arg("acceleration_mps2"),
      py::arg("yaw_acceleration_radps2"), py::arg("duration_s"));
}

}  // namespace edgefusion
