// SPDX-License-Identifier: Apache-2.0
#include "moves.hpp"

#include <gtest/gtest.h>

#include <random>

namespace vesper::newton_motion {
namespace {

constexpr uint32_t kSeed = 23;

/// Random bodies, of which every seventh or none is immovable.
template <class Real>
struct Crowd {
  Crowd(uint32_t count, bool some_immovable) {
    std::mt19937 random(kSeed);
    const auto draw = [&] { return static_cast<Real>(random() / 4294967296.0 - 0.5); };
    const auto draw_row = [&] { return Vec3<Real>{draw(), draw(), draw()}; };
    for (uint32_t i = 0; i < count; ++i) {
      mass.push_back(some_immovable && i % 7 == 3 ? 0 : draw() + 1);
      force.push_back(draw_row());
      velocity.push_back(draw_row());
      position.push_back(draw_row());
    }
  }

  void Move(const Moves<Real>& compiled, uint64_t begin, uint64_t end) {
    compiled.move({mass.data(), force.data(), velocity.data(), position.data()}, begin, end, kDt);
  }

  /// Moves each body by the equation.
  void MoveEach(uint64_t begin, uint64_t end) {
    for (uint64_t i = begin; i < end; ++i) {
      if (mass[i] == 0) continue;
      const Real inverse = 1 / mass[i];
      const auto step = [&](Real force, Real& velocity, Real& position) {
        velocity += force * inverse * kDt;
        position += velocity * kDt;
      };
      step(force[i].x, velocity[i].x, position[i].x);
      step(force[i].y, velocity[i].y, position[i].y);
      step(force[i].z, velocity[i].z, position[i].z);
    }
  }

  static constexpr auto kDt = Real(0.01);
  std::vector<Real> mass;
  std::vector<Vec3<Real>> force, velocity, position;
};

template <class Real>
class MovesTest : public ::testing::Test {};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(MovesTest, Precisions);

// The test uses whole vectors of bodies, less than one vector, and ranges that begin within a
// vector.
TYPED_TEST(MovesTest, EveryInstructionSetMovesToTheBitAsTheEquationSays) {
  for (const auto& compiled : AvailableMoves<TypeParam>()) {
    for (const bool some_immovable : {false, true}) {
      for (const auto& [begin, end] : {std::pair{0, 200}, {5, 6}, {3, 100}, {16, 48}, {7, 7}}) {
        Crowd<TypeParam> crowd(200, some_immovable), expected = crowd;
        crowd.Move(compiled, begin, end);
        expected.MoveEach(begin, end);
        SCOPED_TRACE(compiled.instruction_set);
        EXPECT_EQ(crowd.velocity, expected.velocity)
            << "rows " << begin << " to " << end << ", seed " << kSeed;
        EXPECT_EQ(crowd.position, expected.position)
            << "rows " << begin << " to " << end << ", seed " << kSeed;
      }
    }
  }
}

}  // namespace
}  // namespace vesper::newton_motion
