// SPDX-License-Identifier: Apache-2.0
// Torques against rolling and against spin about the normal of a contact.
#include <algorithm>
#include <cmath>

#include "rigid_scene.hpp"

namespace vesper {
namespace {

using rigid::ShapeCode;
using Vector = Vec3<double>;

constexpr double kFrame = 1.0 / 60, kG = 9.81;

template <class Real>
class RigidRollingTest : public ::testing::Test {};
TYPED_TEST_SUITE(RigidRollingTest, Precisions);

/// Returns a scene with gravity and a ground.
template <class Real>
RigidScene<Real> Ground() {
  RigidScene<Real> scene;
  scene.gravity = {0, Real(-kG), 0};
  scene.AddGround();
  return scene;
}

/// Adds a ball of radius 0.25 m and 2 kg at rest on the ground, which spins about the vertical.
template <class Real>
uint32_t AddSpinningBall(RigidScene<Real>& scene, double speed, Vector at = {0, 0.25, 0}) {
  const uint32_t ball = scene.AddBall(0.25, 2, at);
  scene.spin[3 * ball + 1] = Real(speed);
  return ball;
}

// The torque s m g slows a ball with the moment of inertia 2/5 m r^2 by 5 s g / (2 r^2). The ball
// stops after the time w / (5 s g / (2 r^2)), and stays at rest.
TYPED_TEST(RigidRollingTest, SpinningBallStopsAfterTheTimeOfTheClosedForm) {
  for (const double arm : {0.004, 0.02}) {
    RigidScene<TypeParam> scene = Ground<TypeParam>();
    AddSpinningBall(scene, 6);
    PhysicsEngine engine = scene.MakeRigidEngine({{"spinFriction", arm}});
    const double slowing = 5 * arm * kG / (2 * 0.25 * 0.25);
    const int frames = static_cast<int>(6 / slowing / kFrame);
    int stopped = 0;
    for (int i = 1; i < frames + 60; ++i) {
      engine.Advance(kFrame);
      const double expected = std::max(0.0, 6 - slowing * i * kFrame);
      ASSERT_NEAR(scene.Spin(0).y, expected, 0.01 * 6) << "arm " << arm << ", frame " << i;
      if (stopped == 0 && std::abs(scene.Spin(0).y) < 1e-4) stopped = i;
    }
    EXPECT_NEAR(stopped, frames + 1, 2 + 0.01 * frames) << arm;
    EXPECT_LT(Length(scene.Position(0) - Vector{0, 0.25, 0}), 1e-3) << "it spins on the spot";
    EXPECT_LT(Length(scene.Spin(0)), 1e-4);
  }
}

TYPED_TEST(RigidRollingTest, SpinningBallDoesNotStopWithoutThisFriction) {
  RigidScene<TypeParam> scene = Ground<TypeParam>();
  AddSpinningBall(scene, 6);
  PhysicsEngine engine = scene.MakeRigidEngine({{"rollingFriction", 0.05}});
  engine.Advance(kFrame, 600);
  EXPECT_NEAR(scene.Spin(0).y, 6, 1e-3);
}

// A ball that rolls at the speed v slows by a = 5/7 b g / r, and stops after the way v^2 / (2 a).
TYPED_TEST(RigidRollingTest, RollingBallStopsAfterTheWayOfTheClosedForm) {
  for (const double arm : {0.005, 0.02}) {
    RigidScene<TypeParam> scene = Ground<TypeParam>();
    scene.AddBall(0.25, 2, {0, 0.25, 0}, {2, 0, 0});
    scene.spin = {0, 0, -8};
    PhysicsEngine engine = scene.MakeRigidEngine({{"rollingFriction", arm}});
    const double slowing = 5.0 / 7 * arm * kG / 0.25;
    engine.Advance(kFrame, static_cast<uint32_t>(2 / slowing / kFrame) + 60);
    EXPECT_NEAR(scene.Position(0).x, 2 * 2 / (2 * slowing), 0.02 * 2 * 2 / (2 * slowing)) << arm;
    EXPECT_LT(Length(scene.Velocity(0)), 1e-3);
    EXPECT_LT(Length(scene.Spin(0)), 5e-3);
  }
}

// A disc on a smooth ground, whose moment about its axis is m r^2 / 2, slows by 2 s g / r^2.
TYPED_TEST(RigidRollingTest, TopOnASmoothGroundSlowsAsTheClosedFormSays) {
  RigidScene<TypeParam> scene = Ground<TypeParam>();
  scene.Add(ShapeCode::kCylinder, {0.4, 0.1, 0.4}, 3, {0, 0.05, 0});
  scene.spin = {0, 20, 0};
  PhysicsEngine engine = scene.MakeRigidEngine({{"friction", 0}, {"spinFriction", 0.01}});
  const double slowing = 2 * 0.01 * kG / (0.2 * 0.2);
  engine.Advance(kFrame, 120);
  EXPECT_NEAR(scene.Spin(0).y, 20 - 2 * slowing, 0.01 * 20);
  engine.Advance(kFrame, static_cast<uint32_t>((20 / slowing - 2) / kFrame) + 30);
  EXPECT_LT(Length(scene.Spin(0)), 1e-3);
  EXPECT_LT(Length(scene.Position(0) - Vector{0, 0.05, 0}), 2e-3);
}

// The two torques have limits of their own: a ball that rolls and spins slows in both motions.
TYPED_TEST(RigidRollingTest, BallThatRollsAndSpinsSlowsInBothMotions) {
  RigidScene<TypeParam> scene = Ground<TypeParam>();
  scene.AddBall(0.25, 2, {0, 0.25, 0}, {2, 0, 0});
  scene.spin = {0, 9, -8};
  PhysicsEngine engine =
      scene.MakeRigidEngine({{"rollingFriction", 0.01}, {"spinFriction", 0.005}});
  engine.Advance(kFrame, 120);
  EXPECT_NEAR(scene.Velocity(0).x, 2 - 2 * 5.0 / 7 * 0.01 * kG / 0.25, 0.01);
  EXPECT_NEAR(scene.Spin(0).z, -scene.Velocity(0).x / 0.25, 0.02);
  EXPECT_NEAR(scene.Spin(0).y, 9 - 2 * 5 * 0.005 * kG / (2 * 0.0625), 0.06);
}

// Only the contact of ball and plate exerts a torque about the vertical, so the angular momentum of
// both is constant, and both end with the same speed.
TYPED_TEST(RigidRollingTest, SpinFrictionOfTwoBodiesKeepsTheirAngularMomentum) {
  RigidScene<TypeParam> scene = Ground<TypeParam>();
  scene.has_spinning = true;
  const uint32_t plate = scene.Add(ShapeCode::kCylinder, {0.8, 0.1, 0.8}, 1, {0, 0.05, 0});
  const uint32_t ball = AddSpinningBall(scene, 12, {0, 0.35, 0});
  scene.spinning[ball] = TypeParam(0.02);
  PhysicsEngine engine = scene.MakeRigidEngine({{"friction", 0}});
  const double of_ball = 0.4 * 2 * 0.0625, of_plate = 0.5 * 1 * 0.16;
  for (int i = 0; i < 12; ++i) {
    engine.Advance(kFrame, 10);
    ASSERT_NEAR(of_ball * scene.Spin(ball).y + of_plate * scene.Spin(plate).y, of_ball * 12,
                1e-3 * of_ball * 12)
        << i;
  }
  EXPECT_NEAR(scene.Spin(ball).y, of_ball * 12 / (of_ball + of_plate), 0.01);
  EXPECT_NEAR(scene.Spin(plate).y, scene.Spin(ball).y, 1e-3);
}

// Of the two bodies of a contact, the larger lever arm counts. The parameter counts for scenery.
TYPED_TEST(RigidRollingTest, LargerSpinFrictionOfTwoBodiesCounts) {
  struct Case {
    double ball, parameter, expected;
  };
  for (const Case& one : {Case{0, 0.01, 0.01}, Case{0.01, 0.002, 0.01}, Case{0, 0, 0}}) {
    RigidScene<TypeParam> scene = Ground<TypeParam>();
    scene.has_spinning = true;
    scene.spinning[AddSpinningBall(scene, 20)] = TypeParam(one.ball);
    PhysicsEngine engine = scene.MakeRigidEngine({{"spinFriction", one.parameter}});
    engine.Advance(kFrame, 60);
    EXPECT_NEAR(scene.Spin(0).y, 20 - 5 * one.expected * kG / (2 * 0.0625), 0.01 * 20)
        << one.ball << " " << one.parameter;
  }
}

/// Returns balls, boxes and cylinders that fall on the ground and on each other.
template <class Real>
RigidScene<Real> Heap(int count) {
  std::mt19937 random(11);
  const auto draw = [&](double size) { return size * (random() / 4294967296.0 - 0.5); };
  RigidScene<Real> scene = Ground<Real>();
  for (int i = 0; i < count; ++i) {
    const Vector at{1.2 * (i % 4) + draw(0.3), 0.8 + 1.1 * (i / 16), 1.2 * (i / 4 % 4) + draw(0.3)};
    const double mass = 1 + i % 2;
    const uint32_t body = i % 2 == 0   ? scene.AddBall(0.4, mass, at)
                          : i % 4 == 1 ? scene.AddBox({0.9, 0.6, 0.8}, mass, at)
                                       : scene.Add(ShapeCode::kCylinder, {0.8, 0.5, 0.8}, mass, at);
    for (int k = 0; k < 3; ++k) scene.spin[3 * body + k] = Real(draw(12));
  }
  return scene;
}

TYPED_TEST(RigidRollingTest, FrictionOfZeroGivesTheBitsOfNoFriction) {
  RigidScene<TypeParam> plain = Heap<TypeParam>(32), zero = plain;
  zero.has_rolling = zero.has_spinning = true;
  PhysicsEngine first = plain.MakeRigidEngine(), second = zero.MakeRigidEngine();
  first.Advance(kFrame, 90);
  second.Advance(kFrame, 90);
  EXPECT_EQ(plain.position, zero.position);
  EXPECT_EQ(plain.spin, zero.spin);
}

TYPED_TEST(RigidRollingTest, BitsDoNotDependOnThreads) {
  RigidScene<TypeParam> one = Heap<TypeParam>(256), two = one;
  const std::vector<ParameterValue> parameters = {{"rollingFriction", 0.01},
                                                  {"spinFriction", 0.01}};
  PhysicsEngine alone = one.MakeRigidEngine(parameters);
  PhysicsEngine together = two.MakeRigidEngine(parameters, 4);
  alone.Advance(kFrame, 60);
  together.Advance(kFrame, 60);
  EXPECT_EQ(one.position, two.position);
  EXPECT_EQ(one.spin, two.spin);
}

TYPED_TEST(RigidRollingTest, TorquesOfContactsAddNoEnergy) {
  RigidScene<TypeParam> scene = Heap<TypeParam>(48);
  PhysicsEngine engine = scene.MakeRigidEngine({{"rollingFriction", 0.02}, {"spinFriction", 0.02}});
  double energy = scene.TotalKineticEnergy() + scene.HeightEnergy();
  for (int i = 0; i < 240; ++i) {
    engine.Advance(kFrame);
    const double now = scene.TotalKineticEnergy() + scene.HeightEnergy();
    ASSERT_LT(now, energy + 1e-3 * std::abs(energy)) << i;
    energy = now;
  }
}

// A heap with balls comes to rest only if nothing rolls or spins for ever.
TYPED_TEST(RigidRollingTest, HeapWithBallsFallsAsleep) {
  RigidScene<TypeParam> scene = Heap<TypeParam>(48), smooth = scene;
  const auto asleep = [](const auto& of) {
    return std::count(of.asleep.begin(), of.asleep.end(), 1);
  };
  for (auto* one : {&scene, &smooth}) one->asleep.assign(one->mass.size(), 0);
  PhysicsEngine engine = scene.MakeRigidEngine(
      {{"sleepTime", 0.5}, {"rollingFriction", 0.02}, {"spinFriction", 0.02}});
  PhysicsEngine other = smooth.MakeRigidEngine({{"sleepTime", 0.5}});
  engine.Advance(kFrame, 1200);
  other.Advance(kFrame, 1200);
  EXPECT_EQ(asleep(scene), 48);
  EXPECT_LT(asleep(smooth), 48) << "balls roll and spin on";
}

// A body's own lever arm precedes that of the pair of substances, which precedes those of the two
// substances, which precede the parameter 0.02 of the law.
TYPED_TEST(RigidRollingTest, SpinFrictionOfSubstancesHasItsPlaceInTheOrder) {
  struct Case {
    const char* name;
    double own, pair, first, second, expected;
  };
  const Case cases[] = {
      {"own", 0.016, 0.01, 0.006, 0.006, 0.016}, {"own zero", 1e-12, 0.01, 0.006, 0.003, 0.003},
      {"pair", 0, 0.01, 0.006, 0.012, 0.01},     {"pair of zero", 0, 1e-12, 0.006, 0.012, 0},
      {"substances", 0, 0, 0.006, 0.003, 0.006}, {"parameter", 0, 0, 0.006, 0, 0.02}};
  for (const Case& one : cases) {
    RigidScene<TypeParam> scene;
    scene.gravity = {0, TypeParam(-kG), 0};
    const uint32_t ball = AddSpinningBall(scene, 20);
    scene.AddBox({20, 2, 20}, 0, {0, -1, 0});
    scene.has_spinning = true;
    scene.spinning[ball] = TypeParam(one.own);
    scene.substance = {1, 2};
    scene.AddSubstances(1, 0, 0, 0);
    scene.AddSubstances(2, 0, 0, 0);
    scene.AddSubstances(1, 2, 0, 0);
    scene.pair_spinning = {TypeParam(one.first), TypeParam(one.second), TypeParam(one.pair)};
    PhysicsEngine engine = scene.MakeRigidEngine({{"spinFriction", 0.02}});
    engine.Advance(kFrame, 60);
    EXPECT_NEAR(scene.Spin(ball).y, 20 - 5 * one.expected * kG / (2 * 0.0625), 0.01 * 20)
        << one.name;
  }
}

// A tyre on a soft ground: the lever arm of the pair slows it by 5/7 b g / r.
TYPED_TEST(RigidRollingTest, RollingFrictionOfAPairIsMeasuredBack) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  const uint32_t ball = scene.AddBall(0.25, 2, {0, 0.25, 0}, {2, 0, 0});
  scene.spin = {0, 0, -8};
  scene.AddBox({20, 2, 20}, 0, {0, -1, 0});
  scene.substance = {7, 3};
  scene.AddSubstances(3, 7, 0.5, 0);
  scene.pair_rolling = {TypeParam(0.012)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 30);
  const double before = scene.Velocity(ball).x;
  engine.Advance(kFrame, 60);
  const double expected = 5.0 / 7 * 0.012 * kG / 0.25;
  EXPECT_NEAR(before - scene.Velocity(ball).x, expected, 0.02 * expected);
}

}  // namespace
}  // namespace vesper
