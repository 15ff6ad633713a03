// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "rigid_scene.hpp"

namespace vesper {
namespace {

using rigid::Quaternion;
using rigid::ShapeCode;
using Vector = Vec3<double>;

constexpr double kFrame = 1.0 / 60, kG = 9.81;

template <class Real>
class RigidContactTest : public ::testing::Test {};
TYPED_TEST_SUITE(RigidContactTest, Precisions);

/// Returns the rotation by an angle about an axis of length 1.
Quaternion About(Vector axis, double angle) {
  return {axis * std::sin(angle / 2), std::cos(angle / 2)};
}

TYPED_TEST(RigidContactTest, EveryShapeRestsOnTheGround) {
  const std::pair<ShapeCode, Vector> shapes[] = {{ShapeCode::kBox, {1, 0.5, 2}},
                                                 {ShapeCode::kSphere, {1, 1, 1}},
                                                 {ShapeCode::kCylinder, {1, 0.5, 1}},
                                                 {ShapeCode::kCapsule, {0.5, 2, 0.5}},
                                                 {ShapeCode::kEllipsoid, {1, 0.5, 0.8}}};
  for (const auto& [code, size] : shapes) {
    for (const bool plane : {false, true}) {
      RigidScene<TypeParam> scene;
      scene.gravity = {0, TypeParam(-kG), 0};
      // The capsule lies on its side, because it would stand on its cap in unstable equilibrium.
      const bool lies = code == ShapeCode::kCapsule;
      const double height = lies ? size.x / 2 : size.y / 2;
      scene.Add(code, size, 3, {0, height + 0.1, 0}, {},
                lies ? About({0, 0, 1}, std::acos(0.0)) : Quaternion{});
      if (plane) {
        scene.AddScenery(ShapeCode::kPlane, {20, 0, 20}, {0, 0, 0});
      } else {
        scene.AddGround();
      }
      PhysicsEngine engine = scene.MakeRigidEngine();
      engine.Advance(kFrame, 300);
      SCOPED_TRACE(testing::Message() << "shape " << int(code) << ", plane " << plane);
      EXPECT_NEAR(scene.Position(0).y, height, 2e-3);
      EXPECT_LT(Length(scene.Velocity(0)), 1e-3);
      EXPECT_LT(Length(scene.Spin(0)), 5e-3);
    }
  }
}

// A body that lies on a side with the radius of curvature R, and whose centre is at the height b,
// rocks without sliding at the frequency sqrt(m g (R - b) / (I + m b^2)). An ellipsoid of the half
// axes a, b and a has R = a^2 / b and I = m (a^2 + b^2) / 5.
TYPED_TEST(RigidContactTest, EllipsoidRocksWithThePeriodOfTheClosedForm) {
  const double a = 0.3, b = 0.15, tilt = 0.02;
  for (const int ground : {0, 1, 2}) {
    RigidScene<TypeParam> scene;
    scene.gravity = {0, TypeParam(-kG), 0};
    const double height = std::hypot(a * std::sin(tilt), b * std::cos(tilt));
    scene.Add(ShapeCode::kEllipsoid, {2 * a, 2 * b, 2 * a}, 2, {0, height, 0}, {},
              About({0, 0, 1}, tilt));
    if (ground == 0) scene.AddGround();
    if (ground == 1) scene.AddScenery(ShapeCode::kPlane, {20, 0, 20}, {0, 0, 0});
    if (ground == 2) scene.AddTerrain(20, 6, [](double, double) { return 0.0; });
    PhysicsEngine engine = scene.MakeRigidEngine({{"friction", 5}});
    const double dt = 1.0 / 480;
    double last = tilt, first_crossing = 0, last_crossing = 0;
    int crossings = 0;
    for (int i = 1; i <= 1800; ++i) {
      engine.Advance(dt, 1);
      const double angle = 2 * scene.Rotation(0).v.z;
      if ((angle < 0) != (last < 0)) {
        last_crossing = (i - angle / (angle - last)) * dt;
        if (crossings++ == 0) first_crossing = last_crossing;
      }
      last = angle;
    }
    SCOPED_TRACE(testing::Message() << "ground " << ground);
    ASSERT_GT(crossings, 6);
    const double period = 2 * (last_crossing - first_crossing) / (crossings - 1);
    const double inertia = (a * a + b * b) / 5 + b * b;
    const double expected = 2 * std::acos(-1.0) * std::sqrt(inertia / (kG * (a * a / b - b)));
    EXPECT_NEAR(period, expected, 0.02 * expected);
  }
}

TYPED_TEST(RigidContactTest, ContactForcesOfAStackAreItsWeights) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddBox({4, 1, 4}, 0, {0, -0.5, 0});
  for (int i = 0; i < 3; ++i) scene.AddBox({1, 1, 1}, 2, {0, 0.5 + i, 0});
  scene.AddBox({1, 1, 1}, 5, {0, 50, 0});
  scene.reaction.assign(scene.position.size(), 7);
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 120);
  // The immovable ground bears the stack. The net force on each box is its own weight.
  const double expected[] = {-6 * kG, 2 * kG, 2 * kG, 2 * kG, 0};
  for (uint32_t i = 0; i < 5; ++i) {
    const Vector force = scene.Wide(scene.At(scene.reaction, i));
    EXPECT_NEAR(force.y, expected[i], 1e-3 * 6 * kG) << i;
    EXPECT_NEAR(force.x, 0, 1e-3 * 6 * kG) << i;
    EXPECT_NEAR(force.z, 0, 1e-3 * 6 * kG) << i;
  }
}

