// SPDX-License-Identifier: Apache-2.0
// Pairs of rows within a distance, for laws whose forces are zero beyond it. A law that includes
// this header also includes vesper/law.hpp.
#ifndef VESPER_LAW_NEIGHBOURS_HPP_
#define VESPER_LAW_NEIGHBOURS_HPP_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vesper {

/** A search for pairs of near rows, by a grid of cells whose side is the distance. The order of the
 *  pairs depends on the positions and rows only. Only one thread at a time may use an object. An
 *  object may be a member of a law, because it keeps nothing except allocated memory between two
 *  searches. */
template <class Real>
class Neighbours {
 public:
  /** Reserves memory for a number of rows, so that later searches allocate none. */
  void Reserve(uint64_t rows);

  /** Finds all pairs (a, b) with a < b whose distance is at most `within` > 0 [m], and passes them
   *  to `take(count)` in groups. The pairs of a group are in the first `count` elements of the
   *  arrays `a` and `b`, which have at least `most` elements. `positions`: (rows x 3) [m]. A row
   *  whose position is NaN has no pairs. */
  template <class Take>
  void ForEach(const Real* positions, uint64_t rows, double within, uint32_t* a, uint32_t* b,
               size_t most, Take&& take);

  /** Calls `body(a, b)` for all pairs of rows a < b whose distance is at most `within` [m], one
   *  after the other. `positions`: (rows) vectors with members x, y, z [m]. There are no pairs if
   *  `within` is not above 0. */
  template <class Vector, class Body>
  void ForEachPair(const Vector* positions, uint64_t rows, double within, Body&& body) {
    if (rows == 0 || !(within > 0)) return;
    std::array<uint32_t, kGroup> a, b;
    ForEach(&positions->x, rows, within, a.data(), b.data(), kGroup, [&](size_t count) {
      for (size_t i = 0; i < count; ++i) body(a[i], b[i]);
    });
  }

 private:
  struct Row {
    uint64_t cell;
    uint32_t row;
    bool operator<(const Row& other) const {
      return cell != other.cell ? cell < other.cell : row < other.row;
    }
  };
  static constexpr size_t kGroup = 64;
  static constexpr int kBits = 21;         // bits of each coordinate in the number of a cell
  static constexpr double kHalf = 524288;  // number of cells on each side of the middle
  static constexpr uint64_t kSample = 1024;

  // Returns the side of the cells. It is `within`, or more if the rows are so far apart that there
  // would be too many cells. `middle` becomes the median of a sample of the rows. Rows that are
  // very far from the middle share the outermost cells. Therefore a single distant row does not
  // change the cells of the other rows.
  double Cells(const Real* positions, uint64_t rows, double within, std::array<double, 3>& middle);

  void Sort(const Real* positions, uint64_t rows, double within);

  std::vector<Row> sorted_;
  std::vector<Real> x_, y_, z_;  // positions in the order of sorted_
  std::vector<double> sample_;
};

template <class Real>
void Neighbours<Real>::Reserve(uint64_t rows) {
  sorted_.reserve(rows);
  sample_.reserve(kSample);
  for (auto* column : {&x_, &y_, &z_}) column->reserve(rows);
}

template <class Real>
double Neighbours<Real>::Cells(const Real* positions, uint64_t rows, double within,
                               std::array<double, 3>& middle) {
  double side = within;
  const uint64_t stride = rows / kSample + 1;
  for (size_t k = 0; k < 3; ++k) {
    sample_.clear();
    for (uint64_t i = 0; i < rows; i += stride) {
      const auto at = static_cast<double>(positions[3 * i + k]);
      if (std::isfinite(at)) sample_.push_back(at);
    }
    if (sample_.empty()) continue;
    std::sort(sample_.begin(), sample_.end());
    middle[k] = sample_[sample_.size() / 2];
    const double most = sample_[sample_.size() * 9 / 10] - sample_[sample_.size() / 10];
    if (std::isfinite(most)) side = std::max(side, most / kHalf);
  }
  return side;
}

