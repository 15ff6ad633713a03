// SPDX-License-Identifier: Apache-2.0
// The broad phase: search for overlapping boxes.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "vesper/law.hpp"

namespace vesper::surface_contact {

template <class Real>
struct Box {
  static constexpr Real kEnd = std::numeric_limits<Real>::max();
  Vec3<Real> low{kEnd, kEnd, kEnd}, high{-kEnd, -kEnd, -kEnd};

  void Include(Vec3<Real> p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  Box Grown(Real by) const {
    const Vec3<Real> all{by, by, by};
    return {low - all, high + all};
  }
  bool Contains(Vec3<Real> p) const {
    return (p.x >= low.x) & (p.x <= high.x) & (p.y >= low.y) & (p.y <= high.y) & (p.z >= low.z) &
           (p.z <= high.z);
  }
  bool Overlaps(const Box& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y &&
           other.low.y <= high.y && low.z <= other.high.z && other.low.z <= high.z;
  }
  /// Returns true if the line from p to q intersects the box: no axis of the box, and no cross
  /// product of an axis and the line, separates them (C. Ericson, Real-Time Collision Detection,
  /// 2005, section 5.3.3).
  bool Meets(Vec3<Real> p, Vec3<Real> q) const {
    const Vec3<Real> line = q - p, middle = p + q - low - high, size = high - low;
    const Vec3<Real> reach{std::abs(line.x), std::abs(line.y), std::abs(line.z)};
    if (std::abs(middle.x) > size.x + reach.x || std::abs(middle.y) > size.y + reach.y ||
        std::abs(middle.z) > size.z + reach.z) {
      return false;
    }
    const Vec3<Real> across = Cross(middle, line);
    return std::abs(across.x) <= size.y * reach.z + size.z * reach.y &&
           std::abs(across.y) <= size.x * reach.z + size.z * reach.x &&
           std::abs(across.z) <= size.x * reach.y + size.y * reach.x;
  }
  Real Size() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }
  Vec3<Real> Centre() const { return low * Real(0.5) + high * Real(0.5); }
};

/** A uniform grid with cells in a hash table (M. Teschner et al., Optimized Spatial Hashing for
 *  Collision Detection of Deformable Objects, 2003). A box is in the cell of its centre. Cells
 *  are twice the size of the median box. Larger boxes are not in cells, but in a list that every
 *  query scans. */
template <class Real>
class PatchGrid {
 public:
  /// Allocates space for this number of boxes.
  void Reserve(size_t members) {
    sizes_.reserve(members);
    large_.reserve(members);
    small_.reserve(members);
    entries_.resize(members);
    start_.resize(std::bit_ceil(2 * members + 1) + 1);
  }

  /// Builds the grid. `members` are indices into `boxes`, which must be finite.
  void Build(std::span<const Box<Real>> boxes, std::span<const uint32_t> members) {
    large_.clear();
    small_.clear();
    std::ranges::fill(start_, 0);
    if (members.empty()) return;
    const Real cell = ChooseCell(boxes, members);
    per_cell_ = 1 / cell;
    small_size_ = 0;
    for (const uint32_t member : members) {
      const Box<Real>& box = boxes[member];
      const Real size = box.Size();
      if (size > cell) {
        large_.push_back({box, {}, member});
      } else {
        small_size_ = std::max(small_size_, size);
        small_.push_back({box, CellOf(box.Centre()), member});
        ++start_[Hash(small_.back().cell) + 1];
      }
    }
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    for (const Entry& entry : small_) entries_[start_[Hash(entry.cell)]++] = entry;
    // Filling the buckets has moved each bucket's start to its end. The shift restores the starts.
    std::shift_right(start_.begin(), start_.end(), 1);
    start_[0] = 0;
  }

  /// Calls visit(member) for each member whose box overlaps `box`.
  template <class Visit>
  void Query(const Box<Real>& box, Visit&& visit) const {
    const auto look = [&](const Entry& entry) {
      if (entry.box.Overlaps(box)) visit(entry.member);
    };
    std::ranges::for_each(large_, look);
    if (small_.empty()) return;
    const Box<Real> centres = box.Grown(small_size_ / 2);
    const Cell low = CellOf(centres.low), high = CellOf(centres.high);
    const double cells =
        (double(high.x) - low.x + 1) * (double(high.y) - low.y + 1) * (double(high.z) - low.z + 1);
    if (cells > static_cast<double>(small_.size())) {
      std::ranges::for_each(small_, look);
      return;
    }
    for (int32_t z = low.z; z <= high.z; ++z) {
      for (int32_t y = low.y; y <= high.y; ++y) {
        for (int32_t x = low.x; x <= high.x; ++x) LookIntoCell({x, y, z}, look);
      }
    }
  }

 private:
  struct Cell {
    int32_t x, y, z;
    bool operator==(const Cell&) const = default;
  };
  struct Entry {
    Box<Real> box;
    Cell cell;
    uint32_t member;
  };

  template <class Look>
  void LookIntoCell(Cell cell, Look&& look) const {
    const uint32_t bucket = Hash(cell);
    for (uint32_t i = start_[bucket]; i < start_[bucket + 1]; ++i) {
      if (entries_[i].cell == cell) look(entries_[i]);
    }
  }

  Real ChooseCell(std::span<const Box<Real>> boxes, std::span<const uint32_t> members) {
    sizes_.clear();
    for (const uint32_t member : members) sizes_.push_back(boxes[member].Size());
    const auto middle = sizes_.begin() + static_cast<ptrdiff_t>(sizes_.size() / 2);
    std::nth_element(sizes_.begin(), middle, sizes_.end());
    return 2 * *middle;
  }

  Cell CellOf(Vec3<Real> p) const {
    const auto coordinate = [&](Real value) {
      constexpr Real kFar = 1 << 30;
      const Real cells = std::clamp(value * per_cell_, -kFar, kFar);
      const auto towards_zero = static_cast<int32_t>(cells);
      return towards_zero - (static_cast<Real>(towards_zero) > cells ? 1 : 0);
    };
    return {coordinate(p.x), coordinate(p.y), coordinate(p.z)};
  }

  uint32_t Hash(Cell cell) const {
    const uint32_t mixed = static_cast<uint32_t>(cell.x) * 73856093u ^
                           static_cast<uint32_t>(cell.y) * 19349663u ^
                           static_cast<uint32_t>(cell.z) * 83492791u;
    return mixed & static_cast<uint32_t>(start_.size() - 2);
  }

  Real per_cell_ = 1;    // 1 / side of a cell [1/m]
  Real small_size_ = 0;  // size up to which boxes are in cells [m]
  std::vector<Real> sizes_;
  std::vector<Entry> large_;
  std::vector<Entry> small_;     // boxes in cells, in the order of members
  std::vector<Entry> entries_;   // the same boxes, in the order of buckets
  std::vector<uint32_t> start_;  // (buckets + 1), start of each bucket
};

}  // namespace vesper::surface_contact
