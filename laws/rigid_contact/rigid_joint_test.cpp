// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "rigid_scene.hpp"

namespace vesper {
namespace {

using rigid::JointType;
using rigid::Quaternion;
using Vector = Vec3<double>;

constexpr double kG = 9.81, kPi = 3.14159265358979323846;

template <class Real>
class RigidJointTest : public ::testing::Test {};
TYPED_TEST_SUITE(RigidJointTest, Precisions);

/// Returns a scene under gravity with one immovable body, row 0, at the origin.
template <class Real>
RigidScene<Real> Hanging() {
  RigidScene<Real> scene;
  scene.gravity = {0, Real(-kG), 0};
  scene.AddBox({0.1, 0.1, 0.1}, 0, {0, 0, 0});
  return scene;
}

TEST(AngleOf, IsThatOfTheSystemLibrary) {
  for (int i = -1000; i <= 1000; ++i) {
    const double angle = i * kPi / 1000;
    EXPECT_NEAR(rigid::AngleOf(3 * std::sin(angle), 3 * std::cos(angle)),
                std::atan2(3 * std::sin(angle), 3 * std::cos(angle)), 4e-15);
  }
  EXPECT_EQ(rigid::AngleOf(0, 0), 0);
}

// A rod that swings about its end has the period T = 2 pi sqrt(2 L / (3 g)) for small swings.
TYPED_TEST(RigidJointTest, RodSwingsWithThePeriodOfTheClosedForm) {
  for (const JointType type : {JointType::kBall, JointType::kHinge}) {
    auto scene = Hanging<TypeParam>();
    const double length = 1, tilt = 0.05;
    const uint32_t rod = scene.AddBox({0.01, length, 0.01}, 2,
                                      Vector{std::sin(tilt), -std::cos(tilt), 0} * (length / 2), {},
                                      {{0, 0, std::sin(tilt / 2)}, std::cos(tilt / 2)});
    scene.Join(type, 0, rod, {0, 0, 0}, {0, 0, 1});
    PhysicsEngine engine = scene.MakeRigidEngine();
    const double dt = 1.0 / 1000;
    double crossed = 0, before = 1, periods = 0, first = 0;
    for (int i = 1; i <= 8000; ++i) {
      engine.Advance(dt);
      const double x = scene.Position(rod).x;
      if (before < 0 && x >= 0) {
        crossed = (i - x / (x - before)) * dt;
        if (first == 0) first = crossed;
        ++periods;
      }
      before = x;
    }
    const double expected = 2 * kPi * std::sqrt(2 * length / (3 * kG)) * (1 + tilt * tilt / 16);
    EXPECT_NEAR((crossed - first) / (periods - 1), expected, 2e-3 * expected);
  }
}

/// A planar double pendulum of two rods, and its equations of motion.
struct DoublePendulum {
  double m = 1, length = 1, inertia = 1.0 / 12;
  std::array<double, 4> state;  // angles from the vertical and their rates