// The contact force is the change of momentum that gravity does not explain. This is also true for
// an impact with friction and restitution.
TYPED_TEST(RigidContactTest, ContactForcesExplainTheChangeOfMomentumInABounce) {
  for (const double restitution : {0.0, 0.7}) {
    RigidScene<TypeParam> scene;
    scene.gravity = {0, TypeParam(-kG), 0};
    scene.AddGround();
    scene.Add(ShapeCode::kSphere, {1, 1, 1}, 3, {0, 1.2, 0}, {2, -1, 0.5});
    scene.reaction.assign(scene.position.size(), 0);
    PhysicsEngine engine = scene.MakeRigidEngine({{"restitution", restitution}});
    double largest = 0;
    for (int step = 0; step < 90; ++step) {
      const Vector before = scene.Velocity(0);
      engine.Advance(kFrame, 1);
      const Vector force = scene.Wide(scene.At(scene.reaction, 0));
      const Vector expected = (scene.Velocity(0) - before) * (3 / kFrame) + Vector{0, 3 * kG, 0};
      EXPECT_NEAR(Length(force - expected), 0, 2e-4 * (Length(expected) + 3 * kG)) << step;
      largest = std::max(largest, Length(force));
    }
    EXPECT_GT(largest, 10 * 3 * kG) << "the impact";
  }
}

TYPED_TEST(RigidContactTest, StackOfFiveBoxesStands) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddGround();
  for (int i = 0; i < 5; ++i) scene.AddBox({1, 1, 1}, 2, {0, 0.5 + i, 0});
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 600);
  for (uint32_t i = 0; i < 5; ++i) {
    EXPECT_LT(Length(scene.Position(i) - Vector{0, 0.5 + i, 0}), 0.01) << i;
    EXPECT_LT(Length(scene.Velocity(i)), 1e-3) << i;
  }
}

// A solid ball that rolls without slipping has 5/7 of the acceleration of one that slides.
TYPED_TEST(RigidContactTest, BallRollsDownASlopeAsTheClosedFormSays) {
  const double angle = 0.3;
  RigidScene<TypeParam> scene;
  scene.gravity = {TypeParam(kG * std::sin(angle)), TypeParam(-kG * std::cos(angle)), 0};
  scene.AddGround();
  scene.AddBall(0.5, 3, {0, 0.5, 0});
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 120);
  EXPECT_NEAR(scene.Velocity(0).x, 2 * 5.0 / 7 * kG * std::sin(angle), 0.01);
  EXPECT_NEAR(scene.Spin(0).z, -scene.Velocity(0).x / 0.5, 0.02);
}

TYPED_TEST(RigidContactTest, FrictionIsMeasuredBackFromASlidingBox) {
  for (const double friction : {0.0, 0.1, 0.5, 0.9}) {
    const double angle = 0.9;  // steep enough to slide
    RigidScene<TypeParam> scene;
    scene.gravity = {TypeParam(kG * std::sin(angle)), TypeParam(-kG * std::cos(angle)), 0};
    scene.AddGround();
    scene.AddBox({2, 0.4, 2}, 3, {0, 0.2, 0});
    PhysicsEngine engine = scene.MakeRigidEngine({{"friction", friction}});
    engine.Advance(kFrame, 60);
    const double v = scene.Velocity(0).x;
    engine.Advance(kFrame, 60);
    const double a = scene.Velocity(0).x - v;
    EXPECT_NEAR((kG * std::sin(angle) - a) / (kG * std::cos(angle)), friction,
                0.02 * friction + 1e-3);
  }
}

