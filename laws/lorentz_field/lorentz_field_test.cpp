// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "scene.hpp"

namespace vesper {
namespace {

/// Charged bodies and the fields of their world.
template <class Real>
struct ChargedScene : Scene<Real> {
  std::vector<Real> charge;                // (bodies) [C]
  std::vector<Real> electric = {0, 0, 0};  // (1 x 3) [V/m]
  std::vector<Real> magnetic = {0, 0, 0};  // (1 x 3) [T]

  void AddCharge(Real q, Real m, Vec3<Real> at, Vec3<Real> moving) {
    this->AddBody(m, at, moving);
    charge.push_back(q);
  }

  PhysicsEngine MakeChargedEngine(const std::string& integrator) {
    PhysicsEngine engine = this->MakeEngine();
    engine.PropertyProvider().AddPhysicalProperty("charge", charge);
    engine.PropertyProvider().AddPhysicalProperty("electricField", electric);
    engine.PropertyProvider().AddPhysicalProperty("magneticField", magnetic);
    engine.LoadPhysicsLaw("lorentz_field");
    if (!integrator.empty()) engine.LoadPhysicsLaw(integrator);
    return engine;
  }
};

template <class Real>
class LorentzFieldTest : public ::testing::Test {};
TYPED_TEST_SUITE(LorentzFieldTest, Precisions);

TYPED_TEST(LorentzFieldTest, ForceIsChargeTimesFieldAndVelocityCrossFlux) {
  ChargedScene<TypeParam> scene;
  scene.AddCharge(-2, 1, {5, 6, 7}, {1, 2, 4});
  scene.AddCharge(0, 1, {0, 0, 0}, {9, 9, 9});
  scene.electric = {1, -8, 0.5};
  scene.magnetic = {0, 0.5, 3};
  PhysicsEngine engine = scene.MakeChargedEngine("");
  engine.Advance(0.01);
  // The expected values use v x B = (2 * 3 - 4 * 0.5, 4 * 0 - 1 * 3, 1 * 0.5 - 0) = (4, -3, 0.5).
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{-10, 22, -2, 0, 0, 0}));
}

TYPED_TEST(LorentzFieldTest, MassZeroFeelsTheForceAndKeepsItsBits) {
  ChargedScene<TypeParam> scene;
  scene.AddCharge(2, 0, {5, 6, 7}, {1, 2, 4});
  scene.electric = {1, -8, 0.5};
  PhysicsEngine engine = scene.MakeChargedEngine("newton_motion");
  engine.Advance(0.1, 10);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{2, -16, 1}));
  EXPECT_EQ(scene.velocity, (std::vector<TypeParam>{1, 2, 4}));
  EXPECT_EQ(scene.position, (std::vector<TypeParam>{5, 6, 7}));
}

TYPED_TEST(LorentzFieldTest, WorldWithoutFieldsExertsNoForce) {
  ChargedScene<TypeParam> scene;
  scene.AddCharge(1, 1, {0, 0, 0}, {1, 2, 3});
  PhysicsEngine engine = scene.MakeEngine();
  engine.PropertyProvider().AddPhysicalProperty("charge", scene.charge);
  engine.LoadPhysicsLaw("lorentz_field");
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{0, 0, 0}));
}

// The angular speed is omega = |q| B / m = 6 rad/s, and the radius is v / omega = 0.5 m. A negative
// charge rotates in the sense of B.
TYPED_TEST(LorentzFieldTest, ChargeCirclesAtTheCyclotronFrequency) {
  ChargedScene<TypeParam> scene;
  scene.AddCharge(-3, 2, {0.5, 0, 0}, {0, 3, 0.25});
  scene.magnetic = {0, 0, 4};
  PhysicsEngine engine = scene.MakeChargedEngine("runge_kutta4");
  const double omega = 6, turns = 2.25, time = turns * 2 * std::numbers::pi / omega;
  const uint32_t steps = 900;
  engine.Advance(time / steps, steps);
  // Runge-Kutta 4 lags by (omega dt)^4 / 120 of the angle.
  const double angle = turns * 2 * std::numbers::pi, each = angle / steps;
  const double tolerance = angle * std::pow(each, 4) / 60 + Rounding<TypeParam>(steps);
  EXPECT_NEAR(scene.position[0], 0, 0.5 * tolerance);
  EXPECT_NEAR(scene.position[1], 0.5, 0.5 * tolerance);
  EXPECT_NEAR(scene.position[2], 0.25 * time, tolerance);
  EXPECT_NEAR(scene.velocity[0], -3, 3 * tolerance);
  EXPECT_NEAR(scene.velocity[1], 0, 3 * tolerance);
}

// Both charges start at rest. They move along cycloids, which return to the starting line after
// each period.
TYPED_TEST(LorentzFieldTest, CrossedFieldsMakeChargesOfEitherSignDriftAlike) {
  ChargedScene<TypeParam> scene;
  scene.AddCharge(-3, 2, {0, 0, 0}, {});
  scene.AddCharge(3, 2, {0, 0, 0}, {});
  scene.electric = {0, 2, 0};
  scene.magnetic = {0, 0, 4};
  PhysicsEngine engine = scene.MakeChargedEngine("runge_kutta4");
  const double period = 2 * std::numbers::pi / 6, time = 3 * period;
  const uint32_t steps = 1200;
  engine.Advance(time / steps, steps);
  const double tolerance = 1e-8 + Rounding<TypeParam>(steps);
  for (const int body : {0, 1}) {  // drift E x B / B^2 = (2 * 4, 0, 0) / 16
    EXPECT_NEAR(scene.position[3 * body], 0.5 * time, tolerance);
    EXPECT_NEAR(scene.position[3 * body + 1], 0, tolerance);
    EXPECT_EQ(scene.position[3 * body + 2], 0);
  }
}

TYPED_TEST(LorentzFieldTest, SemiImplicitEulerGainsTheFractionThatTheReadmeStates) {
  ChargedScene<TypeParam> scene;
  scene.AddCharge(-3, 2, {0.5, 0, 0}, {0, 3, 0});
  scene.magnetic = {0, 0, 4};
  PhysicsEngine engine = scene.MakeChargedEngine("newton_motion");
  const double dt = 1.0 / 512;
  const double before = scene.KineticEnergy();
  engine.Advance(dt, 100);
  EXPECT_NEAR(scene.KineticEnergy() / before, std::pow(1 + std::pow(6 * dt, 2), 100),
              Rounding<TypeParam>(400));
}

}  // namespace
}  // namespace vesper
