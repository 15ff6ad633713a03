// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "scene.hpp"

namespace vesper {
namespace {

/// Charges; k = 1 by default.
template <class Real>
struct Charges : Scene<Real> {
  std::vector<Real> charge;                  // (bodies) [C]
  std::vector<Real> coulomb_constant = {1};  // (1) [N m^2/C^2]
  std::vector<Real> softening = {0};         // (1) [m]

  void Add(Real m, Real q, Vec3<Real> at, Vec3<Real> moving = {}) {
    this->AddBody(m, at, moving);
    charge.push_back(q);
  }

  PhysicsEngine MakeEngine(const char* integrator = nullptr, double fast = 0) {
    PhysicsEngine engine = Scene<Real>::MakeEngine();
    engine.PropertyProvider().AddPhysicalProperty("charge", charge);
    engine.PropertyProvider().AddPhysicalProperty("coulombConstant", coulomb_constant);
    engine.PropertyProvider().AddPhysicalProperty("softening", softening);
    engine.LoadPhysicsLaw("coulomb", {{"fast", fast}});
    if (integrator != nullptr) engine.LoadPhysicsLaw(integrator);
    return engine;
  }

  Vec3<double> Place(uint64_t row) const { return this->Wide(this->At(this->position, row)); }
  Vec3<double> Force(uint64_t row) const { return this->Wide(this->At(this->external_force, row)); }
};

template <class Real>
class CoulombTest : public ::testing::Test {
 protected:
  static double Single(double f32, double f64) { return sizeof(Real) == 4 ? f32 : f64; }
};
TYPED_TEST_SUITE(CoulombTest, Precisions);

TYPED_TEST(CoulombTest, LikeChargesRepelByTheInverseSquare) {
  Charges<TypeParam> charges;
  charges.coulomb_constant = {TypeParam(8.9875517923e9)};
  charges.Add(1, TypeParam(2e-6), {1, 0, 0});
  charges.Add(1, TypeParam(3e-6), {1, 4, 0});
  const double f = 8.9875517923e9 * 2e-6 * 3e-6 / 16;
  for (const double fast : {0, 1}) {
    PhysicsEngine engine = charges.MakeEngine(nullptr, fast);
    engine.Advance(0.01);
    EXPECT_NEAR(charges.external_force[1], -f, Rounding<TypeParam>(8 * f)) << "fast " << fast;
    EXPECT_NEAR(charges.external_force[4], f, Rounding<TypeParam>(8 * f)) << "fast " << fast;
  }
}

TYPED_TEST(CoulombTest, UnlikeChargesAttract) {
  Charges<TypeParam> charges;
  charges.Add(1, -2, {0, 0, 0});
  charges.Add(1, 3, {0, 0, 1});
  PhysicsEngine engine = charges.MakeEngine();
  engine.Advance(0.01);
  EXPECT_NEAR(charges.external_force[2], 6, Rounding<TypeParam>(24));
  EXPECT_NEAR(charges.external_force[5], -6, Rounding<TypeParam>(24));
}

TYPED_TEST(CoulombTest, SofteningKeepsTheForceFinite) {
  Charges<TypeParam> charges;
  charges.softening = {4};
  charges.Add(1, 1, {0, 0, 0});
  charges.Add(1, 125, {3, 0, 0});
  PhysicsEngine engine = charges.MakeEngine();
  engine.Advance(0.01);
  EXPECT_NEAR(charges.external_force[0], -3, Rounding<TypeParam>(12));
}

TYPED_TEST(CoulombTest, MassZeroPushesAndIsPushedButNeverMoves) {
  Charges<TypeParam> charges;
  charges.Add(0, 2, {0, 0, 0});
  charges.Add(1, 3, {0, 0, 1});
  PhysicsEngine engine = charges.MakeEngine("newton_motion");
  engine.Advance(0.25);
  EXPECT_NEAR(charges.external_force[2], -6, Rounding<TypeParam>(24));
  EXPECT_NEAR(charges.external_force[5], 6, Rounding<TypeParam>(24));
  EXPECT_EQ(charges.At(charges.position, 0), (Vec3<TypeParam>{0, 0, 0}));
  EXPECT_NEAR(charges.velocity[5], 1.5, Rounding<TypeParam>(6));
}

TYPED_TEST(CoulombTest, BodiesWithoutChargeFeelNothing) {
  Charges<TypeParam> charges;
  charges.Add(1, 0, {0, 0, 0});
  charges.Add(1, 5, {1, 0, 0});
  PhysicsEngine engine = charges.MakeEngine();
  engine.Advance(0.01);
  EXPECT_EQ(charges.external_force, std::vector<TypeParam>(6, 0));
}

// Four charges q at the corners of a square around -q (1 + 2 sqrt 2) / 4: every force is zero.
TYPED_TEST(CoulombTest, ChargesOfASquareBalanceTheOneAtItsCentre) {
  using Real = TypeParam;
  Charges<Real> charges;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) charges.Add(1, 1, {Real(x), Real(y), 0});
  }
  charges.Add(1, Real(-(1 + 2 * std::sqrt(2.0)) / 4), {0, 0, 0});
  PhysicsEngine engine = charges.MakeEngine();
  engine.Advance(0.01);
  for (int i = 0; i < 5; ++i) EXPECT_LT(Length(charges.Force(i)), Rounding<Real>(8)) << i;
}