  std::array<double, 4> Rates(const std::array<double, 4>& s) const {
    const double half = length / 2, c = std::cos(s[0] - s[1]), d = std::sin(s[0] - s[1]);
    const double a = m * half * half + inertia + m * length * length, b = m * length * half * c;
    const double e = m * half * half + inertia;
    const double p =
        -m * length * half * d * s[3] * s[3] - (m * half + m * length) * kG * std::sin(s[0]);
    const double q = m * length * half * d * s[2] * s[2] - m * half * kG * std::sin(s[1]);
    const double determinant = a * e - b * b;
    return {s[2], s[3], (p * e - b * q) / determinant, (a * q - b * p) / determinant};
  }
  void Advance(double dt) {
    const auto plus = [](const auto& s, const auto& r, double f) {
      auto sum = s;
      for (int i = 0; i < 4; ++i) sum[i] += r[i] * f;
      return sum;
    };
    const auto k1 = Rates(state), k2 = Rates(plus(state, k1, dt / 2));
    const auto k3 = Rates(plus(state, k2, dt / 2)), k4 = Rates(plus(state, k3, dt));
    for (int i = 0; i < 4; ++i) state[i] += dt / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
};

template <class Real>
RigidScene<Real> DoublePendulumScene(double angle_1, double angle_2) {
  auto scene = Hanging<Real>();
  const auto rod = [&](Vector from, double angle) {
    const Vector along{std::sin(angle), -std::cos(angle), 0};
    const uint32_t body = scene.Add(rigid::ShapeCode::kNone, {}, 1, from + along * 0.5, {},
                                    {{0, 0, std::sin(angle / 2)}, std::cos(angle / 2)});
    for (int k = 0; k < 3; ++k) scene.inertia[3 * body + k] = Real(k == 1 ? 0.001 : 1.0 / 12);
    return body;
  };
  const Vector elbow{std::sin(angle_1), -std::cos(angle_1), 0};
  const uint32_t upper = rod({}, angle_1), lower = rod(elbow, angle_2);
  scene.Join(JointType::kHinge, 0, upper, {0, 0, 0}, {0, 0, 1});
  scene.Join(JointType::kHinge, upper, lower, elbow, {0, 0, 1});
  return scene;
}

TEST(RigidJoint, DoublePendulumFollowsItsEquations) {
  auto scene = DoublePendulumScene<double>(1.2, 0.4);
  DoublePendulum reference;
  reference.state = {1.2, 0.4, 0, 0};
  PhysicsEngine engine = scene.MakeRigidEngine();
  const double dt = 1.0 / 4000;
  for (int i = 1; i <= 8000; ++i) {
    engine.Advance(dt);
    reference.Advance(dt);
    if (i % 1000 != 0) continue;
    const Vector expected{std::sin(reference.state[0]) + 0.5 * std::sin(reference.state[1]),
                          -std::cos(reference.state[0]) - 0.5 * std::cos(reference.state[1]), 0};
    EXPECT_LT(Length(scene.Position(2) - expected), 0.01) << "after " << i * dt << " s";
  }
}

TEST(RigidJoint, DoublePendulumKeepsItsEnergyForAMinute) {
  auto scene = DoublePendulumScene<double>(2.0, 2.5);
  PhysicsEngine engine = scene.MakeRigidEngine({{"substeps", 1}});
  const double begin = scene.TotalKineticEnergy() + scene.HeightEnergy();
  const double scale = 2 * kG * 2;  // between hanging and standing
  const double dt = 1.0 / 4000;
  for (int second = 1; second <= 60; ++second) {
    engine.Advance(dt, 4000);
    EXPECT_NEAR(scene.TotalKineticEnergy() + scene.HeightEnergy(), begin, 1e-3 * scale)
        << "after " << second << " s";
  }
}

// The chain has ten links with the masses 1 kg and 10 kg in turn.
TYPED_TEST(RigidJointTest, ChainOfUnequalLinksStaysTogether) {
  auto scene = Hanging<TypeParam>();
  uint32_t before = 0;
  for (int i = 0; i < 10; ++i) {
    const double mass = i % 2 == 0 ? 1 : 10;
    const uint32_t link = scene.Add(rigid::ShapeCode::kNone, {}, mass, {i + 0.5, 0, 0});
    for (int k = 0; k < 3; ++k) scene.inertia[3 * link + k] = TypeParam(mass / (k == 0 ? 600 : 12));
    scene.Join(JointType::kHinge, before, link, {double(i), 0, 0}, {0, 0, 1});
    before = link;
  }
  PhysicsEngine engine = scene.MakeRigidEngine({{"substeps", 8}});
  double worst = 0;
  for (int i = 0; i < 600; ++i) {
    engine.Advance(1.0 / 960, 16);
    Vector end{0, 0, 0};
    for (uint32_t link = 1; link <= 10; ++link) {
      const Quaternion q = scene.Rotation(link);
      worst = std::max(worst, Length(scene.Position(link) - q.Rotate({0.5, 0, 0}) - end));
      end = scene.Position(link) + q.Rotate({0.5, 0, 0});
    }
  }
  EXPECT_LT(worst, sizeof(TypeParam) == sizeof(double) ? 3e-4 : 5e-3);
}

// Links of unequal masses hit each other. The impulses of an impact must not return in later steps.
TYPED_TEST(RigidJointTest, ChainWhoseLinksCollideGainsNoEnergy) {
  auto scene = Hanging<TypeParam>();
  uint32_t before = 0;
  for (int i = 0; i < 10; ++i) {
    const uint32_t link = scene.AddBox({1, 0.1, 0.1}, i % 2 == 0 ? 1 : 10, {i + 0.5, 0, 0});
    scene.Join(JointType::kHinge, before, link, {double(i), 0, 0}, {0, 0, 1});
    before = link;
  }
  PhysicsEngine engine = scene.MakeRigidEngine();
  for (int i = 0; i < 10; ++i) {
    engine.Advance(1.0 / 240, 240);
    // The fall to the lowest position releases 2700 J.
    EXPECT_LT(scene.TotalKineticEnergy() + scene.HeightEnergy(), 20) << "after " << i + 1 << " s";
  }
}

TYPED_TEST(RigidJointTest, FixedJointHoldsABeamAndTellsItsLoad) {
  auto scene = Hanging<TypeParam>();
  const uint32_t beam = scene.AddBox({1, 0.1, 0.1}, 3, {0.5, 0, 0});
  const uint32_t joint = scene.Join(JointType::kFixed, 0, beam, {0, 0, 0});
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 480);
  EXPECT_LT(Length(scene.Position(beam) - Vector{0.5, 0, 0}), 1e-3);
  EXPECT_NEAR(scene.joint_force[3 * joint + 1], 3 * kG, 0.02);
  // The force at the anchor turns the beam by 3 g / 2 about its centre; the torque balances it.
  EXPECT_NEAR(scene.joint_torque[3 * joint + 2], 3 * kG / 2, 0.02);
}

TYPED_TEST(RigidJointTest, JointBreaksAboveItsForceOnly) {
  for (const double most : {29.0, 30.0}) {  // 3 kg: 29.4 N
    auto scene = Hanging<TypeParam>();
    const uint32_t weight = scene.AddBox({0.2, 0.2, 0.2}, 3, {0, -0.3, 0});
    scene.Join(JointType::kFixed, 0, weight, {0, 0, 0});
    scene.breaking_force = {TypeParam(most)};
    PhysicsEngine engine = scene.MakeRigidEngine();
    engine.Advance(1.0 / 240, 240);
    EXPECT_EQ(scene.broken[0], most < 29.4) << most;
    EXPECT_EQ(scene.Position(weight).y < -1, most < 29.4) << most;
  }
}

TYPED_TEST(RigidJointTest, MotorTurnsAWheelWithItsTorqueUpToItsSpeed) {
  auto scene = Hanging<TypeParam>();
  const uint32_t wheel = scene.Add(rigid::ShapeCode::kCylinder, {1, 0.2, 1}, 8, {0, -1, 0});
  scene.Join(JointType::kHinge, 0, wheel, {0, -1, 0}, {0, 1, 0});
  scene.motor_speed = {6};
  scene.motor_torque = {2};  // moment 8 * 0.25 / 2 = 1: 2 rad/s^2
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 240);
  EXPECT_NEAR(scene.Spin(wheel).y, 2, 0.01);
  EXPECT_NEAR(scene.joint_angle[0], 1, 0.01);
  engine.Advance(1.0 / 240, 720);
  EXPECT_NEAR(scene.Spin(wheel).y, 6, 0.01);
}

// The arm would sink by 12 mm/s without the motors' impulses of the last step as a first guess.
TYPED_TEST(RigidJointTest, MotorsHoldAnArmOfThreeLinksWithoutCreep) {
  auto scene = Hanging<TypeParam>();
  uint32_t last = 0;
  for (int link = 0; link < 3; ++link) {
    const uint32_t next = scene.AddBox({0.4, 0.1, 0.1}, 2.0 - 0.5 * link, {0.2 + 0.4 * link, 0, 0});
    scene.Join(JointType::kHinge, last, next, {0.4 * link, 0, 0}, {0, 0, 1});
    last = next;
  }
  scene.motor_speed = {0, 0, 0};
  scene.motor_torque = {100, 100, 100};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 960, 960);
  const double after_a_second = scene.Position(last).y;
  EXPECT_NEAR(after_a_second, 0, 1e-3);
  engine.Advance(1.0 / 960, 9 * 960);
  EXPECT_NEAR(scene.Position(last).y, after_a_second, 1e-5);
}

