// SPDX-License-Identifier: Apache-2.0
// The tree of cells over all bodies, rebuilt from their positions.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "hilbert.hpp"
#include "interactions.hpp"
#include "radix_sort.hpp"

namespace vesper::barnes_hut {

/// An axis-parallel box.
template <class Real>
struct Box {
  Vec3<Real> low{kMost, kMost, kMost}, high{-kMost, -kMost, -kMost};

  void Include(Vec3<Real> p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void Include(const Box& other) {
    Include(other.low);
    Include(other.high);
  }
  /// Returns the squared distance from a point to the nearest point of the box.
  Real NearestSquare(Vec3<Real> p) const {
    const auto gap = [](Real low, Real high, Real at) {
      return std::max(std::max(low - at, at - high), Real{0});
    };
    const Vec3<Real> d{gap(low.x, high.x, p.x), gap(low.y, high.y, p.y), gap(low.z, high.z, p.z)};
    return Dot(d, d);
  }
  /// Returns the squared distance from a point to the farthest corner.
  Real FarthestSquare(Vec3<Real> p) const {
    const Vec3<Real> d{std::max(p.x - low.x, high.x - p.x), std::max(p.y - low.y, high.y - p.y),
                       std::max(p.z - low.z, high.z - p.z)};
    return Dot(d, d);
  }

 private:
  static constexpr Real kMost = std::numeric_limits<Real>::max();
};

/// Factors between the units of the world and those of the tree; they are powers of two. In the
/// tree's units, the largest coordinate and the heaviest body are near fixed numbers. Therefore
/// powers of distances stay within the range of Real for any units of the world.
struct Scales {
  double length = 1, mass = 1;
};

/// The data of a cell that a traversal reads.
template <class Real>
struct Cell {
  Vec3<Real> centre;      // centre of mass
  Real reach2;            // squared radius of a ball about `centre` that contains all its bodies
  uint32_t first, count;  // range of its bodies in the order along the Hilbert curve
  uint32_t next;          // index of the next cell that is not a descendant
};

/// The cells of the tree in traversal order, parents before children, in scaled units. Memory grows
/// with the number of bodies and is reused.
template <class Real>
class Octree {
 public:
  /// Sorts the bodies along the Hilbert curve, and splits them into cells until each leaf contains
  /// at most `leaf_size` bodies, or only bodies at one point. The result does not depend on
  /// `parallel` (see RadixSort).
  template <class Parallel>
  void Build(const Parallel& parallel, std::span<const Vec3<Real>> position,
             std::span<const Real> mass, uint32_t leaf_size);

  const Scales& scales() const { return scales_; }
  const std::vector<Cell<Real>>& cells() const { return cells_; }
  const std::vector<Multipole<Real>>& multipoles() const { return multipoles_; }
  /// Returns the bodies in the order along the Hilbert curve.
  const std::vector<Source<Real>>& sources() const { return sources_; }
  /// Returns the row of the k-th body of the order along the Hilbert curve.
  uint32_t Row(uint64_t k) const { return items_[k].row; }

  /// Descends the tree until each cell is small as seen from every point of the box: reach <= theta
  /// * distance. Calls far(cell index, distance^2) for these cells. Calls near(run of bodies) for
  /// leaves that are too close or contain one body.
  template <class Far, class Near>
  void Walk(const Box<Real>& from, Real theta2, const Far& far, const Near& near) const {
    for (uint32_t c = 0; c < cells_.size();) {
      const Cell<Real>& cell = cells_[c];
      const Real distance2 = from.NearestSquare(cell.centre);
      if (cell.count > 1 && cell.reach2 <= theta2 * distance2) {
        far(c, distance2);
        c = cell.next;
      } else if (cell.next == c + 1) {
        near(Run{cell.first, cell.count});
        c = cell.next;
      } else {
        ++c;
      }
    }
  }

 private:
  static constexpr uint64_t kGrain = 8192;
  static constexpr int kExtent = 20;

  template <class Parallel>
  void Scale(const Parallel& parallel, std::span<const Vec3<Real>> position,
             std::span<const Real> mass);
  template <class Parallel>
  void Sort(const Parallel& parallel, std::span<const Vec3<Real>> position, uint64_t first,
            uint64_t last);
  template <class Parallel>
  void Cut(const Parallel& parallel, std::span<const Vec3<Real>> position, uint32_t first,
           uint32_t last, uint32_t leaf_size);
  template <class Parallel>
  Box<Real> Bounds(const Parallel& parallel, std::span<const Vec3<Real>> position, uint64_t first,
                   uint64_t last);
  template <class Parallel>
  void Gather(const Parallel& parallel, std::span<const Vec3<Real>> position,
              std::span<const Real> mass);
  template <class Parallel>
  void Weigh(const Parallel& parallel);
  void WeighLeaf(uint32_t c);
  void WeighParent(uint32_t c);

