// SPDX-License-Identifier: Apache-2.0
// Pairs of boxes that overlap, by sorting along an axis.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "lanes.hpp"
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
    Order(boxes, axis);
    u_.Read(order_, boxes, (axis + 1) % 3);
    v_.Read(order_, boxes, (axis + 2) % 3);
    pairs_.clear();
    for (size_t i = 0; i < order_.size(); ++i) {
      const auto last =
          std::partition_point(order_.begin() + ptrdiff_t(i) + 1, order_.end(),
                               [&](const Extent& other) { return other.low <= order_[i].high; });
      Sweep(boxes, i, size_t(last - order_.begin()));
    }
    SortPairs(boxes.size());
    return pairs_;
  }
  /** Returns the pairs of the last call of Find. */
  const std::vector<Pair>& pairs() const { return pairs_; }

 private:
  using Numbers = Lanes<float>;

  struct Extent {
    double low, high;
    uint32_t box;

    friend bool operator<(const Extent& x, const Extent& y) {
      return x.low != y.low ? x.low < y.low : x.box < y.box;
    }
  };

  /** The extents of all boxes along an axis, in the order of the sweep, in single precision. Each
   *  extent contains the exact extent. The extents of further boxes at the end are empty. */
  class Intervals {
   public:
    void Read(const std::vector<Extent>& order, const std::vector<Bounds>& boxes, int axis) {
      low_.assign(order.size() + Numbers::kCount, HUGE_VALF);
      high_.assign(order.size() + Numbers::kCount, -HUGE_VALF);
      for (size_t i = 0; i < order.size(); ++i) {
        const double low = Component(boxes[order[i].box].low, axis);
        const double high = Component(boxes[order[i].box].high, axis);
        low_[i] = static_cast<float>(low - Error(low));
        high_[i] = static_cast<float>(high + Error(high));
      }
    }
    /** Returns which of the intervals from `first` on may overlap the interval `i`. */
    Numbers::Mask Overlap(size_t i, size_t first) const {
      return (Numbers::Load(&low_[first]) <= Numbers(high_[i])) &
             (Numbers(low_[i]) <= Numbers::Load(&high_[first]));
    }

   private:
    /** Returns more than the rounding error of a number in single precision. */
    static double Error(double x) { return std::abs(x) * 1.2e-7 + 1e-37; }

    std::vector<float> low_, high_;
  };

  static double Component(const Vector& v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
  }

  /** Sorts the extents of all boxes along an axis. Begins with the order of the last call, because
   *  boxes move only a little in a step. */
  void Order(const std::vector<Bounds>& boxes, int axis) {
    if (order_.size() != boxes.size()) {
      order_.resize(boxes.size());
      for (uint32_t i = 0; i < boxes.size(); ++i) order_[i].box = i;
    }
    for (Extent& extent : order_) {
      extent.low = Component(boxes[extent.box].low, axis);
      extent.high = Component(boxes[extent.box].high, axis);
    }
    constexpr size_t kMoves = 4;  // moves per box above which another method of sorting is faster
    size_t moves = 0;
    for (size_t i = 1; i < order_.size(); ++i) {
      const Extent extent = order_[i];
      size_t to = i;
      for (; to > 0 && extent < order_[to - 1]; --to) order_[to] = order_[to - 1];
      order_[to] = extent;
      moves += i - to;
      if (moves > kMoves * order_.size()) return std::sort(order_.begin(), order_.end());
    }
  }

  /** Adds the pairs of the box at place i in the order and the boxes at the places i + 1 to
   *  last - 1. */
  void Sweep(const std::vector<Bounds>& boxes, size_t i, size_t last) {
    const uint32_t one = order_[i].box;
    for (size_t first = i + 1; first < last; first += size_t(Numbers::kCount)) {
      if (!Any(u_.Overlap(i, first) & v_.Overlap(i, first))) continue;
      for (size_t j = first; j < std::min(last, first + size_t(Numbers::kCount)); ++j) {
        const uint32_t other = order_[j].box;
        if ((boxes[one].movable || boxes[other].movable) && boxes[one].Overlaps(boxes[other])) {
          pairs_.push_back({std::min(one, other), std::max(one, other)});
        }
      }
    }
  }

  /** Sorts the pairs by their first boxes, then those of each first box by the second box. */
  void SortPairs(size_t boxes) {
    start_.assign(boxes + 1, 0);
    for (const Pair& pair : pairs_) ++start_[pair.a + 1];
    for (size_t i = 0; i < boxes; ++i) start_[i + 1] += start_[i];
    next_.assign(start_.begin(), start_.end());
    sorted_.resize(pairs_.size());
    for (const Pair& pair : pairs_) sorted_[next_[pair.a]++] = pair;
    for (size_t i = 0; i < boxes; ++i) {
      std::sort(sorted_.begin() + start_[i], sorted_.begin() + start_[i + 1]);
    }
    std::swap(pairs_, sorted_);
  }

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
  Intervals u_, v_;  // along the two other axes
  std::vector<Pair> pairs_, sorted_;
  std::vector<uint32_t> start_, next_;  // (boxes + 1) first pair of each box in sorted_
};

}  // namespace vesper::rigid
