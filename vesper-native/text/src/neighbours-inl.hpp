// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace vesper::text {

template <class Real>
void Neighbours<Real>::Reserve(uint64_t rows) {
  sorted_.reserve(rows);
  for (auto* column : {&x_, &y_, &z_}) column->reserve(rows);
}

template <class Real>
void Neighbours<Real>::Sort(const Real* positions, uint64_t rows, double within) {
  std::array<double, 3> low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  for (uint64_t i = 0; i < rows; ++i) {
    for (size_t k = 0; k < 3; ++k) {
      const auto at = static_cast<double>(positions[3 * i + k]);
      if (at < low[k]) low[k] = at;
      if (at > high[k]) high[k] = at;
    }
  }
  // Cells are larger than the distance where the rows are too far apart for their numbers.
  double side = within;
  for (size_t k = 0; k < 3; ++k) {
    if (std::isfinite(high[k] - low[k])) side = std::max(side, (high[k] - low[k]) / (1 << 20));
  }
  sorted_.clear();
  for (uint64_t i = 0; i < rows; ++i) {
    uint64_t cell = 0;
    for (size_t k = 3; k-- > 0;) {
      const double at = (static_cast<double>(positions[3 * i + k]) - low[k]) / side;
      // From 1 on, so that a neighbour's number is not below 0. NaN is in cell 1, and no neighbour.
      const auto number = at > 0 ? static_cast<uint64_t>(std::min(at, 1048576.0)) + 1 : uint64_t{1};
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
  // Half of the neighbours: later cells of this line, and four lines of three cells.
  struct Line {
    int64_t first, last;  // offsets of cell numbers
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

}  // namespace vesper::text