template <class Real>
void Neighbours<Real>::Sort(const Real* positions, uint64_t rows, double within) {
  std::array<double, 3> middle{};
  const double side = Cells(positions, rows, within, middle);
  sorted_.clear();
  for (uint64_t i = 0; i < rows; ++i) {
    uint64_t cell = 0;
    for (size_t k = 3; k-- > 0;) {
      const double at = std::floor((static_cast<double>(positions[3 * i + k]) - middle[k]) / side);
      // Cell numbers begin at 1, so that a neighbour's number is not below 0. A coordinate that is
      // NaN gets number 1, and its row has no pairs.
      const auto number =
          at > -kHalf ? static_cast<uint64_t>(std::min(at, kHalf) + kHalf) + 1 : uint64_t{1};
      cell = cell << kBits | number;
    }
    sorted_.push_back({cell, static_cast<uint32_t>(i)});
  }
  std::sort(sorted_.begin(), sorted_.end());
  for (auto* column : {&x_, &y_, &z_}) column->clear();
  for (const Row& row : sorted_) {
    x_.push_back(positions[3 * uint64_t{row.row}]);
    y_.push_back(positions[3 * uint64_t{row.row} + 1]);
    z_.push_back(positions[3 * uint64_t{row.row} + 2]);
  }
}

template <class Real>
template <class Take>
void Neighbours<Real>::ForEach(const Real* positions, uint64_t rows, double within, uint32_t* a,
                               uint32_t* b, size_t most, Take&& take) {
  Sort(positions, rows, within);
  const auto limit = static_cast<Real>(within * within);
  size_t found = 0;
  const auto compare = [&](size_t i, size_t begin, size_t end) {
    for (size_t j = begin; j < end; ++j) {
      const Real dx = x_[j] - x_[i], dy = y_[j] - y_[i], dz = z_[j] - z_[i];
      if (!(dx * dx + dy * dy + dz * dz <= limit)) continue;
      a[found] = std::min(sorted_[i].row, sorted_[j].row);
      b[found] = std::max(sorted_[i].row, sorted_[j].row);
      if (++found < most) continue;
      take(found);
      found = 0;
    }
  };
  // The search visits half of the neighbouring cells, so that it finds each pair once: the later
  // cells of this line, and four lines of three cells.
  struct Line {
    int64_t first, last;  // first and last cell of the line, as offsets to the cell's number
    size_t begin = 0, end = 0;
  };
  const auto offset = [](int64_t dx, int64_t dy, int64_t dz) {
    return dx + dy * (int64_t{1} << kBits) + dz * (int64_t{1} << (2 * kBits));
  };
  std::array<Line, 5> lines{{{offset(1, 0, 0), offset(1, 0, 0)},
                             {offset(-1, 1, 0), offset(1, 1, 0)},
                             {offset(-1, -1, 1), offset(1, -1, 1)},
                             {offset(-1, 0, 1), offset(1, 0, 1)},
                             {offset(-1, 1, 1), offset(1, 1, 1)}}};
  for (size_t begin = 0; begin < sorted_.size();) {
    const uint64_t cell = sorted_[begin].cell;
    size_t end = begin;
    while (end < sorted_.size() && sorted_[end].cell == cell) ++end;
    for (Line& line : lines) {
      const uint64_t first = cell + static_cast<uint64_t>(line.first);
      const uint64_t last = cell + static_cast<uint64_t>(line.last);
      while (line.begin < sorted_.size() && sorted_[line.begin].cell < first) ++line.begin;
      line.end = std::max(line.end, line.begin);
      while (line.end < sorted_.size() && sorted_[line.end].cell <= last) ++line.end;
    }
    for (size_t i = begin; i < end; ++i) {
      compare(i, i + 1, end);
      for (const Line& line : lines) compare(i, line.begin, line.end);
    }
    begin = end;
  }
  if (found > 0) take(found);
}

}  // namespace vesper

#endif  // VESPER_LAW_NEIGHBOURS_HPP_
