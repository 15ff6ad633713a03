// SPDX-License-Identifier: Apache-2.0
// Ropes and gears against closed forms and invariants.
#include <cmath>
#include <limits>

#include "rigid_scene.hpp"

namespace vesper {
namespace {

using rigid::JointType;
using rigid::ShapeCode;
using Vector = Vec3<double>;

constexpr double kGravity = 9.81, kStep = 1.0 / 960;

template <class Real>
class RigidGearTest : public ::testing::Test {};
TYPED_TEST_SUITE(RigidGearTest, Precisions);

/// Returns a scene with an immovable body (row 0), on which bodies are hinged.
template <class Real>
RigidScene<Real> Frame(double gravity = 0) {
  RigidScene<Real> scene;
  scene.gravity = {0, Real(-gravity), 0};
  scene.Add(ShapeCode::kNone, {}, 0, {0, 0, 0});
  return scene;
}

/// Adds a wheel of this moment of inertia [kg m^2] on a hinge along Z at x; returns its row.
template <class Real>
uint32_t AddWheel(RigidScene<Real>& scene, double x, double moment, uint32_t on = 0) {
  const uint32_t wheel = scene.Add(ShapeCode::kNone, {}, 1, {x, 0, 0});
  for (int k = 0; k < 3; ++k) scene.inertia[3 * wheel + k] = Real(moment);
  scene.Join(JointType::kHinge, on, wheel, {x, 0, 0}, {0, 0, 1});
  return wheel;
}

/// Returns the largest error that a place may have: rounding of the angle and of its column.
template <class Real>
double Exactly(double place) {
  return sizeof(Real) == sizeof(double) ? 1e-9 : 2e-4 * (1 + std::abs(place));
}

// The torque T of a motor on the second wheel accelerates it by T / (I2 + ratio^2 I1). The gear
// exerts the torque ratio * I1 times this acceleration on the first wheel.
TYPED_TEST(RigidGearTest, MotorAcceleratesBothWheelsOverManyTurns) {
  for (const double ratio : {-2.0, 0.25, 3.0, 20.0}) {
    auto scene = Frame<TypeParam>();
    AddWheel(scene, 1, 0.5);
    AddWheel(scene, 3, 2);
    const uint32_t gear = scene.AddGear(0, 1, ratio);
    scene.motor_speed = {0, 1000};
    scene.motor_torque = {0, 30};
    PhysicsEngine engine = scene.MakeRigidEngine();
    const double rate = 30 / (2 + ratio * ratio * 0.5), time = 4;
    engine.Advance(kStep, 960 * 4);
    SCOPED_TRACE(testing::Message() << "ratio " << ratio);
    EXPECT_NEAR(scene.Spin(2).z, rate * time, 1e-3 * rate * time);
    EXPECT_NEAR(scene.Spin(1).z, ratio * scene.Spin(2).z,
                Exactly<TypeParam>(std::abs(ratio) * rate * time));
    EXPECT_NEAR(scene.gear_torque[gear], ratio * 0.5 * rate, 2e-3 * std::abs(ratio * 0.5 * rate));
    EXPECT_EQ(scene.gear_force[gear], 0);
    // The angles are counted beyond whole turns, and the step adds dt / 2 of the speed.
    const double angle = rate * time * (time + kStep) / 2;
    EXPECT_NEAR(scene.gear_places[1], angle, 2e-3 * angle);
    EXPECT_NEAR(scene.gear_places[0], ratio * scene.gear_places[1],
                Exactly<TypeParam>(ratio * angle));
  }
}

// The second wheel alone rotates at first. The gear couples it to the first one without loss of the
// momentum I2 w2 + ratio I1 w1: w2 = I2 w / (I2 + ratio^2 I1). Then the energy is constant.
TYPED_TEST(RigidGearTest, GearSharesTheMomentumAndThenKeepsTheEnergy) {
  auto scene = Frame<TypeParam>();
  AddWheel(scene, 1, 0.5);
  const uint32_t second = AddWheel(scene, 3, 2);
  const double ratio = -3;
  scene.AddGear(0, 1, ratio);
  scene.spin[3 * second + 2] = 10;
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 10);
  const double shared = 2 * 10 / (2 + 9 * 0.5);
  EXPECT_NEAR(scene.Spin(2).z, shared, 1e-3);
  EXPECT_NEAR(scene.Spin(1).z, ratio * shared, 3e-3);
  const double energy = scene.TotalKineticEnergy();
  EXPECT_NEAR(energy, (2 + 9 * 0.5) / 2 * shared * shared, 0.02);
  for (int elapsed = 1; elapsed <= 60; ++elapsed) {
    engine.Advance(kStep, 960);
    EXPECT_NEAR(scene.TotalKineticEnergy(), energy, Rounding<TypeParam>(1e6)) << elapsed;
    EXPECT_NEAR(scene.gear_places[0], ratio * scene.gear_places[1],
                Exactly<TypeParam>(scene.gear_places[0]));
  }
}

// A rack of the mass m falls and turns a pinion of the radius r: a = m g / (m + I / r^2).
TYPED_TEST(RigidGearTest, RackAndPinionFallAsTheClosedForm) {
  auto scene = Frame<TypeParam>(kGravity);
  const double radius = 0.2, moment = 0.1, mass = 3;
  const uint32_t rack = scene.AddBox({0.1, 1, 0.1}, mass, {0, 0, 0});
  const uint32_t slider = scene.Join(JointType::kSlider, 0, rack, {0, 0, 0}, {0, -1, 0});
  const uint32_t pinion = AddWheel(scene, 1, moment);
  const uint32_t gear = scene.AddGear(slider, 1, radius);
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 960);
  const double a = mass * kGravity / (mass + moment / (radius * radius));
  EXPECT_NEAR(scene.Velocity(rack).y, -a, 1e-3 * a);
  EXPECT_NEAR(scene.Spin(pinion).z, a / radius, 1e-3 * a / radius);
  // The pinion holds the rack back with the force I / r^2 a.
  const double held = moment / (radius * radius) * a;
  EXPECT_NEAR(scene.gear_force[gear], -held, 5e-3 * held);
  EXPECT_EQ(scene.gear_torque[gear], 0);
  EXPECT_NEAR(scene.gear_places[0], radius * scene.gear_places[1], Exactly<TypeParam>(1));
}

