// SPDX-License-Identifier: Apache-2.0
// Pairs of boxes that overlap, by sorting along an axis.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "rigid/rotation.hpp"

namespace vesper::rigid {

/** An axis-parallel box in the world. */
struct Bounds {
  Vector low, high;
  bool movable = false;

  bool Overlaps(const Bounds& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y &&
           other.low.y <= high.y && low.z <= other.high.z && other.low.z <= high.z;
  }
};

/** The indices of two boxes that overlap, the smaller index first. */
struct Pair {
  uint32_t a, b;
  friend bool operator<(const Pair& x, const Pair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; }
};

/** Search for the pairs of overlapping boxes of which at least one box is movable. The pairs are in
 *  the order of their indices. */
class BroadPhase {
 public:
  const std::vector<Pair>& Find(const std::vector<Bounds>& boxes) {
    const int axis = WidestAxis(boxes);
    order_.resize(boxes.size());
    for (uint32_t i = 0; i < boxes.size(); ++i) {
      order_[i] = {Along(boxes[i].low, axis), Along(boxes[i].high, axis), i};
    }
    std::sort(order_.begin(), order_.end(), [](const Extent& x, const Extent& y) {
      return x.low != y.low ? x.low < y.low : x.box < y.box;
    });
    pairs_.clear();
    for (size_t i = 0; i < order_.size(); ++i) {
      const Bounds& box = boxes[order_[i].box];
      for (size_t j = i + 1; j < order_.size() && order_[j].low <= order_[i].high; ++j) {
        const Bounds& other = boxes[order_[j].box];
        if ((box.movable || other.movable) && box.Overlaps(other)) {
          pairs_.push_back(
              {std::min(order_[i].box, order_[j].box), std::max(order_[i].box, order_[j].box)});
        }
      }
    }
    std::sort(pairs_.begin(), pairs_.end());
    return pairs_;
  }

 private:
  struct Extent {
    double low, high;
    uint32_t box;
  };

  static double Along(const Vector& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

  /** Returns the axis along which the centres of the movable boxes have the largest variance.
   */
  static int WidestAxis(const std::vector<Bounds>& boxes) {
    Vector sum, squares;
    double count = 0;
    for (const Bounds& box : boxes) {
      if (!box.movable) continue;
      const Vector centre = (box.low + box.high) * 0.5;
      sum += centre;
      squares += Vector{centre.x * centre.x, centre.y * centre.y, centre.z * centre.z};
      count += 1;
    }
    if (count == 0) return 0;
    const Vector mean = sum * (1 / count);
    const Vector variance =
        squares * (1 / count) - Vector{mean.x * mean.x, mean.y * mean.y, mean.z * mean.z};
    if (variance.x >= variance.y && variance.x >= variance.z) return 0;
    return variance.y >= variance.z ? 1 : 2;
  }

  std::vector<Extent> order_;
  std::vector<Pair> pairs_;
};

}  // namespace vesper::rigid
