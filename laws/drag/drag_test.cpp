// SPDX-License-Identifier: Apache-2.0
#include "scene.hpp"

namespace vesper {
namespace {

template <class Real>
struct DragScene : Scene<Real> {
  std::vector<Real> linear;     // (bodies) [kg/s]
  std::vector<Real> quadratic;  // (bodies) [kg/m]

  void AddDragged(Real m, Real c1, Real c2, Vec3<Real> moving) {
    this->AddBody(m, {}, moving);
    linear.push_back(c1);
    quadratic.push_back(c2);
  }

  PhysicsEngine MakeDragEngine(const std::vector<std::string>& more_laws = {}) {
    PhysicsEngine engine = this->MakeEngine();
    engine.PropertyProvider().AddPhysicalProperty("linearDragCoefficient", linear);
    engine.PropertyProvider().AddPhysicalProperty("dragCoefficient", quadratic);
    engine.LoadPhysicsLaw("drag");
    for (const std::string& law : more_laws) engine.LoadPhysicsLaw(law);
    return engine;
  }
};

template <class Real>
class DragTest : public ::testing::Test {};
TYPED_TEST_SUITE(DragTest, Precisions);

TYPED_TEST(DragTest, ForceOpposesVelocity) {
  DragScene<TypeParam> scene;
  scene.AddDragged(1, 2, 0, {1, -2, 3});
  scene.AddDragged(1, 0, 0.5, {3, 0, -4});
  scene.AddDragged(0, 2, 0.5, {0, 2, 0});
  PhysicsEngine engine = scene.MakeDragEngine();
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{-2, 4, -6, -7.5, 0, 10, 0, -6, 0}));
}

TYPED_TEST(DragTest, MassZeroFeelsTheForceAndKeepsItsBits) {
  DragScene<TypeParam> scene;
  scene.AddDragged(0, 2, 0.5, {0, 2, 0});
  PhysicsEngine engine = scene.MakeDragEngine({"newton_motion"});
  engine.Advance(0.1, 10);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{0, -6, 0}));
  EXPECT_EQ(scene.velocity, (std::vector<TypeParam>{0, 2, 0}));
  EXPECT_EQ(scene.position, (std::vector<TypeParam>{0, 0, 0}));
}

TYPED_TEST(DragTest, EitherCoefficientMayBeAbsent) {
  DragScene<TypeParam> scene;
  scene.AddDragged(1, 2, 0.5, {3, 0, -4});
  PhysicsEngine engine = scene.MakeDragEngine();
  engine.PropertyProvider().RemovePhysicalProperty("dragCoefficient");
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{-6, 0, 8}));
  engine.PropertyProvider().RemovePhysicalProperty("linearDragCoefficient");
  engine.PropertyProvider().AddPhysicalProperty("dragCoefficient", scene.quadratic);
  engine.Advance(0.01);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{-7.5, 0, 10}));
}

// The scheme is stationary where drag and weight balance. Its terminal speed is exact except for
// the rounding of the steps in which the initial error decays (32 and 64 steps).
TYPED_TEST(DragTest, FallingBodiesReachTheirTerminalSpeed) {
  DragScene<TypeParam> scene;
  scene.AddDragged(3, 12, 0, {});
  scene.AddDragged(2, 0, 0.2, {});
  scene.gravity = {0, -10, 0};
  PhysicsEngine engine = scene.MakeDragEngine({"gravity_field", "newton_motion"});
  engine.Advance(1.0 / 128, 128 * 40);
  EXPECT_NEAR(scene.velocity[1], -2.5, Rounding<TypeParam>(32 * 2.5));
  EXPECT_NEAR(scene.velocity[4], -10, Rounding<TypeParam>(64 * 10));
}

// Semi-implicit Euler sums v0 q dt (1 + q + q^2 + ...) with q = 1 - c dt / m.
TYPED_TEST(DragTest, LinearDragStopsABodyAfterTheDistanceOfTheScheme) {
  DragScene<TypeParam> scene;
  scene.AddDragged(2, 3, 0, {4, 0, 0});
  PhysicsEngine engine = scene.MakeDragEngine({"newton_motion"});
  const double dt = 1.0 / 64;
  engine.Advance(dt, 64 * 30);
  EXPECT_NEAR(scene.position[0], 2 * 4 / 3.0 - 4 * dt, Rounding<TypeParam>(64 * 30));
}

TYPED_TEST(DragTest, StoppingDistanceConvergesToTheClosedForm) {
  DragScene<TypeParam> scene;
  scene.AddDragged(2, 3, 0, {4, 0, 0});
  PhysicsEngine engine = scene.MakeDragEngine({"runge_kutta4"});
  engine.Advance(1.0 / 64, 64 * 30);
  EXPECT_NEAR(scene.position[0], 2 * 4 / 3.0, 1e-7 + Rounding<TypeParam>(64 * 30));
}

TYPED_TEST(DragTest, QuadraticDragLetsABodyCoastByTheLogarithm) {
  DragScene<TypeParam> scene;
  scene.AddDragged(2, 0, 0.5, {8, 0, 0});
  PhysicsEngine engine = scene.MakeDragEngine({"runge_kutta4"});
  const double time = 5;
  engine.Advance(1.0 / 128, 128 * 5);
  const double tolerance = 1e-7 + Rounding<TypeParam>(128 * 5 * 8);
  EXPECT_NEAR(scene.position[0], 4 * std::log1p(0.5 * 8 * time / 2), tolerance);
  EXPECT_NEAR(scene.velocity[0], 8 / (1 + 0.5 * 8 * time / 2), tolerance);
}

}  // namespace
}  // namespace vesper
