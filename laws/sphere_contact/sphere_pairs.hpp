// SPDX-License-Identifier: Apache-2.0
// Search for pairs of spheres that may touch, with grids of cells. The lists of pairs do not depend
// on the number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "vesper/law.hpp"

namespace vesper {

/** Spheres as columns of `count` rows, borrowed during a call. */
template <class Real>
struct Spheres {
  uint64_t count;
  const Vec3<Real>* centre;
  const Real* radius;  // 0: the sphere is ignored
  const Real* mass;    // 0: immovable; two immovable spheres form no pair
};

/** The pairs of spheres that are closer than a margin. The lists are valid until a sphere has
 *  moved by half of the margin. Every pair is in one list only: that of its smaller sphere. If both
 *  spheres are equal, it is in the list of the lower row. Therefore at most 12 partners in the list
 *  of a sphere touch it, unless they overlap deeply.
 *
 *  Lists are in ascending order of rows. Therefore sums over the touching pairs of a list do not
 *  depend on the time when the list was built. */
template <class Real>
class SpherePairs {
 public:
  /** Updates the lists for these spheres. `for_each(count, body)` calls body(begin, end) for
   *  ranges that cover [0, count), possibly concurrently. Throws if a centre or radius is not
   *  finite, or if there are more pairs than fit in memory. */
  template <class ForEach>
  void Update(const Spheres<Real>& spheres, const ForEach& for_each) {
    if (StillGood(spheres, for_each)) return;
    built_.clear();  // if building fails, the old lists must not look valid
    MakeGrids(spheres);
    ListPartners(spheres, for_each);
    ListReverse(spheres.count);
    Remember(spheres);
  }

  /** Returns the rows of the spheres in pairs with `row` as the smaller one. */
  std::span<const uint32_t> PartnersOf(uint64_t row) const {
    return {partners_.data() + first_[row], partners_.data() + first_[row + 1]};
  }
  /** Returns the number of the first pair in PartnersOf(row); the others have the next numbers. */
  uint32_t FirstPair(uint64_t row) const { return first_[row]; }
  /** Returns the numbers of the pairs with `row` as the larger one. */
  std::span<const uint32_t> PairsAsLarger(uint64_t row) const {
    return {reverse_.data() + reverse_first_[row], reverse_.data() + reverse_first_[row + 1]};
  }
  uint64_t pair_count() const { return partners_.size(); }

 private:
  // Margin as a fraction of the median radius. It is so large that the lists stay valid for many
  // steps, and so small that the lists are short.
  static constexpr Real kMarginPerRadius = Real{0.25};
  static constexpr uint64_t kMaxPairs = uint64_t{1} << 28;

  /** Grid of the spheres whose radii have the same power of two. Its cells are so large that a
   *  sphere of this or a smaller radius can touch only spheres in its own cell and in the adjacent
   *  cells. */
  struct Grid {
    int level;
    Real largest_radius;
    Real cell_size;
  };
  struct Cell {
    int64_t x, y, z;
  };
  struct Entry {
    Vec3<Real> centre;
    Real radius;
    uint32_t row;
    int level;
    bool immovable;
  };
  struct Built {
    Vec3<Real> centre;
    Real radius;
    bool immovable;
  };

  template <class ForEach>
  bool StillGood(const Spheres<Real>& spheres, const ForEach& for_each) const {
    if (built_.size() != spheres.count) return false;
    const Real half = margin_ / 2, limit = half * half;
    std::atomic<bool> good = true;
    for_each(spheres.count, [&](uint64_t begin, uint64_t end) {
      bool all = true;
      for (uint64_t i = begin; i < end; ++i) {
        const Built& built = built_[i];
        const Vec3<Real> way = spheres.centre[i] - built.centre;
        all &= Dot(way, way) <= limit && spheres.radius[i] == built.radius &&
               (spheres.mass[i] == 0) == built.immovable;
      }
      if (!all) good.store(false, std::memory_order_relaxed);
    });
    return good;
  }

