// SPDX-License-Identifier: Apache-2.0
// Attraction of cells that are distant from a group of bodies. It is computed in single precision
// for worlds of either precision.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>

#include "interactions.hpp"
#include "octree.hpp"

namespace vesper::barnes_hut {

/// The sum of the attractions of distant cells on a group of bodies in double precision. The sum is
/// computed in single precision relative to the group's centre, which is twice as fast. The
/// rounding error is at most 1e-6 of a cell's attraction. This is far below the truncation error of
/// the cell's expansion.
class DistantCells {
 public:
  /// Creates the sum for the group `targets`, whose bounding box is `box`. The group must outlive
  /// this object, which adds results to the group's sums. `softening2` is the square of the
  /// softening [tree's length^2].
  DistantCells(const Interactions<float>& simd, Targets<double>& targets, const Box<double>& box,
               double softening2)
      : simd_(simd),
        targets_(targets),
        centre_((box.low + box.high) * 0.5),
        // At shorter distances, differences of positions in float are too inexact or underflow.
        nearest2_(std::max(box.FarthestSquare(centre_) / 16, 0x1p-40)),
        softening2_(std::max(static_cast<float>(softening2), kLeastSoftening2<float>)) {
    for (uint32_t lane = 0; lane < kGroup; ++lane) {
      single_.x[lane] = static_cast<float>(targets.x[lane] - centre_.x);
      single_.y[lane] = static_cast<float>(targets.y[lane] - centre_.y);
      single_.z[lane] = static_cast<float>(targets.z[lane] - centre_.z);
    }
    std::iota(list_.begin(), list_.end(), 0);
  }

  /// Returns true if a cell at this squared distance from the box is far enough for single
  /// precision.
  bool Takes(double distance2) const { return distance2 >= nearest2_; }

  void Add(const Multipole<double>& cell) {
    const auto single = [](double x) { return static_cast<float>(x); };
    const Vec3<double> from = cell.centre - centre_;
    cells_[count_++] = {{single(from.x), single(from.y), single(from.z)},
                        single(cell.mass),
                        single(cell.xx),
                        single(cell.xy),
                        single(cell.xz),
                        single(cell.yy),
                        single(cell.yz),
                        single(cell.zz),
                        single(cell.trace)};
    if (count_ == kList) Flush();
  }

  /// Adds the attraction of the cells since the last flush to the sums of the group. The sums are
  /// in double, so that rounding errors do not accumulate.
  void Flush() {
    std::fill_n(single_.ax, kGroup, 0.0f);
    std::fill_n(single_.ay, kGroup, 0.0f);
    std::fill_n(single_.az, kGroup, 0.0f);
    simd_.add_cells(single_, cells_.data(), list_.data(), count_, softening2_);
    for (uint32_t lane = 0; lane < kGroup; ++lane) {
      targets_.ax[lane] += double{single_.ax[lane]};
      targets_.ay[lane] += double{single_.ay[lane]};
      targets_.az[lane] += double{single_.az[lane]};
    }
    count_ = 0;
  }

 private:
  static constexpr uint32_t kList = 64;

  const Interactions<float>& simd_;
  Targets<double>& targets_;
  Vec3<double> centre_;
  double nearest2_;
  float softening2_;
  Targets<float> single_;
  std::array<Multipole<float>, kList> cells_;
  std::array<uint32_t, kList> list_;
  uint32_t count_ = 0;
};

}  // namespace vesper::barnes_hut