// Two sliders and the ratio -1: Atwood's machine, a = (m1 - m2) / (m1 + m2) g.
TYPED_TEST(RigidGearTest, TwoSlidersAreAtwoodsMachine) {
  auto scene = Frame<TypeParam>(kGravity);
  const uint32_t left = scene.AddBox({0.1, 0.1, 0.1}, 3, {-1, 0, 0});
  const uint32_t right = scene.AddBox({0.1, 0.1, 0.1}, 1, {1, 0, 0});
  scene.Join(JointType::kSlider, 0, left, {-1, 0, 0}, {0, 1, 0});
  scene.Join(JointType::kSlider, 0, right, {1, 0, 0}, {0, 1, 0});
  scene.AddGear(0, 1, -1);
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 960);
  EXPECT_NEAR(scene.Velocity(left).y, -kGravity / 2, 1e-3 * kGravity);
  EXPECT_NEAR(scene.Velocity(right).y, kGravity / 2, 1e-3 * kGravity);
  EXPECT_NEAR(scene.gear_force[0], 1.5 * kGravity, 0.01);  // tension 2 m1 m2 / (m1 + m2) g
}

// A free body with two geared wheels: the gear is internal, so no momentum changes.
TYPED_TEST(RigidGearTest, GearOnAFreeBodyKeepsTheMomenta) {
  RigidScene<TypeParam> scene;
  scene.AddBox({4, 1, 1}, 5, {0, 0, 0}, {1, 2, 3});
  scene.spin[1] = TypeParam(0.5);
  AddWheel(scene, -1, 0.5);
  const uint32_t second = AddWheel(scene, 1, 0.25);
  for (const uint32_t wheel : {1u, second}) {
    for (int k = 0; k < 3; ++k) scene.velocity[3 * wheel + k] = TypeParam(k + 1);
    scene.velocity[3 * wheel + 2] -= TypeParam(0.5) * (wheel == 1 ? -1 : 1);
    scene.spin[3 * wheel + 1] = TypeParam(0.5);
  }
  scene.AddGear(0, 1, -2);
  scene.motor_speed = {0, 5};
  scene.motor_torque = {0, 3};
  const Vector momentum = scene.Momentum(), angular = scene.TotalAngularMomentum();
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 960 * 6);
  const Vector axis = scene.Rotation(0).Rotate({0, 0, 1});
  const double of_first = Dot(scene.Spin(1) - scene.Spin(0), axis);
  const double of_second = Dot(scene.Spin(2) - scene.Spin(0), axis);
  EXPECT_NEAR(of_second, 5, 0.01);
  EXPECT_NEAR(of_first, -2 * of_second, 1e-2);
  EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(1e5));
  EXPECT_LT(Length(scene.TotalAngularMomentum() - angular), 0.01 * Length(angular));
}

