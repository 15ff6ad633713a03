// SPDX-License-Identifier: Apache-2.0
// Pairs of rows within a distance: those of a comparison of all rows, after few comparisons.
#include "vesper/law_neighbours.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace vesper::text {
namespace {

/// A number that counts products, of which each comparison of two rows has three.
struct Counted {
  double value = 0;
  static inline uint64_t products = 0;

  Counted() = default;
  explicit Counted(double from) : value(from) {}
  explicit operator double() const { return value; }
  Counted operator-(Counted other) const { return Counted(value - other.value); }
  Counted operator+(Counted other) const { return Counted(value + other.value); }
  Counted operator*(Counted other) const {
    ++products;
    return Counted(value * other.value);
  }
  bool operator<=(Counted other) const { return value <= other.value; }
};

using Pairs = std::multiset<std::pair<uint32_t, uint32_t>>;

std::vector<Counted> Cloud(size_t rows, double size, uint32_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-size, size);
  std::vector<Counted> positions;
  for (size_t i = 0; i < 3 * rows; ++i) positions.emplace_back(place(random));
  return positions;
}

void Move(std::vector<Counted>& positions, size_t row, double x) {
  positions[3 * row] = Counted(x);
}

Pairs Found(const std::vector<Counted>& positions, double within) {
  Neighbours<Counted> neighbours;
  uint32_t a[64], b[64];
  Pairs pairs;
  neighbours.ForEach(positions.data(), positions.size() / 3, within, a, b, 64, [&](size_t count) {
    for (size_t i = 0; i < count; ++i) pairs.insert({a[i], b[i]});
  });
  return pairs;
}

Pairs Expected(const std::vector<Counted>& positions, double within) {
  Pairs pairs;
  const auto at = [&](size_t i) { return positions[i].value; };
  for (uint32_t i = 0; i < positions.size() / 3; ++i) {
    for (uint32_t j = i + 1; j < positions.size() / 3; ++j) {
      const double dx = at(3 * i) - at(3 * j), dy = at(3 * i + 1) - at(3 * j + 1),
                   dz = at(3 * i + 2) - at(3 * j + 2);
      if (dx * dx + dy * dy + dz * dz <= within * within) pairs.insert({i, j});
    }
  }
  return pairs;
}

TEST(NeighboursTest, FindsThePairsOfAComparisonOfAllRows) {
  for (const double within : {1e-300, 1e-9, 0.3, 1.0, 50.0, 1e150}) {
    for (uint32_t seed = 0; seed < 4; ++seed) {
      std::vector<Counted> positions = Cloud(300, 5, seed);
      for (size_t k = 0; k < 3; ++k) positions[30 + k] = positions[60 + k];
      const double far[] = {1e9, -1e9, 1e9 + 0.1, 1e300, INFINITY, -INFINITY, NAN, 1e9 - 0.1};
      for (size_t i = 0; i < seed * 2; ++i) Move(positions, i * 7, far[i]);
      EXPECT_EQ(Found(positions, within), Expected(positions, within)) << within << " " << seed;
    }
  }
}

TEST(NeighboursTest, RowsFarAwayDoNotMakeTheOthersCostly) {
  const size_t rows = 20000;
  for (const double far : {1e9, -1e12, 1e300}) {
    std::vector<Counted> positions = Cloud(rows, 20, 9);
    Move(positions, 1, far);
    Move(positions, 2, -far / 3);
    Counted::products = 0;
    Found(positions, 1);
    EXPECT_LT(Counted::products, rows * rows / 20) << far;
  }
}

TEST(NeighboursTest, RowsOnAWideGridAreToldApart) {
  std::vector<Counted> positions;
  for (int i = 0; i < 20000; ++i) {
    for (const double at : {i * 1e6, 0.0, 0.0}) positions.emplace_back(at);
  }
  Counted::products = 0;
  EXPECT_TRUE(Found(positions, 1e-3).empty());
  EXPECT_LT(Counted::products, uint64_t{20000} * 6000);
}

}  // namespace
}  // namespace vesper::text
