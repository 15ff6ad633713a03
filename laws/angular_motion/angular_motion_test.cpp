// SPDX-License-Identifier: Apache-2.0
#include "scene.hpp"

namespace vesper {
namespace {

struct Rotation {
  Vec3<double> v;
  double w = 1;

  static Rotation About(const Vec3<double>& axis, double angle) {
    return {axis * (std::sin(angle / 2) / Length(axis)), std::cos(angle / 2)};
  }
  friend Rotation operator*(const Rotation& a, const Rotation& b) {
    return {a.v * b.w + b.v * a.w + Cross(a.v, b.v), a.w * b.w - Dot(a.v, b.v)};
  }
  Vec3<double> operator()(const Vec3<double>& x) const {
    const Vec3<double> t = Cross(v, x) * 2.0;
    return x + t * w + Cross(v, t);
  }
  Rotation Inverse() const { return {-v, w}; }
};

/// A body that rotates freely.
template <class Real>
struct Top {
  std::vector<Real> inertia, angular_velocity, orientation, torque{0, 0, 0};
  PhysicsEngine engine;

  Top(Vec3<Real> moments, Vec3<Real> spin, Rotation start = {}, const char* law = "angular_motion")
      : inertia{moments.x, moments.y, moments.z},
        angular_velocity{spin.x, spin.y, spin.z},
        orientation{Real(start.v.x), Real(start.v.y), Real(start.v.z), Real(start.w)},
        engine(std::is_same_v<Real, double> ? "si-f64" : "si-f32",
               {.threads = 1, .validate = true, .law_path = VESPER_LAW_PATH}) {
    PhysicalPropertyProvider provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("inertia", inertia);
    provider.AddPhysicalProperty("angularVelocity", angular_velocity);
    provider.AddPhysicalProperty("orientation", orientation);
    provider.AddPhysicalProperty("torque", torque);
    engine.LoadPhysicsLaw(law);
  }

