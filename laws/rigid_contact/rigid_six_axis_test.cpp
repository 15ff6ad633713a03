// SPDX-License-Identifier: Apache-2.0
// Joints of the type six-axis.
#include <cmath>

#include "rigid_scene.hpp"

namespace vesper {
namespace {

using rigid::JointType;
using rigid::Quaternion;
using rigid::RotationVector;
using Vector = Vec3<double>;

constexpr double kG = 9.81, kPi = 3.14159265358979323846;

template <class Real>
class SixAxisTest : public ::testing::Test {};
TYPED_TEST_SUITE(SixAxisTest, Precisions);

Quaternion About(const Vector& axis, double angle) {
  return {axis * std::sin(angle / 2), std::cos(angle / 2)};
}

/// The limits of the joints of a scene.
struct Limits {
  Vector offset_least, offset_greatest, turn_least, turn_greatest;
};
const Vector kFreeLeast{1, 1, 1}, kFreeGreatest{-1, -1, -1};

/// A body that a six-axis joint connects with an immovable body, row 0, at the same place.
template <class Real>
struct Held : RigidScene<Real> {
  Held(const Limits& limits, double gravity, const Quaternion& turned = {}) {
    this->gravity = {0, Real(-gravity), 0};
    this->AddBox({0.1, 0.1, 0.1}, 0, {0, 0, 0}, {}, turned);
    this->AddBox({0.4, 0.2, 0.6}, 2, {0, 0, 0});
    this->Join(JointType::kSixAxis, 0, 1, {0, 0, 0});
    Set(limits);
  }
  void Set(const Limits& limits) {
    const auto set = [&](const char* name, const Vector& v) {
      this->joint_loads[name] = {Real(v.x), Real(v.y), Real(v.z)};
    };
    set("offsetLeast", limits.offset_least);
    set("offsetGreatest", limits.offset_greatest);
    set("turnLeast", limits.turn_least);
    set("turnGreatest", limits.turn_greatest);
  }
  Vector Angles() const {
    const Quaternion of_a = this->Rotation(0).Normalised();
    const Quaternion rest = of_a.Inverse();  // the second body began without a rotation
    return RotationVector(of_a.Inverse() * this->Rotation(1).Normalised() * rest.Inverse(),
                          rigid::AngleOf)
        .vector();
  }
};

TEST(RotationVector, IsTheAxisTimesTheAngle) {
  const Vector axis{0.48, -0.6, 0.64};
  for (const double angle : {0.0, 1e-8, 1e-3, 0.7, 2.0, 3.1}) {
    EXPECT_LT(Length(RotationVector(About(axis, angle), rigid::AngleOf).vector() - axis * angle),
              1e-12)
        << angle;
  }
  const Vector other = RotationVector(About(axis, 2 * kPi - 1), rigid::AngleOf).vector();
  EXPECT_LT(Length(other + axis), 1e-12) << "the shorter of the two rotations";
}

TEST(RotationVector, RatesAreDerivatives) {
  const Vector axis{0.48, -0.6, 0.64}, spin{0.3, -0.8, 0.5};
  for (const double angle : {0.0, 1e-4, 0.002, 0.7, 2.0, 3.1}) {
    const Quaternion q = About(axis, angle);
    const RotationVector now(q, rigid::AngleOf);
    const double h = 1e-6;
    const auto after = [&](double t) {
      const double turn = Length(spin) * t;
      return RotationVector(About(spin * (1 / Length(spin)), turn) * q, rigid::AngleOf).vector();
    };
    const Vector rate = (after(h) - after(-h)) * (1 / (2 * h));
    EXPECT_NEAR(Dot(now.RateOf({1, 0, 0}), spin), rate.x, 1e-7) << angle;
    EXPECT_NEAR(Dot(now.RateOf({0, 1, 0}), spin), rate.y, 1e-7) << angle;
    EXPECT_NEAR(Dot(now.RateOf({0, 0, 1}), spin), rate.z, 1e-7) << angle;
  }
}

TYPED_TEST(SixAxisTest, LockedAxesHoldTheBody) {
  Held<TypeParam> scene({}, kG);
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 2400);
  EXPECT_LT(Length(scene.Position(1)), 1e-4);
  EXPECT_LT(Length(scene.Angles()), 1e-4);
  EXPECT_NEAR(scene.joint_force[1], 2 * kG, 1e-3) << "the weight";
}

TYPED_TEST(SixAxisTest, FreeOffsetFallsAndOthersStay) {
  Held<TypeParam> scene({{0, 1, 0}, {0, -1, 0}, {}, {}}, kG);
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 480, 480);
  EXPECT_NEAR(scene.Position(1).y, -kG / 2, 0.02);
  EXPECT_LT(std::hypot(scene.Position(1).x, scene.Position(1).z), 1e-5);
  EXPECT_NEAR(scene.joint_travel[0], -scene.Position(1).y, 0.05);
}

