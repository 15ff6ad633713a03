// SPDX-License-Identifier: Apache-2.0
// Interchangeable implementations of gravitation for the same bodies.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace bench {

inline constexpr uint32_t kThreads = 2;

/// Bodies of equal mass, with a total mass of 1 kg. The gravitational constant is 1.
struct World {
  std::span<const double> position;  // (bodies x 3) [m]
  double softening;                  // [m]
  uint64_t bodies() const { return position.size() / 3; }
};

class Side {
 public:
  virtual ~Side() = default;
  virtual void Run() = 0;
  /// Returns the accelerations of the last run, (bodies x 3) [m/s^2].
  virtual std::vector<double> Accelerations() = 0;
};

/// Creates a kernel tuned for AVX-512, without engine or law. Throws if the processor lacks
/// AVX-512, or the number of bodies is not a multiple of 64.
std::unique_ptr<Side> MakeKernel(const World& world, bool single);

}  // namespace bench