TYPED_TEST(RigidJointTest, DoorStopsAtItsLimit) {
  auto scene = Hanging<TypeParam>();
  const uint32_t door = scene.AddBox({1, 2, 0.05}, 20, {0.5, 0, 0}, {0, 0, 1});
  scene.Join(JointType::kHinge, 0, door, {0, 0, 0}, {0, 1, 0});
  scene.spin[3 * door + 1] = -2;  // with its velocity, it turns about the hinge
  scene.angle_limits = {TypeParam(-1), TypeParam(0.5)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 720);
  EXPECT_NEAR(scene.joint_angle[0], -1, 2e-3);
  EXPECT_LT(Length(scene.Spin(door)), 0.01);
}

TYPED_TEST(RigidJointTest, SliderFallsAlongItsAxisToItsLimit) {
  auto scene = Hanging<TypeParam>();
  const Vector axis = Vector{1, -1, 0} * std::sqrt(0.5);
  const uint32_t car = scene.AddBox({0.2, 0.2, 0.2}, 2, {0, -1, 0});
  scene.Join(JointType::kSlider, 0, car, {0, -1, 0}, axis);
  scene.travel_limits = {TypeParam(-1), TypeParam(2)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 120);  // g sin 45 t^2 / 2
  EXPECT_NEAR(scene.joint_travel[0], kG * std::sqrt(0.5) * 0.25 / 2, 0.01);
  EXPECT_LT(Length(scene.Spin(car)), 1e-3);
  engine.Advance(1.0 / 240, 480);
  EXPECT_NEAR(scene.joint_travel[0], 2, 2e-3);
  EXPECT_LT(Length(scene.Position(car) - Vector{0, -1, 0} - axis * 2.0), 5e-3);
}