TYPED_TEST(SixAxisTest, OffsetStopsAtItsLimit) {
  Held<TypeParam> scene({{-0.1, -0.5, 0}, {0.1, 0.2, 0}, {}, {}}, kG);
  scene.velocity[3] = 1;  // of the second body along x
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 480);
  EXPECT_NEAR(scene.Position(1).y, -0.5, 1e-3);
  EXPECT_NEAR(scene.Position(1).x, 0.1, 1e-3);
  EXPECT_NEAR(scene.joint_force[1], 2 * kG, 0.05);
}

// The axes are those of the first body, which is turned by a quarter turn about z.
TYPED_TEST(SixAxisTest, AxesAreThoseOfTheFirstBody) {
  Held<TypeParam> scene({{-0.3, 0, 0}, {0.3, 0, 0}, {}, {}}, kG, About({0, 0, 1}, kPi / 2));
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 480);
  EXPECT_NEAR(scene.Position(1).y, -0.3, 1e-3) << "x of the first body points up";
  EXPECT_LT(std::hypot(scene.Position(1).x, scene.Position(1).z), 1e-4);
  EXPECT_LT(Length(scene.Angles()), 1e-4);
}

// Two locked angles make a hinge. A rod that swings about its end has the period T = 2 pi
// sqrt(2 L / (3 g)) for small swings.
TYPED_TEST(SixAxisTest, TwoLockedAnglesMakeAHinge) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddBox({0.1, 0.1, 0.1}, 0, {0, 0, 0});
  const double length = 1, tilt = 0.05;
  const Quaternion turned = About({0, 0, 1}, tilt);
  scene.AddBox({0.01, length, 0.01}, 2, turned.Rotate({0, -length / 2, 0}), {}, turned);
  scene.Join(JointType::kSixAxis, 0, 1, {0, 0, 0});
  scene.joint_loads["turnLeast"] = {0, 0, 1};
  scene.joint_loads["turnGreatest"] = {0, 0, -1};
  PhysicsEngine engine = scene.MakeRigidEngine();
  const double dt = 1.0 / 1000;
  double crossed = 0, before = 1, periods = 0, first = 0;
  for (int i = 1; i <= 8000; ++i) {
    engine.Advance(dt);
    const double x = scene.Position(1).x;
    if (before < 0 && x >= 0) {
      crossed = (i - x / (x - before)) * dt;
      if (first == 0) first = crossed;
      ++periods;
    }
    before = x;
  }
  const double expected = 2 * kPi * std::sqrt(2 * length / (3 * kG)) * (1 + tilt * tilt / 16);
  EXPECT_NEAR((crossed - first) / (periods - 1), expected, 2e-3 * expected);
  EXPECT_LT(std::abs(scene.Position(1).z), 1e-4);
}

TYPED_TEST(SixAxisTest, AnglesStayWithinTheirLimits) {
  const Limits limits{{}, {}, {-0.4, -0.2, 0}, {0.4, 0.6, 0}};
  Held<TypeParam> scene(limits, 0);
  scene.spin[3] = 5, scene.spin[4] = -3, scene.spin[5] = 2;
  PhysicsEngine engine = scene.MakeRigidEngine();
  for (int i = 0; i < 240; ++i) {
    engine.Advance(1.0 / 480, 4);
    const Vector angles = scene.Angles();
    EXPECT_GT(angles.x, -0.41);
    EXPECT_LT(angles.x, 0.41);
    EXPECT_GT(angles.y, -0.21);
    EXPECT_LT(angles.y, 0.61);
    EXPECT_NEAR(angles.z, 0, 2e-3);
  }
  EXPECT_LT(Length(scene.Position(1)), 1e-4);
}