// Both joints have a body in common: the second wheel turns on the first one.
TYPED_TEST(RigidGearTest, WheelOnAWheelTurnsByItsRatio) {
  auto scene = Frame<TypeParam>();
  const uint32_t inner = AddWheel(scene, 0, 1);
  AddWheel(scene, 0, 0.5, inner);
  scene.AddGear(1, 0, 2);  // of the outer wheel relative to the inner one
  scene.motor_speed = {1000, 0};
  scene.motor_torque = {11, 0};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 960);
  // The outer wheel has 1 + 2 times the speed: (1 + 9 * 0.5) a = 11.
  EXPECT_NEAR(scene.Spin(1).z, 2, 2e-3);
  EXPECT_NEAR(scene.Spin(2).z, 6, 6e-3);
}

TYPED_TEST(RigidGearTest, FollowerMovesToItsOffsetAndFollowsAServo) {
  auto scene = Frame<TypeParam>();
  AddWheel(scene, 1, 0.5);
  AddWheel(scene, 3, 1);
  scene.AddGear(0, 1, -0.5);
  scene.offset_angle = {TypeParam(0.3)};
  scene.motor_torque = {0, 100};
  scene.joint_loads["motorAngle"] = {0, TypeParam(1.2)};
  scene.joint_loads["motorStiffness"] = {0, 400};
  scene.joint_loads["motorDamping"] = {0, 40};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 9600);
  EXPECT_NEAR(scene.joint_angle[1], 1.2, 1e-4);
  EXPECT_NEAR(scene.joint_angle[0], 0.3 - 0.5 * 1.2, 1e-4);
}

TYPED_TEST(RigidGearTest, GearOfABrokenJointHasNoEffect) {
  auto scene = Frame<TypeParam>();
  AddWheel(scene, 1, 0.5);
  const uint32_t second = AddWheel(scene, 3, 1);
  scene.AddGear(0, 1, 2);
  scene.gear_torque = {7};
  scene.broken = {1, 0};
  scene.spin[3 * second + 2] = 4;
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 96);
  EXPECT_NEAR(scene.Spin(2).z, 4, 1e-5);
  EXPECT_NEAR(scene.Spin(1).z, 0, 1e-9);
  EXPECT_EQ(scene.gear_torque[0], 0);
}

TYPED_TEST(RigidGearTest, ValuesThatAreNotFiniteAreRefusedWithTheirRow) {
  auto scene = Frame<TypeParam>();
  AddWheel(scene, 1, 0.5);
  AddWheel(scene, 3, 1);
  scene.AddGear(0, 1, 2);
  scene.gear_ratio = {std::numeric_limits<TypeParam>::infinity()};
  PhysicsEngine engine = scene.MakeRigidEngine();
  try {
    engine.Advance(kStep, 1);
    FAIL() << "not refused";
  } catch (const std::exception& refused) {
    EXPECT_NE(std::string(refused.what()).find("gear row 0"), std::string::npos) << refused.what();
  }
}

// A rope of the length 2 catches a ball that fell from (0.5, 0). Only the part of the velocity
// across the rope remains, v d / L with v^2 = 2 g h, and the energy is constant from then on.
TYPED_TEST(RigidGearTest, RopeThatBecomesTautKeepsTheVelocityAcrossIt) {
  auto scene = Frame<TypeParam>(kGravity);
  const double aside = 0.5, length = 2, height = std::sqrt(length * length - aside * aside);
  const uint32_t ball = scene.AddBall(0.1, 1, {aside, 0, 0});
  scene.Join(JointType::kRope, 0, ball, {0, 0, 0});
  scene.joint_loads["ropeLength"] = {TypeParam(length)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  const double falls = std::sqrt(2 * height / kGravity);
  const int before = int(falls / kStep) - 2;
  engine.Advance(kStep, before);
  EXPECT_NEAR(scene.Position(ball).y, -kGravity * std::pow(before * kStep, 2) / 2, 0.01)
      << "a slack rope exerts no force";
  EXPECT_NEAR(scene.Position(ball).x, aside, 1e-6);
  EXPECT_EQ(scene.joint_force[1], 0);
  engine.Advance(kStep, 8);
  const double across = std::sqrt(2 * kGravity * height) * aside / length;
  EXPECT_NEAR(Length(scene.Velocity(ball)), across, 0.05 * across);
  const double energy = across * across / 2 - kGravity * height;
  double longest = 0;
  for (int i = 0; i < 10 * 960; ++i) {
    engine.Advance(kStep, 1);
    longest = std::max(longest, Length(scene.Position(ball)));
  }
  EXPECT_LT(longest, length * 1.001);
  EXPECT_NEAR(scene.TotalKineticEnergy() + scene.HeightEnergy(), energy, 0.02 * kGravity);
}

// Two free bodies: the rope joins their velocities to that of their centre of mass along the rope,
// and the energy m1 m2 / (m1 + m2) v^2 / 2 is lost. No momentum changes.
TYPED_TEST(RigidGearTest, RopeBetweenFreeBodiesSharesTheirMomentum) {
  RigidScene<TypeParam> scene;
  scene.AddBall(0.1, 1, {0, 0, 0});
  scene.AddBall(0.1, 3, {1, 0, 0}, {2, 0, 0});
  const uint32_t rope = scene.Join(JointType::kRope, 0, 1, {0, 0, 0});
  scene.joint_loads["ropeLength"] = {3};
  const Vector momentum = scene.Momentum(), angular = scene.TotalAngularMomentum();
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 950);
  EXPECT_NEAR(scene.Velocity(0).x, 0, 1e-6) << "slack until 1 s";
  engine.Advance(kStep, 960);
  EXPECT_NEAR(scene.Velocity(0).x, 1.5, 1e-3);
  EXPECT_NEAR(scene.Velocity(1).x, 1.5, 1e-3);
  EXPECT_NEAR(scene.TotalKineticEnergy(), 3 * 4 / 2.0 - 0.75 * 4 / 2, 5e-3);
  EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(1e3));
  EXPECT_LT(Length(scene.TotalAngularMomentum() - angular), Rounding<TypeParam>(1e3));
  EXPECT_NEAR(scene.joint_travel[rope], 3, 2e-3);
}

