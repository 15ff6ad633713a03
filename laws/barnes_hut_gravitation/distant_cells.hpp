// SPDX-License-Identifier: Apache-2.0
// Cells far away from a group of bodies, summed in single precision whatever the world's is.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>

#include "interactions.hpp"
#include "octree.hpp"

namespace vesper::barnes_hut {

/// Sums cells on a group in double: twice as fast in single precision, about the group's centre.
/// The rounding, 1e-6 of a cell's pull at most, is far below what its expansion leaves out.
class DistantCells {
 public:
  /// The group fills `box` and outlives this, which adds to its sums; softening2 [tree's length^2].
  DistantCells(const Interactions<float>& simd, Targets<double>& targets, const Box<double>& box,
               double softening2)
      : simd_(simd),
        targets_(targets),
        centre_((box.low + box.high) * 0.5),
        // Nearer, differences of rounded places would round too much, or leave the range of float.
        nearest2_(std::max(box.FarthestSquare(centre_) / 16, 0x1p-40)),
        softening2_(std::max(static_cast<float>(softening2), kLeastSoftening2<float>)) {
    for (uint32_t lane = 0; lane < kGroup; ++lane) {
      single_.x[lane] = static_cast<float>(targets.x[lane] - centre_.x);
      single_.y[lane] = static_cast<float>(targets.y[lane] - centre_.y);
      single_.z[lane] = static_cast<float>(targets.z[lane] - centre_.z);
    }
    std::iota(list_.begin(), list_.end(), 0);
  }

  /// Whether a cell is far enough, at this square of its distance from the box.
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

  /// Adds what the last cells pull to the sums of the group, in double: so many roundings do not
  /// add up.
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