TYPED_TEST(RigidJointTest, RopeIsAtMostAsLongAsItsLimit) {
  auto scene = Hanging<TypeParam>();
  const uint32_t weight = scene.AddBall(0.1, 1, {0.5, 0, 0});
  scene.Join(JointType::kDistance, 0, weight, {0, 0, 0});
  scene.travel_limits = {0, 2};
  PhysicsEngine engine = scene.MakeRigidEngine();
  double farthest = 0;
  for (int i = 0; i < 600; ++i) {
    engine.Advance(1.0 / 240);
    farthest = std::max(farthest, Length(scene.Position(weight)));
  }
  EXPECT_GT(farthest, 1.99);
  EXPECT_LT(farthest, 2.005);
}

TYPED_TEST(RigidJointTest, FreeJointedBodiesKeepTheirMomenta) {
  RigidScene<TypeParam> scene;
  scene.AddBox({1, 0.2, 0.4}, 2, {0, 0, 0}, {0, 1, 0});
  scene.AddBox({1, 0.3, 0.2}, 1, {1, 0, 0}, {0, 0, 2});
  scene.AddBox({1, 0.2, 0.2}, 3, {2, 0, 0}, {0, 0, 0});
  scene.Join(JointType::kBall, 0, 1, {0.5, 0, 0});
  scene.Join(JointType::kHinge, 1, 2, {1.5, 0, 0}, {0, 1, 0});
  const Vector momentum = scene.Momentum(), angular = scene.TotalAngularMomentum();
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 960);
  EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(1e4));
  EXPECT_LT(Length(scene.TotalAngularMomentum() - angular), 0.01 * Length(angular));
}

/// Returns a scene with a disc of the moment 1 kg m^2 on an axle of the type, at the spin [rad/s].
template <class Real>
RigidScene<Real> Turntable(double spin, JointType type = JointType::kHinge) {
  auto scene = Hanging<Real>();
  const uint32_t disc = scene.Add(rigid::ShapeCode::kCylinder, {1, 0.2, 1}, 8, {0, -1, 0});
  scene.Join(type, 0, disc, {0, -1, 0}, {0, 1, 0});
  scene.spin[3 * disc + 1] = Real(spin);
  return scene;
}

TYPED_TEST(RigidJointTest, DampedDiscSlowsExponentially) {
  for (const JointType type : {JointType::kHinge, JointType::kBall}) {
    auto scene = Turntable<TypeParam>(10, type);
    scene.joint_loads["angleDamping"] = {2};
    PhysicsEngine engine = scene.MakeRigidEngine();
    for (int i = 1; i <= 4; ++i) {
      engine.Advance(1.0 / 3840, 1920);
      EXPECT_NEAR(scene.Spin(1).y, 10 * std::exp(-2 * 0.5 * i), 2e-3) << "after " << 0.5 * i;
    }
  }
}

