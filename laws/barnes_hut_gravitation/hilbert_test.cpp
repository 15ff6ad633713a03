// SPDX-License-Identifier: Apache-2.0
#include "hilbert.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace vesper::barnes_hut {
namespace {

struct Place {
  uint64_t along;
  int64_t x, y, z;
};

/// Returns the cells of a grid of n^3, `size` fine cells wide, in the order of the curve.
std::vector<Place> Visit(int64_t n, int64_t size) {
  std::vector<Place> places;
  for (int64_t x = 0; x < n; ++x) {
    for (int64_t y = 0; y < n; ++y) {
      for (int64_t z = 0; z < n; ++z) {
        const auto at = [&](int64_t i) { return static_cast<uint64_t>(i * size); };
        places.push_back({HilbertPlace(at(x), at(y), at(z)), x, y, z});
      }
    }
  }
  std::ranges::sort(places, {}, &Place::along);
  return places;
}

TEST(HilbertTest, CellsThatFollowOneAnotherTouch) {
  for (const int64_t size : {int64_t{1}, int64_t{1} << (kHilbertLevels - 4)}) {
    const std::vector<Place> places = Visit(16, size);
    for (size_t i = 1; i < places.size(); ++i) {
      const Place &a = places[i - 1], &b = places[i];
      ASSERT_EQ(std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z), 1)
          << "after place " << a.along << " of cells " << size << " wide";
    }
  }
}

TEST(HilbertTest, TheFinestCellsHaveSuccessivePlacesFromZeroOn) {
  const std::vector<Place> places = Visit(16, 1);
  for (size_t i = 0; i < places.size(); ++i) ASSERT_EQ(places[i].along, i);
}

TEST(HilbertTest, EightCellsThatMakeALargerOneStayTogether) {
  const std::vector<Place> places = Visit(16, 1);
  for (size_t i = 0; i < places.size(); ++i) {
    const Place &first = places[i / 8 * 8], &here = places[i];
    ASSERT_TRUE(first.x / 2 == here.x / 2 && first.y / 2 == here.y / 2 && first.z / 2 == here.z / 2)
        << "place " << i;
  }
}

}  // namespace
}  // namespace vesper::barnes_hut