// A conical pendulum: the tension is m w^2 L with cos a = g / (w^2 L).
TYPED_TEST(RigidGearTest, RopeTellsItsTension) {
  auto scene = Frame<TypeParam>(kGravity);
  const double length = 2, angle = 0.6, rate = std::sqrt(kGravity / (length * std::cos(angle)));
  const uint32_t ball =
      scene.AddBall(0.1, 1.5, Vector{std::sin(angle), -std::cos(angle), 0} * length,
                    {0, 0, rate * length * std::sin(angle)});
  const uint32_t rope = scene.Join(JointType::kRope, 0, ball, {0, 0, 0});
  scene.joint_loads["ropeLength"] = {TypeParam(length)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 960);
  const double tension = 1.5 * rate * rate * length;
  EXPECT_NEAR(Length(scene.Wide(scene.At(scene.joint_force, rope))), tension, 0.01 * tension);
  EXPECT_NEAR(scene.Position(ball).y, -length * std::cos(angle), 5e-3);
}

// The anchors of a rope may pass through each other. A distance joint with the lower limit 0 would
// reflect them.
TYPED_TEST(RigidGearTest, SlackRopeLetsItsAnchorsPassThroughEachOther) {
  auto scene = Frame<TypeParam>();
  const uint32_t ball = scene.AddBall(0.1, 1, {-1, 0, 0}, {2, 0, 0});
  scene.Join(JointType::kRope, 0, ball, {0, 0, 0});
  scene.joint_loads["ropeLength"] = {5};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kStep, 960);
  EXPECT_NEAR(scene.Position(ball).x, 1, 1e-4);
  EXPECT_NEAR(scene.Velocity(ball).x, 2, 1e-6);
}

TYPED_TEST(RigidGearTest, BitsOfGearsAndRopesDoNotDependOnThreads) {
  const auto make = [] {
    auto scene = Frame<TypeParam>(kGravity);
    for (int i = 0; i < 40; ++i) AddWheel(scene, i, 0.1 + 0.01 * i);
    for (uint32_t i = 0; i < 39; ++i) scene.AddGear(i, i + 1, i % 2 == 0 ? -0.7 : 1.3);
    scene.joint_loads["ropeLength"].assign(40, 0);
    for (int i = 0; i < 40; ++i) {
      const uint32_t ball = scene.AddBall(0.1, 1, {double(i), -1, 0}, {1, 0, 0.1 * i});
      scene.Join(JointType::kRope, uint32_t(i) + 1, ball, {double(i), 0.2, 0});
      scene.joint_loads["ropeLength"].push_back(TypeParam(1.5));
    }
    return scene;
  };
  auto one = make(), two = make();
  PhysicsEngine alone = one.MakeRigidEngine(), together = two.MakeRigidEngine({}, 4);
  alone.Advance(kStep, 960);
  together.Advance(kStep, 960);
  EXPECT_EQ(one.position, two.position);
  EXPECT_EQ(one.spin, two.spin);
  EXPECT_EQ(one.gear_torque, two.gear_torque);
}

}  // namespace
}  // namespace vesper