// The equation of motion is I x'' = -c x' - m g l x. The amplitude therefore decreases as exp(-c t
// / (2 I)).
TYPED_TEST(RigidJointTest, SwingOfADampedRodDecaysAsTheClosedForm) {
  auto scene = Hanging<TypeParam>();
  const double length = 1, tilt = 0.05, mass = 2, damping = 0.5;
  const double inertia = mass * length * length / 3;
  const uint32_t rod = scene.AddBox({0.001, length, 0.001}, mass,
                                    Vector{std::sin(tilt), -std::cos(tilt), 0} * (length / 2), {},
                                    {{0, 0, std::sin(tilt / 2)}, std::cos(tilt / 2)});
  scene.Join(JointType::kHinge, 0, rod, {0, 0, 0}, {0, 0, 1});
  scene.joint_loads["angleDamping"] = {TypeParam(damping)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  const double rate = damping / (2 * inertia);
  const double wave = std::sqrt(mass * kG * length / 2 / inertia - rate * rate);
  const double dt = 1.0 / 3840;
  for (int i = 1; i <= 3 * 3840; ++i) {
    engine.Advance(dt);
    const double t = i * dt;
    if (i % 960 != 0) continue;
    const double angle =
        tilt * std::exp(-rate * t) * (std::cos(wave * t) + rate / wave * std::sin(wave * t));
    EXPECT_NEAR(scene.Position(rod).x * 2 / length, angle, 0.01 * tilt) << "after " << t << " s";
  }
}

TYPED_TEST(RigidJointTest, DampedSliderFallsAtItsTerminalSpeed) {
  for (const double damping : {10.0, 1e4, 1e9}) {
    auto scene = Hanging<TypeParam>();
    const uint32_t car = scene.AddBox({0.2, 0.2, 0.2}, 2, {0, -1, 0});
    scene.Join(JointType::kSlider, 0, car, {0, -1, 0}, {0, -1, 0});
    scene.joint_loads["travelDamping"] = {TypeParam(damping)};
    PhysicsEngine engine = scene.MakeRigidEngine();
    engine.Advance(1.0 / 240, 480);
    const double speed = 2 * kG / damping;
    EXPECT_NEAR(scene.Velocity(car).y, -speed, 1e-4 * speed) << damping;
    EXPECT_LE(std::abs(scene.Position(car).y + 1), 2.02 * speed) << damping;
    EXPECT_NEAR(scene.joint_force[1], 2 * kG, 2e-3) << damping;
  }
}

TYPED_TEST(RigidJointTest, DryFrictionStopsADiscAndThenHoldsIt) {
  auto scene = Turntable<TypeParam>(3);
  scene.joint_loads["angleFriction"] = {2};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 960, 960);
  EXPECT_NEAR(scene.Spin(1).y, 1, 1e-3);
  engine.Advance(1.0 / 960, 960);
  EXPECT_LT(Length(scene.Spin(1)), 1e-5);
  EXPECT_NEAR(scene.joint_angle[0], 3 * 3 / (2 * 2.0), 5e-3);
}

// The torque of the weight is 2 g * 0.5 m = 9.81 N m.
TYPED_TEST(RigidJointTest, DryFrictionHoldsAnArmUpToItsTorque) {
  for (const double friction : {9.7, 9.9}) {
    auto scene = Hanging<TypeParam>();
    const uint32_t arm = scene.AddBox({1, 0.1, 0.1}, 2, {0.5, 0, 0});
    scene.Join(JointType::kHinge, 0, arm, {0, 0, 0}, {0, 0, 1});
    scene.joint_loads["angleFriction"] = {TypeParam(friction)};
    PhysicsEngine engine = scene.MakeRigidEngine();
    engine.Advance(1.0 / 960, 2880);
    EXPECT_EQ(std::abs(scene.joint_angle[0]) < 1e-3, friction > 9.81) << friction;
  }
}