  void Remember(const Spheres<Real>& spheres) {
    built_.resize(spheres.count);
    for (uint64_t i = 0; i < spheres.count; ++i) {
      built_[i] = {spheres.centre[i], spheres.radius[i], spheres.mass[i] == 0};
    }
  }

  void MakeGrids(const Spheres<Real>& spheres) {
    if (spheres.count >= UINT32_MAX) throw std::runtime_error("more than 2^32 - 2 bodies");
    grids_.clear();
    radii_.clear();
    for (uint64_t i = 0; i < spheres.count; ++i) {
      const Vec3<Real> at = spheres.centre[i];
      const Real radius = spheres.radius[i];
      if (!std::isfinite(at.x + at.y + at.z) || !std::isfinite(radius)) {
        throw std::runtime_error("position or radius of row " + std::to_string(i) +
                                 " is not finite");
      }
      if (!(radius > 0)) continue;
      radii_.push_back(radius);
      GridOf(radius).largest_radius = std::max(GridOf(radius).largest_radius, radius);
    }
    const auto median = radii_.begin() + static_cast<std::ptrdiff_t>(radii_.size() / 2);
    std::nth_element(radii_.begin(), median, radii_.end());
    margin_ = radii_.empty() ? 0 : *median * kMarginPerRadius;
    for (Grid& grid : grids_) grid.cell_size = 2 * grid.largest_radius + margin_;
    FillBuckets(spheres);
  }

  /** Returns the grid for a radius, and creates it if necessary; grids are in ascending order. */
  Grid& GridOf(Real radius) {
    const int level = std::ilogb(radius);
    const auto at = std::lower_bound(grids_.begin(), grids_.end(), level,
                                     [](const Grid& grid, int l) { return grid.level < l; });
    if (at != grids_.end() && at->level == level) return *at;
    return *grids_.insert(at, {level, radius, 0});
  }

  /** Sorts the spheres by bucket, with a counting sort. The bucket of a cell follows from its
   *  coordinates modulo the number of buckets per axis. This number is at least 4, so that a cell
   *  and its neighbours have different buckets. */
  void FillBuckets(const Spheres<Real>& spheres) {
    uint64_t side = 4;
    while (side * side * side < spheres.count) side *= 2;
    mask_ = static_cast<int64_t>(side - 1);
    bucket_.assign(side * side * side + 2, 0);
    bucket_of_.resize(spheres.count);
    for (uint64_t i = 0; i < spheres.count; ++i) {
      if (!(spheres.radius[i] > 0)) continue;
      bucket_of_[i] = Bucket(CellAt(spheres.centre[i], GridOf(spheres.radius[i])));
      ++bucket_[bucket_of_[i] + 2];
    }
    for (uint64_t b = 2; b < bucket_.size(); ++b) bucket_[b] += bucket_[b - 1];
    entries_.resize(bucket_.back());
    for (uint64_t i = 0; i < spheres.count; ++i) {
      if (!(spheres.radius[i] > 0)) continue;
      entries_[bucket_[bucket_of_[i] + 1]++] = {
          spheres.centre[i], spheres.radius[i], static_cast<uint32_t>(i),
          std::ilogb(spheres.radius[i]), spheres.mass[i] == 0};
    }
  }

  static Cell CellAt(const Vec3<Real>& at, const Grid& grid) {
    return {Coordinate(at.x, grid), Coordinate(at.y, grid), Coordinate(at.z, grid)};
  }
  /** Returns the coordinate of a cell; all positions beyond 2^60 cells share the last one. */
  static int64_t Coordinate(Real x, const Grid& grid) {
    constexpr Real kLimit = Real{1ll << 60};
    return static_cast<int64_t>(std::clamp(std::floor(x / grid.cell_size), -kLimit, kLimit));
  }
  uint64_t Bucket(const Cell& cell) const {
    const int64_t side = mask_ + 1;
    return static_cast<uint64_t>(((cell.z & mask_) * side + (cell.y & mask_)) * side +
                                 (cell.x & mask_));
  }

