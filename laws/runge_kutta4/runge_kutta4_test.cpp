// SPDX-License-Identifier: Apache-2.0
#include "oscillator.hpp"

namespace vesper {
namespace {

template <class Real>
class RungeKutta4Test : public ::testing::Test {};
TYPED_TEST_SUITE(RungeKutta4Test, Precisions);

constexpr auto kLaw = "runge_kutta4";

TYPED_TEST(RungeKutta4Test, ErrorFallsWithTheFourthPowerOfTheStep) {
  for (const uint32_t steps : StepsAboveRounding<TypeParam>({10}, {10, 50, 100})) {
    const Convergence measured = MeasureConvergence<TypeParam>(kLaw, steps);
    EXPECT_NEAR(measured.order, 4, 0.05 + measured.rounding) << steps << " steps";
  }
}

// The scheme is not symplectic. Its amplification per step is |R(i z)|^2 = 1 - z^6/72 + z^8/576,
// with z = omega dt.
TYPED_TEST(RungeKutta4Test, EnergyFallsAsTheAmplificationOfTheSchemeSays) {
  const double z = 5 * 0.1;
  const uint32_t steps = 200;
  const double expected = std::pow(1 - std::pow(z, 6) / 72 + std::pow(z, 8) / 576, steps);
  Oscillator<TypeParam> oscillator(kLaw);
  const double begin = oscillator.Energy();
  oscillator.engine.Advance(0.1, steps);
  EXPECT_NEAR(oscillator.Energy() / begin, expected, LargestRoundingOfEnergy<TypeParam>(steps));
}

// The force on a damped body also depends on velocity. The error decreases with the fourth power of
// the number of steps.
TYPED_TEST(RungeKutta4Test, DampedMotionMatchesItsClosedForm) {
  const double gamma = 2.0 / (2 * 4), omega = std::sqrt(25 - gamma * gamma);
  const double exact =
      0.5 * std::exp(-2 * gamma) * (std::cos(2 * omega) + gamma / omega * std::sin(2 * omega));
  for (const uint32_t steps : {80u, 400u}) {
    Oscillator<TypeParam> oscillator(kLaw, 2);
    oscillator.engine.Advance(2.0 / steps, steps);
    EXPECT_NEAR(oscillator.Strain(), exact,
                200 / std::pow(steps, 4) + LargestRounding<TypeParam>(steps))
        << steps << " steps";
  }
}

TYPED_TEST(RungeKutta4Test, ConstantForceGivesTheParabola) {
  Scene<TypeParam> scene;
  scene.AddBody(2, {1, 2, 3}, {3, -1, 0});
  scene.applied_force = {-8, 4, 1};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw(kLaw);
  engine.Advance(0.01, 500);
  EXPECT_NEAR(scene.position[0], 1 + 3 * 5 - 4 * 25 / 2.0, Rounding<TypeParam>(500 * 60));
  EXPECT_NEAR(scene.velocity[1], -1 + 2 * 5, Rounding<TypeParam>(500 * 10));
}

TYPED_TEST(RungeKutta4Test, MassZeroNeverMoves) {
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

TYPED_TEST(RungeKutta4Test, SameBitsForAnyNumberOfThreads) {
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