  Rotation Attitude() const {
    return {{orientation[0], orientation[1], orientation[2]}, orientation[3]};
  }
  Vec3<double> InBody() const {
    return Attitude().Inverse()({angular_velocity[0], angular_velocity[1], angular_velocity[2]});
  }
  Vec3<double> MomentumInBody() const {
    const Vec3<double> spin = InBody();
    return {inertia[0] * spin.x, inertia[1] * spin.y, inertia[2] * spin.z};
  }
  Vec3<double> Momentum() const { return Attitude()(MomentumInBody()); }
  double Energy() const { return Dot(InBody(), MomentumInBody()) / 2; }
  double Norm() const {
    const Rotation q = Attitude();
    return std::sqrt(Dot(q.v, q.v) + q.w * q.w);
  }
};

const Rotation kTilted = Rotation::About({1, 2, -0.5}, 0.8);

template <class Real>
class AngularMotionTest : public ::testing::Test {};
TYPED_TEST_SUITE(AngularMotionTest, Precisions);

void ExpectNear(const Vec3<double>& a, const Vec3<double>& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

// The test follows Landau-Lifshitz section 33. The axis of a symmetric top precesses about L at |L|
// / I1, and the top rotates about its axis with the remainder of its spin.
TYPED_TEST(AngularMotionTest, FreeSymmetricTopPrecessesAsTheClosedFormSays) {
  for (const int axis : {0, 1, 2}) {
    std::vector<TypeParam> moments(3, 2);
    moments[axis] = 5;
    const Vec3<double> own{double(axis == 0), double(axis == 1), double(axis == 2)};
    Top<TypeParam> top({moments[0], moments[1], moments[2]}, {0.5, -1, 2}, kTilted);
    const Vec3<double> momentum = top.Momentum();
    const double along = Dot(top.MomentumInBody(), own);
    const uint32_t steps = 1000;
    const double dt = 1.0 / 256, time = steps * dt;
    top.engine.Advance(dt, steps);
    const Rotation expected = Rotation::About(momentum, Length(momentum) * time / 2) * kTilted *
                              Rotation::About(own, along * (1.0 / 5 - 1.0 / 2) * time);
    const double tolerance = Rounding<TypeParam>(steps * 16);
    ExpectNear(top.Attitude()({1, 0, 0}), expected({1, 0, 0}), tolerance);
    ExpectNear(top.Attitude()({0, 0, 1}), expected({0, 0, 1}), tolerance);
  }
}

TYPED_TEST(AngularMotionTest, FreeBodyKeepsMomentumEnergyAndTheLengthOfItsQuaternion) {
  Top<TypeParam> top({1, 2, 4}, {3, 2, -1}, kTilted);
  const Vec3<double> momentum = top.Momentum();
  const double energy = top.Energy();
  const double dt = 1.0 / 200;
  for (int i = 0; i < 100; ++i) {
    top.engine.Advance(dt, 200);
    ASSERT_NEAR(top.Norm(), 1, Rounding<TypeParam>(2));
    ASSERT_NEAR(top.Energy() / energy, 1, 2 * std::pow(4 * dt, 2) + Rounding<TypeParam>(20000));
    ExpectNear(top.Momentum(), momentum, Rounding<TypeParam>(60000 * Length(momentum)));
  }
}

// The test follows Landau-Lifshitz section 37. A body that rotates about its middle axis flips
// periodically, with the period of an elliptic function (the Dzhanibekov effect).
TYPED_TEST(AngularMotionTest, BodySpunAboutItsMiddleAxisTurnsOverWithThePeriodOfTheClosedForm) {
  Top<TypeParam> top({1, 2, 3}, {0, 10, 0.5});
  const double energy2 = 2 * top.Energy(), m2 = std::pow(Length(top.Momentum()), 2);
  const double k2 = (2 - 1) * (energy2 * 3 - m2) / ((3 - 2) * (m2 - energy2 * 1));
  const double period =
      4 * std::comp_ellint_1(std::sqrt(k2)) * std::sqrt(1 * 2 * 3 / ((3 - 2) * (m2 - energy2 * 1)));
  const double dt = 1.0 / 2000;
  std::vector<double> turns;  // times at which the middle axis is perpendicular to the spin
  double before = top.InBody().y;
  for (uint32_t step = 1; turns.size() < 5; ++step) {
    ASSERT_LT(step * dt, 4 * period) << "does not turn over";
    top.engine.Advance(dt);
    const double now = top.InBody().y;
    if (before * now < 0) turns.push_back((step - now / (now - before)) * dt);
    before = now;
  }
  const double tolerance = std::is_same_v<TypeParam, double> ? 1e-4 : 1e-2;
  EXPECT_NEAR(turns[2] - turns[0], period, tolerance * period);
  EXPECT_NEAR(turns[4] - turns[2], period, tolerance * period);
}

TYPED_TEST(AngularMotionTest, SpinAboutTheOuterAxesIsStable) {
  for (const Vec3<TypeParam> spin : {Vec3<TypeParam>{10, 0.5, 0}, Vec3<TypeParam>{0, 0.5, 10}}) {
    Top<TypeParam> top({1, 2, 3}, spin);
    for (int i = 0; i < 1000; ++i) {
      top.engine.Advance(1.0 / 200, 2);
      const Vec3<double> in_body = top.InBody();
      ASSERT_GT(spin.x > spin.z ? in_body.x : in_body.z, 9.9);
    }
  }
}

/// Torques applied by the client; the standard prototypes have no such property.
constexpr const char* kDriven = R"(
time [s]
body inertia: real x3 [kg*m^2] read
body appliedTorque: real x3 [N*m] read
body torque: real x3 [N*m] accumulate from appliedTorque
body angularVelocity: real x3 [rad/s] read_write
body orientation: real x4 [1] read_write
)";

// Semi-implicit Euler gives w = t tau / I and angle = t (t + dt) tau / I / 2.
TYPED_TEST(AngularMotionTest, ConstantTorqueSpinsUpAsTheSchemeSays) {
  const std::string real = std::is_same_v<TypeParam, double> ? "real f64" : "real f32";
  const LoadedPrototype prototype("prototype driven\n" + real + kDriven, "driven");
  PhysicsEngine engine(prototype.get(), {.validate = true, .law_path = VESPER_LAW_PATH});
  std::vector<TypeParam> inertia{4, 2, 2}, applied{6, 0, 0}, torque{0, 0, 0}, spin{0, 0, 0},
      orientation{0, 0, 0, 1};
  PhysicalPropertyProvider provider = engine.PropertyProvider();
  provider.AddPhysicalProperty("inertia", inertia);
  provider.AddPhysicalProperty("appliedTorque", applied);
  provider.AddPhysicalProperty("torque", torque);
  provider.AddPhysicalProperty("angularVelocity", spin);
  provider.AddPhysicalProperty("orientation", orientation);
  engine.LoadPhysicsLaw("angular_motion");
  const uint32_t steps = 240;
  const double dt = 1.0 / 240, time = steps * dt;
  engine.Advance(dt, steps);
  EXPECT_NEAR(spin[0], 1.5, Rounding<TypeParam>(steps * 16));
  const double half = 1.5 * time * (time + dt) / 4;
  EXPECT_NEAR(orientation[0], std::sin(half), Rounding<TypeParam>(steps * 16));
  EXPECT_NEAR(orientation[3], std::cos(half), Rounding<TypeParam>(steps * 16));
}

TYPED_TEST(AngularMotionTest, BodyWithAMomentOfZeroKeepsItsBits) {
  Top<TypeParam> top({0, 1, 1}, {1, 2, 3}, kTilted);
  const auto orientation = top.orientation;
  top.engine.Advance(0.01, 10);
  EXPECT_EQ(top.orientation, orientation);
  EXPECT_EQ(top.angular_velocity, (std::vector<TypeParam>{1, 2, 3}));
}

/// Adds linear motion to the rotating body of `top`, with the columns of `scene`, which must
/// outlive it.
template <class Real>
void AddMotion(Top<Real>& top, Scene<Real>& scene) {
  PhysicalPropertyProvider provider = top.engine.PropertyProvider();
  provider.AddPhysicalProperty("mass", scene.mass);
  provider.AddPhysicalProperty("position", scene.position);
  provider.AddPhysicalProperty("velocity", scene.velocity);
  provider.AddPhysicalProperty("externalForce", scene.external_force);
}

TYPED_TEST(AngularMotionTest, BodyOfMassZeroTurnsAboutItsImmovableCentre) {
  Scene<TypeParam> scene;
  scene.AddBody(0, {1, 2, 3}, {1, 0, 0});
  Top<TypeParam> top({1, 1, 1}, {0, 0, 2});
  AddMotion(top, scene);
  top.engine.LoadPhysicsLaw("newton_motion");
  top.engine.Advance(1.0 / 256, 256);
  EXPECT_EQ(scene.position, (std::vector<TypeParam>{1, 2, 3}));
  EXPECT_NEAR(top.orientation[2], std::sin(1.0), Rounding<TypeParam>(1000));
}

TYPED_TEST(AngularMotionTest, TurnsBesideTheIntegratorsOfOneStageAndIsRefusedBesideOthers) {
  Scene<TypeParam> scene;
  scene.AddBody(1, {}, {1, 0, 0});
  Top<TypeParam> top({1, 1, 1}, {0, 0, 2});
  AddMotion(top, scene);
  EXPECT_THROW(top.engine.LoadPhysicsLaw("runge_kutta4"), Error);
  for (const char* law : {"newton_motion", "velocity_verlet"}) {
    scene.position = {0, 0, 0};
    top.orientation = {0, 0, 0, 1};
    const vesper_library_id id = top.engine.LoadPhysicsLaw(law);
    top.engine.Advance(1.0 / 256, 256);
    top.engine.UnloadPhysicsLaw(id);
    EXPECT_EQ(scene.position[0], 1) << law;
    EXPECT_NEAR(top.orientation[2], std::sin(1.0), Rounding<TypeParam>(1000)) << law;
  }
}

// The text computes the same rotations. It uses another order of operations, and sine and cosine.
TYPED_TEST(AngularMotionTest, TextGivesTheSameMotion) {
  const Vec3<TypeParam> moments[] = {{1, 2, 3}, {3, 1, 2}, {2, 3, 1}, {5, 2, 2}, {2, 2, 5},
                                     {2, 5, 2}, {2, 2, 2}, {4, 4, 1}, {0, 2, 3}};
  for (const Vec3<TypeParam>& each : moments) {
    Top<TypeParam> compiled(each, {1, -0.5, 0.75}, kTilted);
    Top<TypeParam> text(each, {1, -0.5, 0.75}, kTilted, "angular_motion.law");
    for (Top<TypeParam>* top : {&compiled, &text}) {
      top->torque = {0.25, -1, 0.5};
      top->engine.Advance(1.0 / 512, 512);
    }
    for (size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(text.orientation[i], compiled.orientation[i], Rounding<TypeParam>(4000)) << i;
    }
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(text.angular_velocity[i], compiled.angular_velocity[i],
                  Rounding<TypeParam>(4000));
    }
  }
}

}  // namespace
}  // namespace vesper
