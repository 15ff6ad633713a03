// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "scene.hpp"

namespace vesper {
namespace {

/// Bodies that attract each other; G = 1 by default.
template <class Real>
struct Heavens : Scene<Real> {
  std::vector<Real> gravitational_constant = {1};  // (1) [m^3/(kg s^2)]
  std::vector<Real> softening = {0};               // (1) [m]

  PhysicsEngine MakeEngine(const char* integrator = nullptr, double fast = 0,
                           uint32_t threads = 1) {
    PhysicsEngine engine = Scene<Real>::MakeEngine(threads);
    engine.PropertyProvider().AddPhysicalProperty("gravitationalConstant", gravitational_constant);
    engine.PropertyProvider().AddPhysicalProperty("softening", softening);
    engine.LoadPhysicsLaw("newton_gravitation", {{"fast", fast}});
    if (integrator != nullptr) engine.LoadPhysicsLaw(integrator);
    return engine;
  }

  Vec3<double> Place(uint64_t row) const { return this->Wide(this->At(this->position, row)); }
  Vec3<double> Force(uint64_t row) const { return this->Wide(this->At(this->external_force, row)); }

  /// Returns kinetic energy plus the sum of -G m m' / sqrt(r^2 + softening^2).
  double Energy() const {
    double energy = this->KineticEnergy();
    for (uint64_t i = 0; i < this->mass.size(); ++i) {
      for (uint64_t j = 0; j < i; ++j) {
        const Vec3<double> d = Place(i) - Place(j);
        energy -= double{gravitational_constant[0]} * this->mass[i] * this->mass[j] /
                  std::sqrt(Dot(d, d) + double{softening[0]} * softening[0]);
      }
    }
    return energy;
  }
};

template <class Real>
class NewtonGravitationTest : public ::testing::Test {
 protected:
  /// Returns two bodies of 3 kg and 1 kg at their minimum distance of 1 m, on an orbit of this
  /// eccentricity about their centre of mass at rest.
  static Heavens<Real> Pair(double eccentricity) {
    const double speed = std::sqrt(4 * (1 + eccentricity));  // relative speed
    Heavens<Real> heavens;
    heavens.AddBody(3, {Real(-0.25), 0, 0}, {0, Real(-0.25 * speed), 0});
    heavens.AddBody(1, {Real(0.75), 0, 0}, {0, Real(0.75 * speed), 0});
    return heavens;
  }
  static double Single(double f32, double f64) { return sizeof(Real) == 4 ? f32 : f64; }
};
TYPED_TEST_SUITE(NewtonGravitationTest, Precisions);

TYPED_TEST(NewtonGravitationTest, PairAttractsByTheInverseSquare) {
  Heavens<TypeParam> heavens;
  heavens.gravitational_constant = {8};
  heavens.AddBody(2, {1, 1, 1});
  heavens.AddBody(3, {1, 5, 1});
  PhysicsEngine engine = heavens.MakeEngine();
  engine.Advance(0.01);
  EXPECT_NEAR(heavens.external_force[1], 3, Rounding<TypeParam>(12));
  EXPECT_NEAR(heavens.external_force[4], -3, Rounding<TypeParam>(12));
  for (const int other : {0, 2, 3, 5}) EXPECT_EQ(heavens.external_force[other], 0);
}

TYPED_TEST(NewtonGravitationTest, SofteningIsThatOfPlummer) {
  Heavens<TypeParam> heavens;
  heavens.softening = {4};
  heavens.AddBody(1, {0, 0, 0});
  heavens.AddBody(125, {3, 0, 0});
  PhysicsEngine engine = heavens.MakeEngine();
  engine.Advance(0.01);
  EXPECT_NEAR(heavens.external_force[0], 3, Rounding<TypeParam>(12));  // 125 * 3 / (9 + 16)^1.5
}

TYPED_TEST(NewtonGravitationTest, WithoutASofteningPropertyNothingIsSoftened) {
  Heavens<TypeParam> heavens;
  heavens.softening = {4};
  heavens.AddBody(1, {0, 0, 0});
  heavens.AddBody(4, {2, 0, 0});
  PhysicsEngine engine = heavens.MakeEngine();
  engine.PropertyProvider().RemovePhysicalProperty("softening");
  engine.Advance(0.01);
  EXPECT_NEAR(heavens.external_force[0], 1, Rounding<TypeParam>(4));
}

// The period follows from Kepler's third law, T^2 = 4 pi^2 a^3 / (G (m + m')).
TYPED_TEST(NewtonGravitationTest, PeriodOfAnEllipseIsKeplers) {
  const double eccentricity = 0.5, axis = 1 / (1 - eccentricity);
  const double period = 2 * std::numbers::pi * std::sqrt(axis * axis * axis / 4);
  auto heavens = this->Pair(eccentricity);
  PhysicsEngine engine = heavens.MakeEngine("runge_kutta4");
  engine.Advance(period / 2000, 2000);
  EXPECT_NEAR(Length(heavens.Place(1) - Vec3<double>{0.75, 0, 0}), 0, this->Single(2e-4, 1e-8));
  EXPECT_NEAR(Length(heavens.Place(0) - Vec3<double>{-0.25, 0, 0}), 0, this->Single(1e-4, 1e-8));
}

TYPED_TEST(NewtonGravitationTest, EnergyDoesNotDriftOverAThousandOrbits) {
  const double eccentricity = 0.3, axis = 1 / (1 - eccentricity);
  const double period = 2 * std::numbers::pi * std::sqrt(axis * axis * axis / 4);
  auto heavens = this->Pair(eccentricity);
  PhysicsEngine engine = heavens.MakeEngine("velocity_verlet");
  // Compares means over one orbit, because the energy oscillates within an orbit by an amount of
  // the order of dt^2. The ellipse precesses, so single samples would have different phases of this
  // oscillation.
  const auto mean = [&] {
    double sum = 0;
    for (int i = 0; i < 100; ++i) {
      engine.Advance(period / 100);
      sum += heavens.Energy();
    }
    return sum / 100;
  };
  const double first = mean();
  for (int orbit = 0; orbit < 998; ++orbit) engine.Advance(period / 100, 100);
  EXPECT_NEAR(mean() / first, 1, this->Single(1e-3, 1e-4));
}

// Three equal masses can move on one curve (C. Moore 1993; A. Chenciner and R. Montgomery 2000).
TYPED_TEST(NewtonGravitationTest, ThreeBodiesDanceTheFigureEight) {
  using Real = TypeParam;
  const Vec3<Real> at{Real(0.97000436), Real(-0.24308753), 0};
  const Vec3<Real> moving{Real(-0.93240737), Real(-0.86473146), 0};
  Heavens<Real> heavens;
  heavens.AddBody(1, at, moving * Real(-0.5));
  heavens.AddBody(1, -at, moving * Real(-0.5));
  heavens.AddBody(1, {}, moving);
  PhysicsEngine engine = heavens.MakeEngine("runge_kutta4");
  const double period = 6.32591398;
  engine.Advance(period / 3000, 1000);  // each body is at the initial place of another
  EXPECT_NEAR(
      Length(heavens.Place(2) - heavens.Wide(at)) * Length(heavens.Place(2) + heavens.Wide(at)), 0,
      this->Single(1e-4, 1e-6));
  engine.Advance(period / 3000, 2000);
  EXPECT_NEAR(Length(heavens.Place(0) - heavens.Wide(at)), 0, this->Single(1e-4, 1e-6));
  EXPECT_NEAR(Length(heavens.Place(2)), 0, this->Single(1e-4, 1e-6));
}

// Any three masses can rotate as an equilateral triangle with omega^2 = G M / a^3 (J.-L. Lagrange
// 1772).
TYPED_TEST(NewtonGravitationTest, LagrangesTriangleTurnsAsARigidBody) {
  using Real = TypeParam;
  const double masses[] = {1, 2, 3}, omega = std::sqrt(6.0), side = 1;
  const Vec3<double> corners[] = {{0, 0, 0}, {side, 0, 0}, {side / 2, side * std::sqrt(0.75), 0}};
  Vec3<double> centre;
  for (int i = 0; i < 3; ++i) centre += corners[i] * (masses[i] / 6);
  Heavens<Real> heavens;
  for (int i = 0; i < 3; ++i) {
    const Vec3<double> r = corners[i] - centre;
    heavens.AddBody(Real(masses[i]), {Real(r.x), Real(r.y), 0},
                    {Real(-omega * r.y), Real(omega * r.x), 0});
  }
  PhysicsEngine engine = heavens.MakeEngine("runge_kutta4");
  const double period = 2 * std::numbers::pi / omega;
  engine.Advance(period / 1000, 500);  // unstable for such masses, so only half a revolution
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(Length(heavens.Place(i) - heavens.Place((i + 1) % 3)), side,
                this->Single(1e-4, 1e-9));
    EXPECT_NEAR(Length(heavens.Place(i) + (corners[i] - centre)), 0, this->Single(1e-4, 1e-9));
  }
}

TYPED_TEST(NewtonGravitationTest, ClusterKeepsMomentumAndAngularMomentum) {
  auto heavens = Heavens<TypeParam>{RandomNetwork<TypeParam>(100, 31)};
  heavens.mass[0] = 2;
  heavens.softening = {1};
  PhysicsEngine engine = heavens.MakeEngine("newton_motion");
  const Vec3<double> momentum = heavens.Momentum(), angular = heavens.AngularMomentum();
  const double energy = heavens.Energy();
  engine.Advance(1.0 / 240, 240);
  EXPECT_LT(Length(heavens.Momentum() - momentum), Rounding<TypeParam>(20000));
  EXPECT_LT(Length(heavens.AngularMomentum() - angular), Rounding<TypeParam>(200000));
  EXPECT_NEAR(heavens.Energy() / energy, 1, 0.02);
}

TYPED_TEST(NewtonGravitationTest, FastModeMovesAClusterAsTheDefaultDoes) {
  auto exact = Heavens<TypeParam>{RandomNetwork<TypeParam>(100, 31)};
  exact.softening = {1};
  auto fast = exact;
  const Vec3<double> momentum = fast.Momentum(), angular = fast.AngularMomentum();
  exact.MakeEngine("newton_motion").Advance(1.0 / 240, 240);
  fast.MakeEngine("newton_motion", 1).Advance(1.0 / 240, 240);
  for (uint64_t i = 0; i < exact.mass.size(); ++i) {
    EXPECT_NEAR(Length(fast.Place(i) - exact.Place(i)), 0, Rounding<TypeParam>(200))
        << "body " << i;
  }
  EXPECT_LT(Length(fast.Momentum() - momentum), Rounding<TypeParam>(20000));
  EXPECT_LT(Length(fast.AngularMomentum() - angular), Rounding<TypeParam>(200000));
}

TYPED_TEST(NewtonGravitationTest, FastModeGivesTheSameBitsForAnyNumberOfThreads) {
  auto one = Heavens<TypeParam>{RandomNetwork<TypeParam>(1000, 32)};
  auto three = one;
  one.MakeEngine("newton_motion", 1, 1).Advance(1.0 / 240, 3);
  three.MakeEngine("newton_motion", 1, 3).Advance(1.0 / 240, 3);
  EXPECT_EQ(one.position, three.position);
}

// Masses and lengths in SI units have very different magnitudes. Their products and cubes exceed
// the range of float.
TYPED_TEST(NewtonGravitationTest, SunPullsEarthAndNeptune) {
  using Real = TypeParam;
  const double g = 6.6743e-11, sun = 1.98847e30, earth = 5.9722e24, neptune = 1.02413e26;
  const double to_earth = 1.495978707e11, to_neptune = 4.498e12;
  Heavens<Real> heavens;
  heavens.gravitational_constant = {Real(g)};
  heavens.AddBody(Real(sun), {0, 0, 0});
  heavens.AddBody(Real(earth), {Real(to_earth), 0, 0});
  heavens.AddBody(Real(neptune), {0, 0, Real(to_neptune)});
  PhysicsEngine engine = heavens.MakeEngine();
  engine.Advance(1);
  const auto pull = [&](double m, double other, double x, double z) {
    return g * m * other / (x * x + z * z) / std::hypot(x, z);
  };
  const double x = -pull(sun, earth, to_earth, 0) * to_earth -
                   pull(earth, neptune, to_earth, to_neptune) * to_earth;
  EXPECT_NEAR(heavens.Force(1).x / x, 1, Rounding<Real>(8));
  const double z = -pull(sun, neptune, 0, to_neptune) * to_neptune -
                   pull(earth, neptune, to_earth, to_neptune) * to_neptune;
  EXPECT_NEAR(heavens.Force(2).z / z, 1, Rounding<Real>(8));
}

TYPED_TEST(NewtonGravitationTest, MassZeroNeitherPullsNorIsPulled) {
  Heavens<TypeParam> heavens;
  heavens.AddBody(0, {0, 0, 0});
  heavens.AddBody(5, {1, 0, 0});
  PhysicsEngine engine = heavens.MakeEngine();
  engine.Advance(0.01);
  EXPECT_EQ(heavens.external_force, std::vector<TypeParam>(6, 0));
}

TYPED_TEST(NewtonGravitationTest, BodiesAtOnePlaceExertNoForceOnEachOther) {
  Heavens<TypeParam> heavens;
  heavens.AddBody(1, {1, 2, 3});
  heavens.AddBody(1, {1, 2, 3});
  heavens.AddBody(1, {1, 2, 5});
  PhysicsEngine engine = heavens.MakeEngine();
  engine.Advance(0.01);
  const double f = 0.25, rounding = Rounding<TypeParam>(2);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(Length(heavens.Force(i) - Vec3<double>{0, 0, f}), 0, rounding) << "body " << i;
  }
  EXPECT_NEAR(Length(heavens.Force(2) - Vec3<double>{0, 0, -2 * f}), 0, rounding);
}

TYPED_TEST(NewtonGravitationTest, WorldWithoutItsConstantHasNoForce) {
  Heavens<TypeParam> heavens;
  heavens.gravitational_constant = {};
  heavens.softening = {};
  heavens.gravity = {};
  heavens.AddBody(1, {0, 0, 0});
  heavens.AddBody(1, {1, 0, 0});
  PhysicsEngine engine = heavens.MakeEngine();
  engine.Advance(0.01);
  EXPECT_EQ(heavens.external_force, std::vector<TypeParam>(6, 0));
}

}  // namespace
}  // namespace vesper
