// SPDX-License-Identifier: Apache-2.0
#include "oscillator.hpp"

namespace vesper {
namespace {

template <class Real>
class NewtonMotionTest : public ::testing::Test {};
TYPED_TEST_SUITE(NewtonMotionTest, Precisions);

/// Returns x of one body of 2 kg under a constant force, after `steps` steps in `duration`.
template <class Real>
double XUnderConstantForce(double duration, uint32_t steps) {
  Scene<Real> scene;
  scene.AddBody(2, {1, 0, 0}, {3, 0, 0});
  scene.applied_force = {-8, 0, 0};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("newton_motion");
  engine.Advance(duration / steps, steps);
  return scene.position[0];
}

// The sums of the scheme are v(n) = v + n a dt and x(n) = x + n v dt + n (n + 1)/2 a dt^2.
TYPED_TEST(NewtonMotionTest, ConstantForceGivesTheSumsOfTheScheme) {
  Scene<TypeParam> scene;
  scene.AddBody(2, {1, 2, 3}, {3, -1, 0});
  scene.applied_force = {-8, 4, 1};
  const Vec3<double> a{-4, 2, 0.5}, v{3, -1, 0}, x{1, 2, 3};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("newton_motion");
  const double dt = 0.01;
  const int n = 500;
  engine.Advance(dt, n);
  const Vec3<double> v_n = v + a * (n * dt);
  const Vec3<double> x_n = x + v * (n * dt) + a * (n * (n + 1) / 2 * dt * dt);
  const Vec3<double> dv = scene.Wide(scene.At(scene.velocity, 0)) - v_n;
  const Vec3<double> dx = scene.Wide(scene.At(scene.position, 0)) - x_n;
  EXPECT_LT(Length(dv), Rounding<TypeParam>(n * Length(v_n)));
  EXPECT_LT(Length(dx), Rounding<TypeParam>(n * Length(x_n)));
}

TYPED_TEST(NewtonMotionTest, ConvergesToTheParabolaInFirstOrder) {
  const double duration = 4, exact = 1 + 3 * duration - 4 * duration * duration / 2;
  const double coarse = XUnderConstantForce<TypeParam>(duration, 64) - exact;
  const double fine = XUnderConstantForce<TypeParam>(duration, 128) - exact;
  EXPECT_NEAR(coarse, -4 * duration * (duration / 64) / 2, 1e-4);
  EXPECT_NEAR(coarse / fine, 2, 1e-3);
}

TYPED_TEST(NewtonMotionTest, ErrorOfAnOscillationFallsWithTheStep) {
  for (const uint32_t steps : StepsAboveRounding<TypeParam>({50, 100}, {400, 1600})) {
    const Convergence measured = MeasureConvergence<TypeParam>("newton_motion", steps);
    EXPECT_NEAR(measured.order, 1, 2. / steps + measured.rounding) << steps << " steps";
  }
}

TYPED_TEST(NewtonMotionTest, BodyWithoutForceKeepsItsVelocityToTheBit) {
  Scene<TypeParam> scene;
  const auto third = TypeParam{1} / 3;
  scene.AddBody(third, {0, 0, 0}, {third, -third, 7});
  const auto before = scene.velocity;
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("newton_motion");
  engine.Advance(0.1, 1000);
  EXPECT_EQ(scene.velocity, before);
  EXPECT_NEAR(scene.position[2], 700, Rounding<TypeParam>(700 * 1000));
}

TYPED_TEST(NewtonMotionTest, MassZeroNeverMoves) {
  Scene<TypeParam> scene;
  scene.AddBody(0, {1, 2, 3}, {4, 5, 6});
  scene.applied_force = {1e6, -1e6, 1e6};
  const auto position = scene.position, velocity = scene.velocity;
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("newton_motion");
  engine.Advance(0.1, 100);
  EXPECT_EQ(scene.position, position);
  EXPECT_EQ(scene.velocity, velocity);
}

// The test uses more bodies than one vector, all movable or with immovable bodies among them.
TYPED_TEST(NewtonMotionTest, ManyBodiesMoveToTheBitAsEachOneAlone) {
  const uint32_t seed = 17, bodies = 10000;
  for (const uint32_t movable_before : {bodies, 9950u, 64u, 7u}) {
    auto scene = RandomNetwork<TypeParam>(bodies, seed);
    for (uint32_t i = 0; i < bodies; ++i) scene.mass[i] = i % (movable_before + 1) == 7 ? 0 : 1 + i;
    for (uint32_t i = 0; i < 3 * bodies; ++i) scene.applied_force[i] = TypeParam(i % 13) - 6;
    auto expected = scene;
    const TypeParam dt = TypeParam(1) / 16;
    for (uint32_t i = 0; i < 3 * bodies; ++i) {
      if (scene.mass[i / 3] == 0) continue;
      expected.velocity[i] += expected.applied_force[i] * (1 / expected.mass[i / 3]) * dt;
      expected.position[i] += expected.velocity[i] * dt;
    }
    PhysicsEngine engine = scene.MakeEngine(2);
    engine.LoadPhysicsLaw("newton_motion");
    engine.Advance(1.0 / 16);
    EXPECT_EQ(scene.velocity, expected.velocity) << movable_before << ", seed " << seed;
    EXPECT_EQ(scene.position, expected.position) << movable_before << ", seed " << seed;
  }
}

TYPED_TEST(NewtonMotionTest, AccelerationIsForceOverMassAndZeroForMassZero) {
  Scene<TypeParam> scene;
  scene.AddBody(4, {0, 0, 0});
  scene.AddBody(0, {1, 0, 0});
  scene.applied_force = {8, -2, 1, 8, -2, 1};
  std::vector<TypeParam> acceleration(6, 99);
  PhysicsEngine engine = scene.MakeEngine();
  engine.PropertyProvider().AddPhysicalProperty("acceleration", acceleration);
  engine.LoadPhysicsLaw("newton_motion");
  engine.Advance(0.1);
  EXPECT_EQ(acceleration, (std::vector<TypeParam>{2, -0.5, 0.25, 0, 0, 0}));
}

TYPED_TEST(NewtonMotionTest, AccelerationChangesNothingElse) {
  const uint32_t seed = 11;
  auto with = RandomNetwork<TypeParam>(100, seed), without = with;
  std::vector<TypeParam> acceleration(3 * with.mass.size());
  PhysicsEngine engine_with = with.MakeEngine(), engine_without = without.MakeEngine();
  engine_with.PropertyProvider().AddPhysicalProperty("acceleration", acceleration);
  engine_with.LoadPhysicsLaw("newton_motion");
  engine_without.LoadPhysicsLaw("newton_motion");
  engine_with.Advance(0.01, 20);
  engine_without.Advance(0.01, 20);
  EXPECT_EQ(with.position, without.position);
  EXPECT_EQ(with.velocity, without.velocity);
}

}  // namespace
}  // namespace vesper