TYPED_TEST(RigidJointTest, SpringOfAHingeSwingsWithItsPeriodAndKeepsItsEnergy) {
  auto scene = Turntable<TypeParam>(2);
  scene.joint_loads["angleStiffness"] = {100};
  scene.joint_loads["restAngle"] = {TypeParam(0.1)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  const double dt = 1.0 / 1920;
  for (int i = 1; i <= 20 * 1920; ++i) {  // 10 rad/s; 32 periods
    engine.Advance(dt);
    if (i % 1920 != 0) continue;
    const double angle = scene.joint_angle[0] - 0.1, spin = scene.Spin(1).y;
    // The error of the energy is at most 5 J * 10 rad/s * dt, and does not grow.
    EXPECT_NEAR(100 * angle * angle + spin * spin, 100 * 0.01 + 4, 50 * dt) << i * dt;
    const double t = i * dt;
    EXPECT_NEAR(angle, -0.1 * std::cos(10 * t) + 0.2 * std::sin(10 * t), 2e-3) << t;
  }
}

// The spring is a million times stiffer than an explicit step could integrate.
TYPED_TEST(RigidJointTest, StiffSpringHoldsAWeightWithoutGainingEnergy) {
  auto scene = Hanging<TypeParam>();
  const uint32_t car = scene.AddBox({0.2, 0.2, 0.2}, 2, {0, -1, 0}, {0, -1, 0});
  scene.Join(JointType::kSlider, 0, car, {0, -1, 0}, {0, -1, 0});
  scene.joint_loads["travelStiffness"] = {TypeParam(4e11)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  for (int i = 0; i < 480; ++i) {
    engine.Advance(1.0 / 240);
    ASSERT_LT(Length(scene.Velocity(car)), 1.001) << i;
  }
  EXPECT_NEAR(scene.Position(car).y, -1, 1e-4);
}

TYPED_TEST(RigidJointTest, SpringOfASliderStretchesByWeightPerStiffness) {
  auto scene = Hanging<TypeParam>();
  const uint32_t car = scene.AddBox({0.2, 0.2, 0.2}, 2, {0, -1, 0});
  scene.Join(JointType::kSlider, 0, car, {0, -1, 0}, {0, -1, 0});
  scene.joint_loads["travelStiffness"] = {200};
  scene.joint_loads["travelDamping"] = {40};
  scene.joint_loads["restTravel"] = {TypeParam(-0.05)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 720);
  EXPECT_NEAR(scene.joint_travel[0], 2 * kG / 200 - 0.05, 1e-4);
}

TYPED_TEST(RigidJointTest, RotorAddsItsInertiaToTheMotorOfAHingeAndToASlider) {
  auto scene = Turntable<TypeParam>(0);
  const uint32_t car = scene.AddBox({0.2, 0.2, 0.2}, 2, {1, -1, 0});
  scene.Join(JointType::kSlider, 0, car, {1, -1, 0}, {0, -1, 0});
  scene.motor_speed = {100, 0};
  scene.motor_torque = {6, 0};
  scene.joint_loads["rotorInertia"] = {3, 0};
  scene.joint_loads["rotorMass"] = {0, 6};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 960, 960);
  EXPECT_NEAR(scene.Spin(1).y, 6 / (1 + 3.0), 2e-3);
  EXPECT_NEAR(scene.Velocity(car).y, -kG * 2 / (2 + 6.0), 5e-3);
}

// The period of a rod about its end with a rotor: T = 2 pi sqrt((I + rotor) / (m g l)).
TYPED_TEST(RigidJointTest, RotorSlowsTheSwingOfARod) {
  auto scene = Hanging<TypeParam>();
  const double length = 1, tilt = 0.05, mass = 2, rotor = 0.4;
  const uint32_t rod = scene.AddBox({0.001, length, 0.001}, mass,
                                    Vector{std::sin(tilt), -std::cos(tilt), 0} * (length / 2), {},
                                    {{0, 0, std::sin(tilt / 2)}, std::cos(tilt / 2)});
  scene.Join(JointType::kHinge, 0, rod, {0, 0, 0}, {0, 0, 1});
  scene.joint_loads["rotorInertia"] = {TypeParam(rotor)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  const double dt = 1.0 / 1920;
  const double wave = std::sqrt(mass * kG * length / 2 / (mass * length * length / 3 + rotor));
  for (int i = 1; i <= 4 * 1920; ++i) {
    engine.Advance(dt);
    if (i % 480 != 0) continue;
    EXPECT_NEAR(scene.Position(rod).x * 2 / length, tilt * std::cos(wave * i * dt), 0.02 * tilt)
        << "after " << i * dt << " s";
  }
}

TYPED_TEST(RigidJointTest, MotorAgainstDampingAndFrictionReachesTheSpeedOfItsTorque) {
  auto scene = Turntable<TypeParam>(0);
  scene.motor_speed = {100};
  scene.motor_torque = {7};
  scene.joint_loads["angleDamping"] = {2};
  scene.joint_loads["angleFriction"] = {1};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 2400);
  EXPECT_NEAR(scene.Spin(1).y, (7 - 1) / 2.0, 1e-4);  // 7 = 1 + 2 * 3
  EXPECT_NEAR(scene.joint_torque[1], 0, 1e-3);
  scene.motor_speed = {2};  // which the torque can reach
  engine.Advance(1.0 / 240, 2400);
  EXPECT_NEAR(scene.Spin(1).y, 2, 1e-4);
}

TYPED_TEST(RigidJointTest, SpeedsOfJointsAreThoseOfTheirBodies) {
  auto scene = Turntable<TypeParam>(3);
  const uint32_t car = scene.AddBox({0.2, 0.2, 0.2}, 2, {1, -1, 0});
  scene.Join(JointType::kSlider, 0, car, {1, -1, 0}, {0, -1, 0});
  const uint32_t weight = scene.AddBall(0.1, 1, {2, -1, 0}, {0, -2, 0});
  scene.Join(JointType::kDistance, 0, weight, {2, 0, 0});
  scene.travel_limits[4] = 0;
  scene.travel_limits[5] = 100;
  scene.joint_loads["angleSpeed"] = {9, 9, 9};
  scene.joint_loads["travelSpeed"] = {9, 9, 9};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 240, 120);
  EXPECT_NEAR(scene.joint_loads["angleSpeed"][0], 3, 1e-5);
  EXPECT_EQ(scene.joint_loads["travelSpeed"][0], 0);
  EXPECT_NEAR(scene.joint_loads["travelSpeed"][1], kG * 0.5, 1e-4);
  EXPECT_EQ(scene.joint_loads["angleSpeed"][1], 0);
  EXPECT_NEAR(scene.joint_loads["travelSpeed"][2], 2 + kG * 0.5, 1e-4);
}

