// SPDX-License-Identifier: Apache-2.0
// Ways to compute the gravitation of the same bodies, one beside the other.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace bench {

inline constexpr uint32_t kThreads = 2;

/// Bodies of equal mass, 1 kg together, with G = 1.
struct World {
  std::span<const double> position;  // (bodies x 3) [m]
  double softening;                  // [m]
  uint64_t bodies() const { return position.size() / 3; }
};

class Side {
 public:
  virtual ~Side() = default;
  virtual void Run() = 0;
  /// Accelerations of the last run, (bodies x 3) [m/s^2].
  virtual std::vector<double> Accelerations() = 0;
};

/// A kernel tuned for AVX-512, without engine or law. Throws where the processor lacks AVX-512, or
/// the number of bodies is no multiple of 64.
std::unique_ptr<Side> MakeKernel(const World& world, bool single);

}  // namespace bench