TYPED_TEST(RigidContactTest, BoxStaysOnASlopeBelowTheAngleOfFriction) {
  const double angle = 0.4;  // tan: 0.423
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  const Quaternion slope = About({0, 0, 1}, -angle);
  scene.AddScenery(ShapeCode::kBox, {100, 2, 100}, slope.Rotate({0, -1, 0}), slope);
  scene.AddBox({1, 1, 1}, 3, slope.Rotate({0, 0.5, 0}), {}, slope);
  PhysicsEngine engine = scene.MakeRigidEngine({{"friction", 0.5}});
  engine.Advance(kFrame, 60);
  const Vector at = scene.Position(0);
  engine.Advance(kFrame, 600);
  EXPECT_LT(Length(scene.Position(0) - at), 1e-3);
}

TYPED_TEST(RigidContactTest, BallsCollideHeadOnAsMomentumAndRestitutionSay) {
  for (const double e : {0.0, 0.3, 0.8, 1.0}) {
    RigidScene<TypeParam> scene;
    scene.AddBall(0.5, 1, {-2, 0, 0}, {3, 0, 0});
    scene.AddBall(0.5, 4, {2, 0, 0}, {-1, 0, 0});
    PhysicsEngine engine = scene.MakeRigidEngine({{"restitution", e}});
    engine.Advance(kFrame, 120);
    const double common = (3 - 4.0) / 5;  // of the centre of mass
    EXPECT_NEAR(scene.Velocity(0).x, common - e * 4 * 4 / 5, 1e-4) << e;
    EXPECT_NEAR(scene.Velocity(1).x, common + e * 1 * 4 / 5, 1e-4) << e;
  }
}

TYPED_TEST(RigidContactTest, RestitutionIsMeasuredBackFromBounces) {
  for (const double e : {0.5, 0.7, 0.9, 1.0}) {
    RigidScene<TypeParam> scene;
    scene.gravity = {0, TypeParam(-kG), 0};
    scene.AddGround();
    scene.AddBall(0.1, 1, {0, 2.1, 0});
    PhysicsEngine engine = scene.MakeRigidEngine({{"restitution", e}, {"restitutionSpeed", 0.2}});
    double top = 0;
    bool bounced = false;
    for (int i = 0; i < 240 && !(bounced && scene.Velocity(0).y < 0); ++i) {
      engine.Advance(kFrame);
      bounced = bounced || scene.Velocity(0).y > 0;
      if (bounced) top = std::max(top, scene.Position(0).y - 0.1);
    }
    EXPECT_NEAR(std::sqrt(top / 2), e, 0.02 * e);
  }
}

TYPED_TEST(RigidContactTest, FreeBodyKeepsItsAngularMomentumAndEnergy) {
  RigidScene<TypeParam> scene;
  scene.AddBox({1, 2, 3}, 2, {0, 0, 0}, {1, 2, 3});
  scene.spin = {TypeParam(0.1), 5, TypeParam(0.1)};  // about the middle axis, so the body flips
  const Vector before = scene.OwnMomentum(0);
  const double energy = scene.TotalKineticEnergy();
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 600);
  EXPECT_LT(Length(scene.OwnMomentum(0) - before), Rounding<TypeParam>(1e5));
  EXPECT_NEAR(scene.TotalKineticEnergy() / energy, 1, 1e-3);
  EXPECT_LT(Length(scene.Position(0) - Vector{10, 20, 30}), Rounding<TypeParam>(1e4));
}

// The bodies of a heap overlap at first. They may be pushed apart at most with the speed pushSpeed.
TYPED_TEST(RigidContactTest, OverlapsAreUndoneAtABoundedSpeed) {
  for (const double depth : {0.05, 0.5, 0.99}) {
    RigidScene<TypeParam> scene;
    scene.AddBox({1, 1, 1}, 2, {0, 0, 0});
    scene.AddBox({1, 1, 1}, 3, {0.1, 1 - depth, 0.05});
    PhysicsEngine engine = scene.MakeRigidEngine({{"pushSpeed", 2}});
    double fastest = 0;
    Vector before = scene.Position(1) - scene.Position(0);
    for (int i = 0; i < 240; ++i) {
      engine.Advance(kFrame);
      const Vector now = scene.Position(1) - scene.Position(0);
      fastest = std::max(fastest, Length(now - before) / kFrame);
      before = now;
      // The bodies do not keep the speed of the push. They would have 2.4 J with this speed.
      EXPECT_LT(scene.TotalKineticEnergy(), 0.1) << depth;
    }
    EXPECT_LT(fastest, 2.1);
    EXPECT_GT(std::max({std::abs(before.x), std::abs(before.y), std::abs(before.z)}), 0.98)
        << depth;
  }
}