// By Gauss's law, the field outside of a uniform shell is that of its charge at the centre. The
// field inside is zero.
TYPED_TEST(CoulombTest, ShellActsAsGaussSays) {
  using Real = TypeParam;
  const int shell = 2000;
  Charges<Real> charges;
  charges.Add(1, 1, {Real(0.2), Real(-0.1), Real(0.3)});
  charges.Add(1, 1, {0, 5, 0});
  for (int i = 0; i < shell; ++i) {  // on a Fibonacci spiral
    const double z = 1 - (2 * i + 1.0) / shell, r = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    charges.Add(1, Real(1.0 / shell),
                {Real(r * std::cos(angle)), Real(r * std::sin(angle)), Real(z)});
  }
  PhysicsEngine engine = charges.MakeEngine();
  engine.Advance(0.01);
  const Vec3<double> away = charges.Place(0) - charges.Place(1);  // subtracts the force of the
                                                                  // other probe
  const double cube = std::pow(Length(away), 3);
  EXPECT_LT(Length(charges.Force(0) - away * (1 / cube)), 1e-3);
  EXPECT_LT(Length(charges.Force(1) + away * (1 / cube) - Vec3<double>{0, 1 / 25.0, 0}), 1e-5);
}

// The speed of a circular orbit follows from m v^2 / r = k q q' / r^2.
TYPED_TEST(CoulombTest, ChargeCirclesAnImmovableOneInTheClosedFormsPeriod) {
  using Real = TypeParam;
  Charges<Real> charges;
  charges.Add(0, 4, {0, 0, 0});
  charges.Add(1, -1, {1, 0, 0}, {0, 2, 0});
  PhysicsEngine engine = charges.MakeEngine("runge_kutta4");
  engine.Advance(std::numbers::pi / 1000, 1000);
  EXPECT_NEAR(Length(charges.Place(1) - Vec3<double>{1, 0, 0}), 0, this->Single(1e-4, 1e-9));
  EXPECT_EQ(charges.Place(0), Vec3<double>{});
}

// A charge that approaches another one head-on turns back where its kinetic energy equals k q q' /
// r.
TYPED_TEST(CoulombTest, ChargeTurnsAtTheClosestApproach) {
  using Real = TypeParam;
  Charges<Real> charges;
  charges.Add(0, 1, {0, 0, 0});
  charges.Add(2, 1, {8, 0, 0}, {-1, 0, 0});
  const double closest = 1 / (0.5 * 2 * 1 * 1 + 1 / 8.0);
  PhysicsEngine engine = charges.MakeEngine("velocity_verlet");
  double least = 8;
  for (int i = 0; i < 12000; ++i) {
    engine.Advance(0.001);
    least = std::min(least, double{charges.position[3]});
  }
  EXPECT_NEAR(least, closest, 1e-4);
  EXPECT_GT(charges.velocity[3], 0);
}

}  // namespace
}  // namespace vesper
