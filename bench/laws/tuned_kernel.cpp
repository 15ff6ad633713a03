// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>
#include <string>

#include "gravitation.hpp"
#include "peers/pairs_avx512.hpp"

namespace bench {
namespace {

template <class Real>
class Kernel : public Side {
 public:
  explicit Kernel(const World& world)
      : bodies_(world.bodies()), softening2_(static_cast<Real>(world.softening * world.softening)) {
    for (uint64_t i = 0; i < bodies_.count; ++i) {
      for (int c = 0; c < 3; ++c) bodies_[c][i] = static_cast<Real>(world.position[3 * i + c]);
      bodies_[3][i] = static_cast<Real>(1.0 / static_cast<double>(bodies_.count));
    }
  }

  std::vector<double> Accelerations() override {
    std::vector<double> accelerations;
    for (uint64_t i = 0; i < bodies_.count; ++i) {
      for (int c = 4; c < 7; ++c) accelerations.push_back(static_cast<double>(bodies_[c][i]));
    }
    return accelerations;
  }

 protected:
  Bodies<Real> bodies_;
  Real softening2_;
};

class SingleKernel : public Kernel<float> {
 public:
  explicit SingleKernel(const World& world) : Kernel(world), kernel_(bodies_, kThreads) {}
  void Run() override { kernel_.Run(softening2_); }

 private:
  ThirdLawKernel kernel_;
};

class DoubleKernel : public Kernel<double> {
 public:
  using Kernel::Kernel;
  void Run() override { RunBothSides(bodies_, softening2_, kThreads); }
};

}  // namespace

std::unique_ptr<Side> MakeKernel(const World& world, bool single) {
  if (!__builtin_cpu_supports("avx512f")) {
    throw std::runtime_error("the kernel to compare with needs AVX-512");
  }
  if (world.bodies() % 64 != 0) {
    throw std::runtime_error(std::to_string(world.bodies()) +
                             " bodies; the kernel to compare with needs a multiple of 64");
  }
  if (single) return std::make_unique<SingleKernel>(world);
  return std::make_unique<DoubleKernel>(world);
}

}  // namespace bench