  template <class ForEach>
  void ListPartners(const Spheres<Real>& spheres, const ForEach& for_each) {
    first_.assign(spheres.count + 1, 0);
    counts_.resize(spheres.count);
    for_each(spheres.count, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        uint64_t count = 0;
        ForPartners(spheres, i, [&](uint32_t) { ++count; });
        counts_[i] = count;
      }
    });
    uint64_t total = 0;
    for (uint64_t i = 0; i < spheres.count; ++i) {
      total += counts_[i];
      first_[i + 1] = static_cast<uint32_t>(std::min(total, kMaxPairs + 1));
    }
    if (total > kMaxPairs) {
      throw std::runtime_error(std::to_string(total) +
                               " pairs of bodies are near each other, "
                               "expected at most " +
                               std::to_string(kMaxPairs) +
                               ": are radii larger than the distances?");
    }
    partners_.resize(total);
    for_each(spheres.count, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        uint32_t* next = partners_.data() + first_[i];
        ForPartners(spheres, i, [&](uint32_t partner) { *next++ = partner; });
        std::sort(partners_.data() + first_[i], next);
      }
    });
  }

  /** Calls visit(partner) for all pairs with `row` as the smaller one, in no particular order. */
  template <class Visit>
  void ForPartners(const Spheres<Real>& spheres, uint64_t row, const Visit& visit) const {
    const Real radius = spheres.radius[row];
    if (!(radius > 0)) return;
    const Entry self{spheres.centre[row], radius, static_cast<uint32_t>(row), std::ilogb(radius),
                     spheres.mass[row] == 0};
    for (const Grid& grid : grids_) {
      if (grid.level < self.level) continue;
      const Real reach = radius + grid.largest_radius + margin_;
      const Vec3<Real> corner{reach, reach, reach};
      const Cell low = CellAt(self.centre - corner, grid);
      const Cell high = CellAt(self.centre + corner, grid);
      for (Cell cell = low; cell.z <= high.z; ++cell.z) {
        for (cell.y = low.y; cell.y <= high.y; ++cell.y) {
          for (cell.x = low.x; cell.x <= high.x; ++cell.x) {
            ForBucket(self, Bucket(cell), grid.level, visit);
          }
        }
      }
    }
  }

  template <class Visit>
  void ForBucket(const Entry& self, uint64_t bucket, int level, const Visit& visit) const {
    for (uint32_t e = bucket_[bucket]; e < bucket_[bucket + 1]; ++e) {
      const Entry& other = entries_[e];
      const Vec3<Real> way = other.centre - self.centre;
      const Real near = self.radius + other.radius + margin_;
      if (Dot(way, way) >= near * near || other.level != level) continue;
      if (other.radius < self.radius) continue;
      if (other.radius == self.radius && other.row <= self.row) continue;
      if (!(self.immovable && other.immovable)) visit(other.row);
    }
  }

  void ListReverse(uint64_t count) {
    reverse_first_.assign(count + 2, 0);
    for (const uint32_t partner : partners_) ++reverse_first_[partner + 2];
    for (uint64_t i = 2; i < reverse_first_.size(); ++i) reverse_first_[i] += reverse_first_[i - 1];
    reverse_.resize(partners_.size());
    for (uint32_t pair = 0; pair < partners_.size(); ++pair) {
      reverse_[reverse_first_[partners_[pair] + 1]++] = pair;
    }
  }

  Real margin_ = 0;
  std::vector<Built> built_;             // one per row: the sphere when the lists were built
  std::vector<uint32_t> first_;          // (rows + 1), start of each row's partners in partners_
  std::vector<uint32_t> partners_;       // one per pair
  std::vector<uint32_t> reverse_first_;  // (rows + 2), start of each row's pairs in reverse_
  std::vector<uint32_t> reverse_;        // one per pair
  // Used during a build only; reused to avoid allocations.
  std::vector<Grid> grids_;
  std::vector<Real> radii_;
  std::vector<Entry> entries_;       // entries in the order of their buckets
  std::vector<uint32_t> bucket_;     // (buckets + 2), start of each bucket in entries_
  std::vector<uint64_t> bucket_of_;  // one per row
  std::vector<uint64_t> counts_;     // one per row
  int64_t mask_ = 0;
};

}  // namespace vesper
