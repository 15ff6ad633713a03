// SPDX-License-Identifier: Apache-2.0
// Positions along the Hilbert curve.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace vesper::barnes_hut {

/// Bits of a coordinate per axis: the grid has 2^kHilbertLevels cells per side.
inline constexpr int kHilbertLevels = 21;

/// The position of one octant of a cube on the curve, and the orientation of the curve in this
/// octant.
struct HilbertStep {
  uint8_t place, state;
};

/// One step for each of the 24 orientations of the curve in a cube and for each octant. The method
/// is from C. Hamilton and A. Rau-Chaplin, Compact Hilbert indices, Inf. Process. Lett. 105 (2008),
/// for three dimensions.
inline constexpr auto kHilbertSteps = [] {
  const auto rotate = [](uint32_t bits, uint32_t by) {
    return (bits << by | bits >> (3 - by)) & 7u;
  };
  std::array<std::array<HilbertStep, 8>, 24> steps{};
  for (uint32_t entry = 0; entry < 8; ++entry) {
    for (uint32_t axis = 0; axis < 3; ++axis) {
      for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint32_t gray = rotate(octant ^ entry, 2 - axis);
        const uint32_t place = gray ^ gray >> 1 ^ gray >> 2;
        const uint32_t before = place == 0 ? 0 : (place - 1) & ~1u;
        const uint32_t turn =
            place == 0 ? 0 : static_cast<uint32_t>(std::countr_one((place - 1) | 1u)) % 3;
        const uint32_t next_entry = entry ^ rotate(before ^ before >> 1, (axis + 1) % 3);
        const uint32_t next_axis = (axis + turn + 1) % 3;
        steps[entry * 3 + axis][octant] = {static_cast<uint8_t>(place),
                                           static_cast<uint8_t>(next_entry * 3 + next_axis)};
      }
    }
  }
  return steps;
}();

/// Returns x with two zero bits inserted before each bit, so every third bit is a bit of x.
constexpr uint64_t Spread(uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

/// Returns the position of the cell (x, y, z) on the curve through a grid of 2^21 cells per side.
/// Consecutive cells of the curve share a face. Each group of three bits of the coordinates, from
/// the highest on, selects an octant.
inline uint64_t HilbertPlace(uint64_t x, uint64_t y, uint64_t z) {
  const uint64_t octants = Spread(x) << 2 | Spread(y) << 1 | Spread(z);
  uint64_t place = 0;
  uint32_t state = 0;
  for (int shift = 3 * (kHilbertLevels - 1); shift >= 0; shift -= 3) {
    const HilbertStep step = kHilbertSteps[state][octants >> shift & 7];
    place = place << 3 | step.place;
    state = step.state;
  }
  return place;
}

}  // namespace vesper::barnes_hut