// The equation of motion is I x'' = kp (target - x) - kv x' with I = 1, kp = 100 and kv = 4. Its
// solution is a damped oscillation.
TYPED_TEST(RigidJointTest, ServoMovesADiscAsADampedSpring) {
  auto scene = Turntable<TypeParam>(0);
  scene.motor_torque = {1000};
  scene.joint_loads["motorAngle"] = {TypeParam(0.8)};
  scene.joint_loads["motorStiffness"] = {100};
  scene.joint_loads["motorDamping"] = {4};
  PhysicsEngine engine = scene.MakeRigidEngine();
  const double dt = 1.0 / 3840, rate = 2, wave = std::sqrt(100 - rate * rate);
  for (int i = 1; i <= 2 * 3840; ++i) {
    engine.Advance(dt);
    if (i % 384 != 0) continue;
    const double t = i * dt;
    const double angle =
        0.8 - 0.8 * std::exp(-rate * t) * (std::cos(wave * t) + rate / wave * std::sin(wave * t));
    EXPECT_NEAR(scene.joint_angle[0], angle, 4e-3) << "after " << t << " s";
  }
}

TYPED_TEST(RigidJointTest, ServoAcceleratesWithItsLargestTorqueThenStaysAtItsAngle) {
  auto scene = Turntable<TypeParam>(0);
  scene.motor_torque = {2};
  scene.joint_loads["motorAngle"] = {3};
  scene.joint_loads["motorStiffness"] = {TypeParam(1e7)};
  scene.joint_loads["motorDamping"] = {TypeParam(1e7)};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 960, 480);
  EXPECT_NEAR(scene.Spin(1).y, 1, 2e-3);  // 2 N m at 1 kg m^2
  EXPECT_NEAR(scene.joint_torque[1], 2, 1e-3);
  engine.Advance(1.0 / 960, 19 * 960);
  EXPECT_NEAR(scene.joint_angle[0], 3, 1e-4);
  EXPECT_LT(Length(scene.Spin(1)), 1e-3);
}

