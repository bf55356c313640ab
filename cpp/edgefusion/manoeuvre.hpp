// SPDX-License-Identifier: Apache-2.0
// Copyright the edgefusion authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "edgefusion/footprint.hpp"
#include "edgefusion/obstacle_map.hpp"
#include "edgefusion/potential.hpp"

namespace edgefusion {

/// A stretch along one arc, or a turn on the spot: then the way is 0.
struct Leg {
  double way, turn;  ///< [m] forward, below 0 back; [rad] to the left
  Pose end;
};

/// Where a manoeuvre is to lead to.
struct ManoeuvreTarget {
  double value;      ///< of the navigation function, at most, and looking down it; or else ...
  bool pose_counts;  ///< ... to the pose itself
  Pose pose;
  double position_tolerance, heading_tolerance;
};

/// Finds a way out where the base does not simply fit through: over positions and headings, with the hull as it is
/// (hybrid A*, Dolgov et al. 2010). Arcs forward, turns on the spot, and arcs back over ground that was seen.
///
/// It is searched in portions: begin, then advance until it is done.
class Manoeuvre {
 public:
  explicit Manoeuvre(const Footprint& footprint) : footprint_(footprint) {}

  /// From a pose, `margin` kept to what the map and `others` (k x 2) hold now.
  ///
  /// Throws std::invalid_argument for numbers that are not finite and a margin outside of 0 to 1 m.
  void begin(const ObstacleMap& map, const Potential& potential, const Pose& start, double margin,
             const ManoeuvreTarget& target, const double* others, std::size_t k);

  /// Looks at so many more poses; true when the search is over.
  bool advance(const ObstacleMap& map, const Potential& potential, std::size_t poses);

  bool running() const { return running_; }

  /// What was found, empty where nothing was.
  const std::vector<Leg>& legs() const { return legs_; }

 private:
  struct Step {
    double way, turn, cost;
  };
  struct Node {
    Pose pose;
    double cost;
    std::int32_t parent;
    std::int8_t step;
  };
  struct Entry {
    double estimate;
    std::int32_t node;
    bool operator<(const Entry& o) const {
      return estimate > o.estimate || (estimate == o.estimate && node > o.node);
    }
  };

  static const std::vector<Step>& steps();
  void fill_bins(const std::vector<double>& points);
  std::int32_t bin_of(double offset) const;
  double gap(const Pose& pose) const;
  double room_along(const ObstacleMap& map, const Pose& from, const Step& step, Pose& to) const;
  bool reached(const Potential& potential, const Pose& pose) const;
  double left(const Potential& potential, const Pose& pose) const;
  std::size_t place(const Pose& pose) const;
  void push(const Potential& potential, const Node& node);
  void finish(std::int32_t node);

  Footprint footprint_;
  Pose start_{0.0, 0.0, 0.0};
  double margin_ = 0.0, reach_ = 0.0;  // points beyond reach of the base's middle are of no account
  std::int32_t bins_ = 0;              // along either side of the square that is searched
  ManoeuvreTarget target_{0.0, false, {0.0, 0.0, 0.0}, 0.0, 0.0};
  bool running_ = false;
  std::vector<Node> nodes_;
  std::vector<Entry> open_;
  std::vector<std::uint8_t> closed_;
  std::vector<std::vector<double>> points_;  // of each bin
  std::vector<Leg> legs_;
};

}  // namespace edgefusion