/// Returns bodies of all shapes that fly into each other.
template <class Real>
RigidScene<Real> Swarm(uint32_t seed, int count) {
  std::mt19937 random(seed);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * random() / 4294967296.0;
  };
  RigidScene<Real> scene;
  const ShapeCode codes[] = {ShapeCode::kSphere, ShapeCode::kBox, ShapeCode::kCapsule,
                             ShapeCode::kCylinder};
  for (int i = 0; i < count; ++i) {
    const ShapeCode code = codes[random() % 4];
    const double across = draw(0.3, 0.8);
    Vector size{across, draw(0.8, 1.5), across};
    if (code == ShapeCode::kSphere) size = {across, across, across};
    if (code == ShapeCode::kBox) size.z = draw(0.3, 1);
    const Vector at{2.0 * (i % 4) - 3, 2.0 * (i / 4 % 4) - 3, 2.0 * (i / 16) - 3};
    const Quaternion q =
        Quaternion{{draw(-1, 1), draw(-1, 1), draw(-1, 1)}, draw(-1, 1)}.Normalised();
    const uint32_t body = scene.Add(code, size, draw(1, 3), at, at * -draw(0.5, 1.5), q);
    for (int k = 0; k < 3; ++k) scene.spin[3 * body + k] = Real(draw(-3, 3));
  }
  return scene;
}

TYPED_TEST(RigidContactTest, SwarmKeepsMomentumAndGainsNoEnergy) {
  for (const uint32_t seed : {1u, 2u, 3u}) {
    RigidScene<TypeParam> scene = Swarm<TypeParam>(seed, 64);
    PhysicsEngine engine = scene.MakeRigidEngine();
    const Vector momentum = scene.Momentum(), angular = scene.TotalAngularMomentum();
    const double begin = scene.TotalKineticEnergy();
    double energy = begin;
    for (int i = 0; i < 120; ++i) {
      engine.Advance(kFrame);
      EXPECT_LT(scene.TotalKineticEnergy(), energy * 1.001) << "frame " << i << ", seed " << seed;
      energy = scene.TotalKineticEnergy();
    }
    EXPECT_LT(energy, 0.7 * begin) << "they have not met";
    EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(1e5));
    EXPECT_LT(Length(scene.TotalAngularMomentum() - angular), 0.01 * begin);
  }
}

TYPED_TEST(RigidContactTest, BitsDoNotDependOnThreads) {
  RigidScene<TypeParam> one = Swarm<TypeParam>(5, 512), two = one;
  one.gravity = two.gravity = {0, TypeParam(-kG), 0};
  one.AddGround();
  two.AddGround();
  PhysicsEngine alone = one.MakeRigidEngine(), together = two.MakeRigidEngine({}, 4);
  alone.Advance(kFrame, 60);
  together.Advance(kFrame, 60);
  EXPECT_EQ(one.position, two.position);
  EXPECT_EQ(one.spin, two.spin);
}

/// Returns a scene of a block (row 0) on a slope (row 1) that rises by an angle [rad]. The block
/// and the slope are of the substances 1 and 2.
template <class Real>
RigidScene<Real> BlockOnASlope(double angle) {
  RigidScene<Real> scene;
  scene.gravity = {0, Real(-kG), 0};
  const Quaternion slope = About({0, 0, 1}, -angle);
  scene.AddBox({1, 0.4, 1}, 3, slope.Rotate({0, 0.2, 0}), {}, slope);
  scene.AddBox({200, 2, 20}, 0, slope.Rotate({0, -1, 0}), {}, slope);
  scene.substance = {1, 2};
  scene.AddSubstances(1, 0, 0.9, 0);
  scene.AddSubstances(2, 0, 0.1, 0);
  return scene;
}

/// Returns the distance [m] by which the block of BlockOnASlope slides in two seconds.
template <class Real>
double Slide(RigidScene<Real>& scene) {
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 30);
  const Vector at = scene.Position(0);
  engine.Advance(kFrame, 120);
  return Length(scene.Position(0) - at);
}