// The servo yields by its load divided by its stiffness, 9.81 N m / 200 N m.
TYPED_TEST(RigidJointTest, ServosHoldAnArmAndYieldToItsWeight) {
  for (const double friction : {0.0, 0.1}) {
    auto scene = Hanging<TypeParam>();
    const uint32_t arm = scene.AddBox({1, 0.1, 0.1}, 2, {0.5, 0, 0});
    scene.Join(JointType::kHinge, 0, arm, {0, 0, 0}, {0, 0, 1});
    scene.motor_torque = {50};
    scene.joint_loads["motorStiffness"] = {200};
    scene.joint_loads["motorDamping"] = {20};
    scene.joint_loads["angleFriction"] = {TypeParam(friction)};
    PhysicsEngine engine = scene.MakeRigidEngine();
    engine.Advance(1.0 / 960, 4800);
    const double yielded = 9.81 / 200 * std::cos(scene.joint_angle[0]);
    EXPECT_NEAR(scene.joint_angle[0], -yielded, friction / 200 + 1e-5) << friction;
    EXPECT_LT(Length(scene.Spin(arm)), 1e-5) << friction;
  }
}

TYPED_TEST(RigidJointTest, ServoOfASliderLiftsAWeightAndServosOfWheelsTurnTheShortWay) {
  auto scene = Turntable<TypeParam>(0);
  const uint32_t car = scene.AddBox({0.2, 0.2, 0.2}, 2, {1, -1, 0});
  scene.Join(JointType::kSlider, 0, car, {1, -1, 0}, {0, 1, 0});
  scene.motor_torque = {10, 0};
  scene.drive_force = {0, 100};
  scene.joint_loads["motorAngle"] = {TypeParam(1.5 * kPi), 0};
  scene.joint_loads["motorStiffness"] = {10, 0};
  scene.joint_loads["motorDamping"] = {6, 0};
  scene.joint_loads["driveTravel"] = {0, TypeParam(0.4)};
  scene.joint_loads["driveStiffness"] = {0, 400};
  scene.joint_loads["driveDamping"] = {0, 60};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 960, 9600);
  EXPECT_NEAR(scene.joint_angle[0], -0.5 * kPi, 1e-3);
  EXPECT_NEAR(scene.joint_travel[1], 0.4 - 2 * kG / 400, 1e-4);
}

// The speed of a motor with a finite gain follows from kv (5 - speed) = 2 speed.
TYPED_TEST(RigidJointTest, MotorWithDampingOnlyIsAProportionalSpeedControl) {
  auto scene = Turntable<TypeParam>(0);
  scene.motor_speed = {5};
  scene.motor_torque = {100};
  scene.joint_loads["motorDamping"] = {3};
  scene.joint_loads["angleDamping"] = {2};
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(1.0 / 960, 9600);
  EXPECT_NEAR(scene.Spin(1).y, 3, 1e-4);
}

TYPED_TEST(RigidJointTest, DampedFreeBodiesKeepTheirMomenta) {
  RigidScene<TypeParam> scene;
  scene.AddBox({1, 0.2, 0.4}, 2, {0, 0, 0}, {0, 1, 0});
  scene.AddBox({1, 0.3, 0.2}, 1, {1, 0, 0}, {0, 0, 2});
  scene.AddBox({1, 0.2, 0.2}, 3, {2, 0, 0}, {0, 0, 0});
  scene.Join(JointType::kBall, 0, 1, {0.5, 0, 0});
  scene.Join(JointType::kHinge, 1, 2, {1.5, 0, 0}, {0, 1, 0});
  scene.joint_loads["angleDamping"] = {1, 5};
  scene.joint_loads["angleStiffness"] = {0, 3};
  const Vector momentum = scene.Momentum(), angular = scene.TotalAngularMomentum();
  double energy = scene.TotalKineticEnergy();
  PhysicsEngine engine = scene.MakeRigidEngine();
  for (int i = 0; i < 4; ++i) {
    engine.Advance(1.0 / 240, 240);
    const double angle = scene.joint_angle[1], spring = 1.5 * angle * angle;
    EXPECT_LT(scene.TotalKineticEnergy() + spring, energy + 1e-6);
    energy = scene.TotalKineticEnergy() + spring;
  }
  EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(1e4));
  EXPECT_LT(Length(scene.TotalAngularMomentum() - angular), 0.01 * Length(angular));
}

}  // namespace
}  // namespace vesper