// A spring with the stiffness k has the period 2 pi sqrt(m / k), or 2 pi sqrt(I / k).
TYPED_TEST(SixAxisTest, SpringsOfFreeAxesHaveThePeriodOfTheClosedForm) {
  for (const bool turns : {false, true}) {
    Held<TypeParam> scene({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}, 0);
    scene.joint_loads["travelStiffness"] = {200};
    scene.joint_loads["angleStiffness"] = {20};
    (turns ? scene.spin[4] : scene.velocity[3]) = TypeParam(0.5);
    PhysicsEngine engine = scene.MakeRigidEngine();
    const double dt = 1.0 / 2000;
    double before = -1, first = 0, last = 0, periods = -1;
    for (int i = 1; i <= 6000; ++i) {
      engine.Advance(dt);
      const double value = turns ? scene.Angles().y : scene.Position(1).x;
      if (before < 0 && value >= 0) {
        last = (i - value / (value - before)) * dt;
        if (periods++ < 0) first = last;
      }
      before = value;
    }
    const double inertia = scene.Moments(1).y;
    const double expected = 2 * kPi * std::sqrt(turns ? inertia / 20 : 2.0 / 200);
    ASSERT_GT(periods, 2);
    EXPECT_NEAR((last - first) / periods, expected, 3e-3 * expected);
  }
}

TYPED_TEST(SixAxisTest, DampingOfFreeAxesIsExponential) {
  Held<TypeParam> scene({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}, 0);
  scene.joint_loads["travelDamping"] = {3};
  scene.velocity[3] = 2;
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 3840, 3840);
  EXPECT_NEAR(scene.Velocity(1).x, 2 * std::exp(-3 / 2.0), 2e-3);
}

TYPED_TEST(SixAxisTest, LockedOffsetAndAngleMayDifferFromZero) {
  const Vector offset{0.2, -0.1, 0.05}, turn{0.3, 0.1, -0.2};
  Held<TypeParam> scene({offset, offset, turn, turn}, kG);
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 960);
  EXPECT_LT(Length(scene.Position(1) - offset), 1e-3);
  EXPECT_LT(Length(scene.Angles() - turn), 2e-3);
  EXPECT_NEAR(scene.joint_angle[0], Length(turn), 2e-3);
  EXPECT_NEAR(scene.joint_travel[0], Length(offset), 1e-3);
}

TYPED_TEST(SixAxisTest, FreeBodiesKeepTheirMomenta) {
  RigidScene<TypeParam> scene;
  scene.AddBox({1, 0.2, 0.4}, 2, {0, 0, 0}, {0, 1, 0});
  scene.AddBox({1, 0.3, 0.2}, 1, {1, 0, 0}, {0.5, 0, 2});
  scene.Join(JointType::kSixAxis, 0, 1, {0.5, 0, 0});
  scene.joint_loads["offsetLeast"] = {-0.1, 0, 1};
  scene.joint_loads["offsetGreatest"] = {0.1, 0, -1};
  scene.joint_loads["turnLeast"] = {-0.3, 0, 1};
  scene.joint_loads["turnGreatest"] = {0.3, 0, -1};
  scene.joint_loads["travelStiffness"] = {30};
  scene.joint_loads["angleDamping"] = {0.1};
  const Vector momentum = scene.Momentum(), angular = scene.TotalAngularMomentum();
  const double energy = scene.TotalKineticEnergy();
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 960);
  EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(1e4));
  EXPECT_LT(Length(scene.TotalAngularMomentum() - angular), 0.01 * Length(angular));
  EXPECT_LT(scene.TotalKineticEnergy(), energy + 1e-6);
}

TYPED_TEST(SixAxisTest, BreaksAboveItsForce) {
  Held<TypeParam> scene({}, kG);
  scene.shape[0] = static_cast<int32_t>(rigid::ShapeCode::kNone);  // nothing to rest on
  scene.breaking_force = {10};                                     // less than the weight, 19.6 N
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 240);
  EXPECT_EQ(scene.broken[0], 1);
  EXPECT_LT(scene.Position(1).y, -3);
}

}  // namespace
}  // namespace vesper
