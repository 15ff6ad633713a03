// SPDX-License-Identifier: Apache-2.0
// Pairs of rows within a distance.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace vesper::text {

/// Finds pairs of near rows by a grid of cells whose side is the distance. The order of the pairs
/// depends on the positions and rows only.
template <class Real>
class Neighbours {
 public:
  /// Reserves memory for a number of rows.
  void Reserve(uint64_t rows);

  /// Passes all pairs (a, b) with a < b whose distance is at most `within` > 0 to `take`, in groups
  /// of at most `most` pairs. `positions`: (rows x 3).
  template <class Take>
  void ForEach(const Real* positions, uint64_t rows, double within, uint32_t* a, uint32_t* b,
               size_t most, Take&& take);

 private:
  struct Row {
    uint64_t cell;
    uint32_t row;
    bool operator<(const Row& other) const {
      return cell != other.cell ? cell < other.cell : row < other.row;
    }
  };
  static constexpr int kBits = 21;         // bits of each coordinate in the number of a cell
  static constexpr double kHalf = 524288;  // number of cells on each side of the middle
  static constexpr uint64_t kSample = 1024;

  /// Returns the side of the cells: `within`, or more if the rows are so far apart that there would
  /// be too many cells. `middle` becomes the median of a sample of the rows. Rows that are too far
  /// from it for a cell of their own share the outermost cells, so one distant row does not change
  /// the cells of the others.
  double Cells(const Real* positions, uint64_t rows, double within, std::array<double, 3>& middle);

  void Sort(const Real* positions, uint64_t rows, double within);

  std::vector<Row> sorted_;
  std::vector<Real> x_, y_, z_;  // positions in the order of sorted_
  std::vector<double> sample_;
};

}  // namespace vesper::text

#include "neighbours-inl.hpp"
