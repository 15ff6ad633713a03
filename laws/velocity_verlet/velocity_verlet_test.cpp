// SPDX-License-Identifier: Apache-2.0
#include "oscillator.hpp"

namespace vesper {
namespace {

template <class Real>
class VelocityVerletTest : public ::testing::Test {};
TYPED_TEST_SUITE(VelocityVerletTest, Precisions);

constexpr auto kLaw = "velocity_verlet";

// The first step of a body adds a term of third order, so the order converges linearly in dt.
TYPED_TEST(VelocityVerletTest, ErrorFallsWithTheSquareOfTheStep) {
  for (const uint32_t steps : StepsAboveRounding<TypeParam>({50}, {400, 1600})) {
    const Convergence measured = MeasureConvergence<TypeParam>(kLaw, steps);
    EXPECT_NEAR(measured.order, 2, 10. / steps + measured.rounding) << steps << " steps";
  }
}

// The energy of the scheme oscillates by about (omega dt)^2 / 4. Its mean is constant.
TYPED_TEST(VelocityVerletTest, EnergySwingsButDoesNotDrift) {
  const double dt = 0.05;
  const double early = LargestEnergyError<TypeParam>(kLaw, dt, 1000);
  const double late = LargestEnergyError<TypeParam>(kLaw, dt, 4000);
  EXPECT_LT(early, 25 * dt * dt / 4);
  EXPECT_LT(late, early * 1.01 + LargestRoundingOfEnergy<TypeParam>(4000));
  EXPECT_GT(LargestEnergyError<TypeParam>("newton_motion", dt, 1000), 10 * early);
}

// The scheme is exact, including the first step: x(n) = x + n v dt + n^2 a dt^2 / 2.
TYPED_TEST(VelocityVerletTest, ConstantForceGivesTheParabola) {
  Scene<TypeParam> scene;
  scene.AddBody(2, {1, 2, 3}, {3, -1, 0});
  scene.applied_force = {-8, 4, 1};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw(kLaw);
  engine.Advance(0.01, 500);
  EXPECT_NEAR(scene.position[0], 1 + 3 * 5 - 4 * 25 / 2.0, Rounding<TypeParam>(500 * 60));
  EXPECT_NEAR(scene.position[1], 2 - 1 * 5 + 2 * 25 / 2.0, Rounding<TypeParam>(500 * 30));
  EXPECT_NEAR(scene.velocity[2], 0.5 * 5, Rounding<TypeParam>(500 * 3));
}

TYPED_TEST(VelocityVerletTest, MassZeroNeverMoves) {
  Scene<TypeParam> scene;
  scene.AddBody(0, {1, 2, 3}, {4, 5, 6});
  scene.applied_force = {1e6, -1e6, 1e6};
  const auto position = scene.position, velocity = scene.velocity;
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw(kLaw);
  engine.Advance(0.1, 100);
  EXPECT_EQ(scene.position, position);
  EXPECT_EQ(scene.velocity, velocity);
}

TYPED_TEST(VelocityVerletTest, BodyThatWasImmovableStartsWithoutAKick) {
  Scene<TypeParam> scene;
  scene.AddBody(2, {0, 0, 0});
  scene.applied_force = {8, 0, 0};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw(kLaw);
  engine.Advance(0.5);
  scene.mass[0] = 0;
  engine.Advance(0.5);
  scene.mass[0] = 2;
  scene.velocity[0] = scene.position[0] = scene.applied_force[0] = 0;
  engine.Advance(0.5);
  EXPECT_EQ(scene.velocity[0], 0);
}

TYPED_TEST(VelocityVerletTest, SameBitsForAnyNumberOfThreads) {
  const uint32_t seed = 7;
  auto one = RandomNetwork<TypeParam>(20000, seed), eight = one;
  PhysicsEngine engine_one = one.MakeEngine(1), engine_eight = eight.MakeEngine(8);
  for (PhysicsEngine* engine : {&engine_one, &engine_eight}) {
    engine->LoadPhysicsLaw("hooke_spring");
    engine->LoadPhysicsLaw(kLaw);
    engine->Advance(0.01, 3);
  }
  EXPECT_EQ(one.position, eight.position);
  EXPECT_EQ(one.velocity, eight.velocity);
}

}  // namespace
}  // namespace vesper