// tan(angle) is the coefficient of the pair, also if those of the two substances differ much from
// it.
TYPED_TEST(RigidContactTest, BlockSlidesAboveTheAngleOfFrictionOfItsPairOnly) {
  for (const double friction : {0.05, 0.3, 0.7}) {
    for (const double part : {0.97, 1.03}) {
      auto scene = BlockOnASlope<TypeParam>(std::atan(part * friction));
      scene.AddSubstances(2, 1, friction, 0);
      const double way = Slide(scene);
      SCOPED_TRACE(testing::Message() << "friction " << friction << ", part " << part);
      if (part < 1) {
        EXPECT_LT(way, 2e-3);
      } else {
        // a = g (sin - mu cos); the way begins with half a second's speed.
        const double angle = std::atan(part * friction), a = way / (0.5 * 2 + 2 * 2 / 2.0);
        EXPECT_NEAR((kG * std::sin(angle) - a) / (kG * std::cos(angle)), friction, 0.01 * friction);
      }
    }
  }
}

// Without a value of the pair, the friction is the geometric mean sqrt(0.9 * 0.1) = 0.3.
TYPED_TEST(RigidContactTest, SubstancesWithoutAPairHaveTheMeanOfTheirFrictions) {
  for (const double part : {0.97, 1.03}) {
    auto scene = BlockOnASlope<TypeParam>(std::atan(part * 0.3));
    scene.AddSubstances(3, 1, 5, 0);  // of another pair
    EXPECT_EQ(Slide(scene) > 0.05, part > 1) << part;
  }
}

// A body without a substance has the parameter 0.5 of the law: sqrt(0.5 * 0.1) = 0.2236.
TYPED_TEST(RigidContactTest, BodyWithoutASubstanceHasTheParameterOfTheLaw) {
  for (const double part : {0.97, 1.03}) {
    auto scene = BlockOnASlope<TypeParam>(std::atan(part * std::sqrt(0.05)));
    scene.substance = {0, 2};
    EXPECT_EQ(Slide(scene) > 0.05, part > 1) << part;
  }
}

// A ball that falls from the height h rises to e^2 h. The restitution of the pair precedes those of
// the substances; without it, the larger one counts.
TYPED_TEST(RigidContactTest, BallBouncesToTheHeightOfItsPairOfSubstances) {
  struct Case {
    double pair, expected;
  };
  for (const Case& one : {Case{0.5, 0.5}, Case{0.9, 0.9}, Case{0, 0.7}, Case{1e-12, 0}}) {
    RigidScene<TypeParam> scene;
    scene.gravity = {0, TypeParam(-kG), 0};
    scene.AddBall(0.1, 1, {0, 2.1, 0});
    scene.AddBox({20, 2, 20}, 0, {0, -1, 0});
    scene.substance = {1, 2};
    scene.AddSubstances(1, 0, 0, 0.7);
    scene.AddSubstances(2, 0, 0, 0.3);
    if (one.pair > 0) scene.AddSubstances(1, 2, 0, one.pair);
    PhysicsEngine engine = scene.MakeRigidEngine({{"restitutionSpeed", 0.2}});
    double top = 0;
    bool bounced = false;
    for (int i = 0; i < 240 && !(bounced && scene.Velocity(0).y < 0); ++i) {
      engine.Advance(kFrame);
      bounced = bounced || (scene.Position(0).y < 0.5 && scene.Velocity(0).y > 0.01);
      if (bounced) top = std::max(top, scene.Position(0).y - 0.1);
    }
    EXPECT_NEAR(std::sqrt(top / 2), one.expected, 0.02 * one.expected + 1e-3) << one.expected;
  }
}

TYPED_TEST(RigidContactTest, SubstancesOfNoPairGiveTheBitsOfTheParameters) {
  RigidScene<TypeParam> plain = Swarm<TypeParam>(7, 64), one = plain;
  one.substance.assign(one.mass.size(), 0);
  PhysicsEngine first = plain.MakeRigidEngine({{"restitution", 0.3}});
  PhysicsEngine second = one.MakeRigidEngine({{"restitution", 0.3}});
  first.Advance(kFrame, 60);
  second.Advance(kFrame, 60);
  EXPECT_EQ(plain.position, one.position);
  EXPECT_EQ(plain.spin, one.spin);
}

TYPED_TEST(RigidContactTest, MassZeroNeverMoves) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddBox({2, 1, 2}, 0, {0, 0, 0});
  scene.AddBox({1, 1, 1}, 100, {0, 1.5, 0});
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 300);
  EXPECT_EQ(scene.Position(0), (Vector{0, 0, 0}));
  EXPECT_NEAR(scene.Position(1).y, 1, 2e-3);
}

}  // namespace
}  // namespace vesper
