// SPDX-License-Identifier: Apache-2.0
#include "scene.hpp"

namespace vesper {
namespace {

template <class Real>
class GravityFieldTest : public ::testing::Test {};
TYPED_TEST_SUITE(GravityFieldTest, Precisions);

TYPED_TEST(GravityFieldTest, WeightIsMassTimesGravity) {
  Scene<TypeParam> scene;
  scene.AddBody(2, {5, 6, 7}, {1, 1, 1});
  scene.AddBody(0.25, {0, 0, 0});
  scene.gravity = {1, -10, 0.5};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("gravity_field");
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{2, -20, 1, 0.25, -2.5, 0.125}));
}

TYPED_TEST(GravityFieldTest, WeightAddsToTheAppliedForce) {
  Scene<TypeParam> scene;
  scene.AddBody(2, {0, 0, 0});
  scene.gravity = {0, -10, 0};
  scene.applied_force = {3, 20, 0};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("gravity_field");
  engine.Advance(0.01, 3);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{3, 0, 0}));
}

TYPED_TEST(GravityFieldTest, HeavyAndLightFallTogether) {
  Scene<TypeParam> scene;
  scene.AddBody(1024, {0, 100, 0});
  scene.AddBody(0.125, {0, 100, 0});
  scene.gravity = {0, TypeParam(-9.81), 0};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("gravity_field");
  engine.LoadPhysicsLaw("newton_motion");
  engine.Advance(0.01, 100);
  EXPECT_EQ(scene.position[1], scene.position[4]);
  EXPECT_LT(scene.position[1], 96);
}

// Semi-implicit Euler follows x(t) = x + v t + g t^2 / 2 + g t dt / 2.
TYPED_TEST(GravityFieldTest, ProjectileFollowsTheParabolaOfTheScheme) {
  Scene<TypeParam> scene;
  scene.AddBody(3, {0, 1, 0}, {12, 20, -5});
  scene.gravity = {0, TypeParam(-9.81), 0};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("newton_motion");
  engine.LoadPhysicsLaw("gravity_field");
  const double dt = 1.0 / 240, t = 480 * dt;
  engine.Advance(dt, 480);
  const double rounding = Rounding<TypeParam>(480 * 24);
  EXPECT_NEAR(scene.position[0], 12 * t, rounding);
  EXPECT_NEAR(scene.position[1], 1 + 20 * t - 9.81 * t * (t + dt) / 2, rounding);
  EXPECT_NEAR(scene.position[2], -5 * t, rounding);
}

// The scheme has an energy error of -m g^2 t dt / 2, of first order in dt.
TYPED_TEST(GravityFieldTest, EnergyErrorOfFreeFallMatchesClosedForm) {
  Scene<TypeParam> scene;
  scene.AddBody(2, {0, 0, 0}, {0, 5, 0});
  scene.gravity = {0, -8, 0};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("newton_motion");
  engine.LoadPhysicsLaw("gravity_field");
  const double dt = 1.0 / 256, t = 512 * dt;
  const auto energy = [&] { return scene.KineticEnergy() + 2 * 8 * double{scene.position[1]}; };
  const double before = energy();
  engine.Advance(dt, 512);
  EXPECT_NEAR(energy() - before, -2 * 8 * 8 * t * dt / 2, Rounding<TypeParam>(512 * before));
}

TYPED_TEST(GravityFieldTest, MassZeroNeitherWeighsNorFalls) {
  Scene<TypeParam> scene;
  scene.AddBody(0, {1, 2, 3});
  scene.gravity = {0, -10, 0};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("gravity_field");
  engine.LoadPhysicsLaw("newton_motion");
  engine.Advance(0.1, 100);
  EXPECT_EQ(scene.position, (std::vector<TypeParam>{1, 2, 3}));
  EXPECT_EQ(scene.external_force[1], 0);
}

TYPED_TEST(GravityFieldTest, GravityEditedBetweenStepsActsFromTheNextOn) {
  Scene<TypeParam> scene;
  scene.AddBody(1, {0, 0, 0});
  scene.gravity = {0, -10, 0};
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("gravity_field");
  engine.Advance(0.1);
  scene.gravity = {0, 0, 4};
  engine.Advance(0.1);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{0, 0, 4}));
}

}  // namespace
}  // namespace vesper