  Scales scales_;
  RadixSort sort_;
  std::vector<Keyed> items_;           // one per body
  std::vector<Source<Real>> sources_;  // one per body
  std::vector<Box<Real>> bounds_;      // one per chunk of bodies
  std::vector<Real> largest_;      // largest coordinate and largest mass of each chunk of bodies
  std::vector<Cell<Real>> cells_;  // parents precede their children
  std::vector<Box<Real>> boxes_;   // one per cell
  std::vector<Multipole<Real>> multipoles_;  // one per cell
};

template <class Real>
template <class Parallel>
void Octree<Real>::Build(const Parallel& parallel, std::span<const Vec3<Real>> position,
                         std::span<const Real> mass, uint32_t leaf_size) {
  items_.resize(position.size());
  for (uint32_t row = 0; row < items_.size(); ++row) items_[row].row = row;
  cells_.clear();
  Scale(parallel, position, mass);
  const auto bodies = static_cast<uint32_t>(items_.size());
  Sort(parallel, position, 0, bodies);
  Cut(parallel, position, 0, bodies, leaf_size);
  Gather(parallel, position, mass);
  Weigh(parallel);
}

/// Scales the largest coordinate to about 2^kExtent and the heaviest body to about 2^-32, so that
/// the total mass is less than 1.
template <class Real>
template <class Parallel>
void Octree<Real>::Scale(const Parallel& parallel, std::span<const Vec3<Real>> position,
                         std::span<const Real> mass) {
  largest_.assign(2 * ((position.size() + kGrain - 1) / kGrain), 0);
  parallel(position.size(), kGrain, [&](uint64_t begin, uint64_t end) {
    Real length = 0, heaviest = 0;
    for (uint64_t row = begin; row < end; ++row) {
      const Vec3<Real>& p = position[row];
      length = std::max({length, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      heaviest = std::max(heaviest, mass[row]);
    }
    largest_[2 * (begin / kGrain)] = length;
    largest_[2 * (begin / kGrain) + 1] = heaviest;
  });
  Real length = 0, heaviest = 0;
  for (uint64_t chunk = 0; chunk < largest_.size(); chunk += 2) {
    length = std::max(length, largest_[chunk]);
    heaviest = std::max(heaviest, largest_[chunk + 1]);
  }
  const auto scale = [](Real largest, int exponent) {
    return largest > 0 ? std::ldexp(1.0, exponent - std::ilogb(largest)) : 1.0;
  };
  scales_ = {scale(length, kExtent), scale(heaviest, -32)};
}

/// Sorts items [first, last) along the Hilbert curve through a cube. The lower corner of the cube
/// is that of the items' bounding box, and its side is the longest side of this box.
template <class Real>
template <class Parallel>
void Octree<Real>::Sort(const Parallel& parallel, std::span<const Vec3<Real>> position,
                        uint64_t first, uint64_t last) {
  const Box<Real> box = Bounds(parallel, position, first, last);
  // Returns half the difference, computed in double, so that it does not overflow.
  const auto half = [](Real high, Real low) { return 0.5 * double{high} - 0.5 * double{low}; };
  const double extent = std::max(
      {half(box.high.x, box.low.x), half(box.high.y, box.low.y), half(box.high.z, box.low.z)});
  constexpr double kCells = 1 << kHilbertLevels;
  const auto place = [&](Real at, Real low) {
    const double cell = extent > 0 ? half(at, low) / extent * kCells : 0;
    return static_cast<uint64_t>(std::min(cell, kCells - 1));
  };
  const std::span<Keyed> items = std::span(items_).subspan(first, last - first);
  parallel(items.size(), kGrain, [&](uint64_t begin, uint64_t end) {
    for (Keyed& item : items.subspan(begin, end - begin)) {
      const Vec3<Real> p = position[item.row];
      item.key = HilbertPlace(place(p.x, box.low.x), place(p.y, box.low.y), place(p.z, box.low.z));
    }
  });
  sort_(parallel, items);
}

template <class Real>
template <class Parallel>
Box<Real> Octree<Real>::Bounds(const Parallel& parallel, std::span<const Vec3<Real>> position,
                               uint64_t first, uint64_t last) {
  bounds_.assign((last - first + kGrain - 1) / kGrain, {});
  parallel(last - first, kGrain, [&](uint64_t begin, uint64_t end) {
    Box<Real> box;
    for (uint64_t k = first + begin; k < first + end; ++k) box.Include(position[items_[k].row]);
    bounds_[begin / kGrain] = box;
  });
  Box<Real> all;
  for (const Box<Real>& box : bounds_) all.Include(box);
  return all;
}

/// Appends the cell of items [first, last) and its descendants. Items with equal keys are sorted
/// again with keys from their own bounding box. Therefore a distant outlier, which makes the first
/// keys coarse, costs time but no accuracy.
template <class Real>
template <class Parallel>
void Octree<Real>::Cut(const Parallel& parallel, std::span<const Vec3<Real>> position,
                       uint32_t first, uint32_t last, uint32_t leaf_size) {
  const auto c = static_cast<uint32_t>(cells_.size());
  cells_.push_back({{}, 0, first, last - first, 0});
  if (last - first > leaf_size) {
    const auto difference = [&] { return items_[first].key ^ items_[last - 1].key; };
    if (difference() == 0) Sort(parallel, position, first, last);
    if (difference() != 0) {
      const int shift = (63 - std::countl_zero(difference())) / 3 * 3;
      for (uint32_t begin = first; begin < last;) {
        const uint64_t octant = items_[begin].key >> shift;
        const auto end =
            std::partition_point(items_.begin() + begin, items_.begin() + last,
                                 [&](const Keyed& item) { return item.key >> shift == octant; });
        const auto stop = static_cast<uint32_t>(end - items_.begin());
        Cut(parallel, position, begin, stop, leaf_size);
        begin = stop;
      }
    }
  }
  cells_[c].next = static_cast<uint32_t>(cells_.size());
}

template <class Real>
template <class Parallel>
void Octree<Real>::Gather(const Parallel& parallel, std::span<const Vec3<Real>> position,
                          std::span<const Real> mass) {
  sources_.resize(items_.size());
  const auto scaled = [](Real x, double by) { return static_cast<Real>(double{x} * by); };
  parallel(items_.size(), kGrain, [&](uint64_t begin, uint64_t end) {
    for (uint64_t k = begin; k < end; ++k) {
      const Vec3<Real>& p = position[items_[k].row];
      sources_[k] = {
          {scaled(p.x, scales_.length), scaled(p.y, scales_.length), scaled(p.z, scales_.length)},
          scaled(mass[items_[k].row], scales_.mass)};
    }
  });
}

template <class Real>
template <class Parallel>
void Octree<Real>::Weigh(const Parallel& parallel) {
  boxes_.resize(cells_.size());
  multipoles_.resize(cells_.size());
  parallel(cells_.size(), 1024, [&](uint64_t begin, uint64_t end) {
    for (auto c = static_cast<uint32_t>(begin); c < end; ++c) {
      if (cells_[c].next == c + 1) WeighLeaf(c);
    }
  });
  for (auto c = static_cast<uint32_t>(cells_.size()); c-- > 0;) {
    if (cells_[c].next != c + 1) WeighParent(c);
  }
}

/// Adds the second moments of a mass `weight` to those of `whole`. The mass is at the offset d from
/// the common centre of mass.
template <class Real>
void AddSpread(Multipole<Real>& whole, Vec3<Real> d, Real weight) {
  whole.xx += weight * d.x * d.x;
  whole.xy += weight * d.x * d.y;
  whole.xz += weight * d.x * d.z;
  whole.yy += weight * d.y * d.y;
  whole.yz += weight * d.y * d.z;
  whole.zz += weight * d.z * d.z;
}

template <class Real>
void Octree<Real>::WeighLeaf(uint32_t c) {
  Cell<Real>& cell = cells_[c];
  const std::span bodies(sources_.data() + cell.first, cell.count);
  Multipole<Real> whole{};
  Box<Real> box;
  for (const Source<Real>& body : bodies) {
    whole.mass += body.mass;
    box.Include(body.position);
  }
  // Sums positions relative to a body. Therefore rounding errors depend on the size of the cell,
  // and not on its position.
  const Vec3<Real> origin = bodies[0].position;
  const Real each = whole.mass > 0 ? 1 / whole.mass : 0;
  for (const Source<Real>& body : bodies) {
    whole.centre += (body.position - origin) * (body.mass * each);
  }
  whole.centre += origin;
  for (const Source<Real>& body : bodies) {
    AddSpread(whole, body.position - whole.centre, 3 * body.mass * each);
  }
  whole.trace = whole.xx + whole.yy + whole.zz;
  multipoles_[c] = whole;
  boxes_[c] = box;
  cell.centre = whole.centre;
  cell.reach2 = box.FarthestSquare(whole.centre);
}

template <class Real>
void Octree<Real>::WeighParent(uint32_t c) {
  Cell<Real>& cell = cells_[c];
  Multipole<Real> whole{};
  Box<Real> box;
  const auto for_children = [&](const auto& each) {
    for (uint32_t child = c + 1; child < cell.next; child = cells_[child].next) each(child);
  };
  for_children([&](uint32_t child) {
    whole.mass += multipoles_[child].mass;
    box.Include(boxes_[child]);
  });
  const Vec3<Real> origin = multipoles_[c + 1].centre;
  const Real each = whole.mass > 0 ? 1 / whole.mass : 0;
  for_children([&](uint32_t child) {
    whole.centre += (multipoles_[child].centre - origin) * (multipoles_[child].mass * each);
  });
  whole.centre += origin;
  for_children([&](uint32_t child) {
    const Multipole<Real>& part = multipoles_[child];
    const Real weight = part.mass * each;
    AddSpread(whole, part.centre - whole.centre, 3 * weight);
    whole.xx += weight * part.xx;
    whole.xy += weight * part.xy;
    whole.xz += weight * part.xz;
    whole.yy += weight * part.yy;
    whole.yz += weight * part.yz;
    whole.zz += weight * part.zz;
  });
  whole.trace = whole.xx + whole.yy + whole.zz;
  multipoles_[c] = whole;
  boxes_[c] = box;
  cell.centre = whole.centre;
  cell.reach2 = box.FarthestSquare(whole.centre);
}

}  // namespace vesper::barnes_hut
