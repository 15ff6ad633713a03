// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numbers>
#include <numeric>

#include "scene.hpp"
#include "vesper/kit/law_file.hpp"

namespace vesper {
namespace {

constexpr uint32_t kSeed = 5;

/// Bodies that attract each other; G = 1 by default.
template <class Real>
struct Cloud : Scene<Real> {
  std::vector<Real> gravitational_constant = {1};  // (1) [m^3/(kg s^2)]
  std::vector<Real> softening = {0};               // (1) [m]

  PhysicsEngine MakeEngine(double theta, uint32_t threads = 1) {
    PhysicsEngine engine = Scene<Real>::MakeEngine(threads);
    engine.PropertyProvider().AddPhysicalProperty("gravitationalConstant", gravitational_constant);
    engine.PropertyProvider().AddPhysicalProperty("softening", softening);
    engine.LoadPhysicsLaw("barnes_hut_gravitation", {{"theta", theta}});
    return engine;
  }

  /// Returns the forces [N] on all bodies.
  std::vector<Real> Forces(double theta, uint32_t threads = 1) {
    MakeEngine(theta, threads).Advance(1);
    return this->external_force;
  }

  uint64_t size() const { return this->mass.size(); }
  Vec3<double> Position(uint64_t i) const { return this->Wide(this->At(this->position, i)); }
  Vec3<double> Force(uint64_t i) const { return this->Wide(this->At(this->external_force, i)); }

  /// Returns the force [N] on one body, summed over all others in double.
  Vec3<double> Direct(uint64_t i) const {
    Vec3<double> sum;
    for (uint64_t j = 0; j < size(); ++j) {
      const Vec3<double> d = Position(j) - Position(i);
      if (Dot(d, d) == 0) continue;
      sum += d * (double{this->mass[j]} * std::pow(Dot(d, d) + Softening2(), -1.5));
    }
    return sum * (double{gravitational_constant[0]} * double{this->mass[i]});
  }

  /// Returns the potential energy [J], summed over all pairs.
  double Potential() const {
    double sum = 0;
    for (uint64_t i = 0; i < size(); ++i) {
      for (uint64_t j = 0; j < i; ++j) {
        const Vec3<double> d = Position(j) - Position(i);
        const double square = Dot(d, d) + Softening2();
        if (square > 0) sum -= double{this->mass[i]} * double{this->mass[j]} / std::sqrt(square);
      }
    }
    return double{gravitational_constant[0]} * sum;
  }

  double Softening2() const { return double{softening[0]} * double{softening[0]}; }
};

class Random {
 public:
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  Vec3<double> Direction() {
    const double z = Uniform(-1, 1), angle = Uniform(0, 2 * std::numbers::pi);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

 private:
  std::mt19937_64 random_{kSeed};
};

template <class Real>
Vec3<Real> To(Vec3<double> v) {
  return {Real(v.x), Real(v.y), Real(v.z)};
}

/// Returns an H. C. Plummer sphere of mass 1 kg and radius 1 m in equilibrium, by S. Aarseth, M.
/// Henon and R. Wielen, Astron. Astrophys. 37 (1974) 183.
template <class Real>
Cloud<Real> Plummer(uint64_t bodies) {
  Random random;
  Cloud<Real> cloud;
  for (uint64_t i = 0; i < bodies; ++i) {
    const double r = 1 / std::sqrt(std::pow(random.Uniform(0.001, 0.99), -2.0 / 3) - 1);
    double q = 0, height = 1;
    while (height > q * q * std::pow(1 - q * q, 3.5)) {
      q = random.Uniform(0, 1);
      height = random.Uniform(0, 0.1);
    }
    const double speed = q * std::sqrt(2.0) * std::pow(1 + r * r, -0.25);
    cloud.AddBody(Real(1.0 / static_cast<double>(bodies)), To<Real>(random.Direction() * r),
                  To<Real>(random.Direction() * speed));
  }
  cloud.softening = {Real(0.01)};
  return cloud;
}

template <class Real>
Cloud<Real> UniformBox(uint64_t bodies) {
  Random random;
  Cloud<Real> cloud;
  for (uint64_t i = 0; i < bodies; ++i) {
    cloud.AddBody(
        Real(random.Uniform(0.5, 1.5)),
        {Real(random.Uniform(0, 1)), Real(random.Uniform(0, 1)), Real(random.Uniform(0, 1))});
  }
  cloud.softening = {Real(0.001)};
  return cloud;
}

/// Returns a wide and a narrow cluster, ten metres apart.
template <class Real>
Cloud<Real> TwoClusters(uint64_t bodies) {
  Random random;
  Cloud<Real> cloud;
  for (uint64_t i = 0; i < bodies; ++i) {
    const double r = std::cbrt(random.Uniform(0, 1)) * (i % 2 == 0 ? 1 : 0.01);
    const Vec3<double> centre{i % 2 == 0 ? 0.0 : 10.0, 0, 0};
    cloud.AddBody(1, To<Real>(centre + random.Direction() * r));
  }
  cloud.softening = {Real(1e-4)};
  return cloud;
}

/// Returns |force - direct| / |direct| of every `stride`-th body, in ascending order.
template <class Real>
std::vector<double> Errors(const Cloud<Real>& cloud, uint64_t stride) {
  std::vector<double> errors;
  for (uint64_t i = 0; i < cloud.size(); i += stride) {
    const Vec3<double> exact = cloud.Direct(i);
    errors.push_back(Length(cloud.Force(i) - exact) / Length(exact));
  }
  std::ranges::sort(errors);
  return errors;
}

template <class Real>
class BarnesHutGravitationTest : public ::testing::Test {};
TYPED_TEST_SUITE(BarnesHutGravitationTest, Precisions);

TYPED_TEST(BarnesHutGravitationTest, TwoBodiesAttractAsNewtonSays) {
  Cloud<TypeParam> cloud;
  cloud.gravitational_constant = {TypeParam(6.6743e-11)};
  cloud.AddBody(TypeParam(5.972e24), {0, 0, 0});
  cloud.AddBody(TypeParam(7.348e22), {TypeParam(3.844e8), 0, 0});
  cloud.Forces(0.5);
  const double exact = 6.6743e-11 * 5.972e24 * 7.348e22 / (3.844e8 * 3.844e8);
  EXPECT_NEAR(cloud.external_force[0], exact, Rounding<TypeParam>(5 * exact));
  EXPECT_NEAR(cloud.external_force[3], -exact, Rounding<TypeParam>(5 * exact));
}

TYPED_TEST(BarnesHutGravitationTest, WithThetaZeroItIsTheSumOverAllPairs) {
  auto cloud = Plummer<TypeParam>(3000);
  cloud.Forces(0);
  EXPECT_LT(Errors(cloud, 7).back(), Rounding<TypeParam>(2000)) << "seed " << kSeed;
}

struct Bound {
  double theta, median, percentile99;
};

template <class Real>
void ExpectErrors(Cloud<Real> cloud, const std::vector<Bound>& bounds) {
  for (const Bound& bound : bounds) {
    cloud.Forces(bound.theta, 2);
    const std::vector<double> errors = Errors(cloud, 97);
    EXPECT_LT(errors[errors.size() / 2], bound.median) << "theta " << bound.theta;
    EXPECT_LT(errors[errors.size() * 99 / 100], bound.percentile99) << "theta " << bound.theta;
  }
}

TYPED_TEST(BarnesHutGravitationTest, ErrorsInAPlummerSphereAreAsTheReadmeSays) {
  ExpectErrors(Plummer<TypeParam>(20000),
               {{0.3, 4e-5, 5e-4}, {0.5, 2e-4, 2.2e-3}, {0.9, 1.2e-3, 1.5e-2}});
}

TYPED_TEST(BarnesHutGravitationTest, ErrorsInAUniformBoxAreAsTheReadmeSays) {
  ExpectErrors(UniformBox<TypeParam>(20000),
               {{0.3, 8e-5, 7e-4}, {0.5, 4e-4, 3.5e-3}, {0.9, 8e-3, 4e-2}});
}

TYPED_TEST(BarnesHutGravitationTest, ErrorsInTwoClustersAreAsTheReadmeSays) {
  ExpectErrors(TwoClusters<TypeParam>(20000),
               {{0.3, 9e-5, 7e-4}, {0.5, 5e-4, 3.5e-3}, {0.9, 2.6e-3, 2.5e-2}});
}

TYPED_TEST(BarnesHutGravitationTest, ForcesHaveTheSameBitsOnAnyNumberOfThreads) {
  auto cloud = Plummer<TypeParam>(40000);
  const auto one = cloud.Forces(0.7, 1);
  EXPECT_EQ(cloud.Forces(0.7, 2), one);
  EXPECT_EQ(cloud.Forces(0.7, 8), one);
}

TYPED_TEST(BarnesHutGravitationTest, ForcesDoNotDependOnTheOrderOfTheRows) {
  auto cloud = Plummer<TypeParam>(5000);
  const auto forces = cloud.Forces(0.7);
  std::vector<uint64_t> rows(cloud.size());
  std::iota(rows.begin(), rows.end(), 0);
  std::shuffle(rows.begin(), rows.end(), std::mt19937(kSeed));
  auto shuffled = cloud;
  for (uint64_t i = 0; i < rows.size(); ++i) {
    for (uint64_t c = 0; c < 3; ++c) {
      shuffled.position[3 * i + c] = cloud.position[3 * rows[i] + c];
    }
  }
  shuffled.Forces(0.7);
  for (uint64_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(shuffled.Force(i), cloud.Force(rows[i])) << "row " << i << ", seed " << kSeed;
  }
}

TYPED_TEST(BarnesHutGravitationTest, UnitsOfAnySizeGiveTheSameForcesInThoseUnits) {
  auto cloud = Plummer<TypeParam>(5000);
  const auto forces = cloud.Forces(0.7);
  // 2^60 m is 122 light years, and 2^100 kg is half the mass of the sun; G keeps the forces equal.
  for (TypeParam& x : cloud.position) x *= TypeParam(0x1p60);
  for (TypeParam& m : cloud.mass) m *= TypeParam(0x1p100);
  cloud.softening[0] *= TypeParam(0x1p60);
  cloud.gravitational_constant[0] = TypeParam(0x1p-80);
  EXPECT_EQ(cloud.Forces(0.7), forces);
}

TYPED_TEST(BarnesHutGravitationTest, MassZeroNeitherPullsNorIsPulled) {
  auto cloud = Plummer<TypeParam>(6000);
  for (uint64_t i = 0; i < 100; ++i) cloud.mass[i] = 0;
  cloud.Forces(0.5);
  for (uint64_t i = 0; i < 100; ++i) ASSERT_EQ(Length(cloud.Force(i)), 0) << "row " << i;
  double largest = 0;
  for (uint64_t i = 100; i < cloud.size(); i += 59) {
    largest = std::max(largest, Length(cloud.Force(i) - cloud.Direct(i)) / Length(cloud.Direct(i)));
  }
  EXPECT_LT(largest, 0.01) << "seed " << kSeed;
}

TYPED_TEST(BarnesHutGravitationTest, NoForcesAtAllWhereNothingHasMass) {
  auto cloud = Plummer<TypeParam>(6000);
  std::ranges::fill(cloud.mass, 0);
  EXPECT_EQ(cloud.Forces(0.5), std::vector<TypeParam>(18000, 0));
}

TYPED_TEST(BarnesHutGravitationTest, NoBodyAndOneBodyFeelNothing) {
  Cloud<TypeParam> none, one;
  one.AddBody(1, {3, 4, 5});
  EXPECT_EQ(none.Forces(0.5), std::vector<TypeParam>());
  EXPECT_EQ(one.Forces(0.5), std::vector<TypeParam>(3, 0));
}

TYPED_TEST(BarnesHutGravitationTest, BodiesAtOnePointFeelNothingOfEachOther) {
  for (const TypeParam softening : {0, 1}) {
    Cloud<TypeParam> cloud;
    cloud.softening = {softening};
    for (int i = 0; i < 100000; ++i) cloud.AddBody(1, {7, 7, 7});
    EXPECT_EQ(cloud.Forces(0.5, 2), std::vector<TypeParam>(300000, 0));
  }
}

TYPED_TEST(BarnesHutGravitationTest, APairOfPointsWithManyBodiesEachIsATwoBodyProblem) {
  Cloud<TypeParam> cloud;
  for (int i = 0; i < 6000; ++i) cloud.AddBody(1, {TypeParam(i % 2 == 0 ? -1 : 1), 0, 0});
  cloud.Forces(0.5);
  for (uint64_t i = 0; i < 6000; ++i) {
    const double exact = (i % 2 == 0 ? 1 : -1) * 3000 / 4.0;
    ASSERT_EQ(cloud.Force(i), (Vec3<double>{exact, 0, 0})) << "row " << i;
  }
}

TYPED_TEST(BarnesHutGravitationTest, BodiesInAPlaneAndOnALineStayThere) {
  Cloud<TypeParam> plane, line;
  Random random;
  for (int i = 0; i < 6000; ++i) {
    plane.AddBody(1, {TypeParam(random.Uniform(0, 1)), TypeParam(random.Uniform(0, 1)), 0});
    line.AddBody(1, {0, TypeParam(random.Uniform(0, 1)), 0});
  }
  plane.Forces(0.5);
  line.Forces(0.5);
  for (uint64_t i = 0; i < 6000; ++i) {
    ASSERT_EQ(plane.Force(i).z, 0);
    ASSERT_EQ(line.Force(i).x, 0);
    ASSERT_EQ(line.Force(i).z, 0);
  }
  EXPECT_LT(Errors(plane, 37)[81], 1e-3) << "seed " << kSeed;
}

// The outlier makes the key grid so coarse that all other bodies have the same cell.
TYPED_TEST(BarnesHutGravitationTest, AFarOutlierCostsNoAccuracy) {
  auto cloud = Plummer<TypeParam>(6000);
  cloud.AddBody(1, {TypeParam(1e9), 0, 0});
  cloud.Forces(0.5);
  const auto errors = Errors(cloud, 37);
  EXPECT_LT(errors[errors.size() / 2], 5e-4) << "seed " << kSeed;
}

TYPED_TEST(BarnesHutGravitationTest, ThePotentialEnergyIsThatOfThePairs) {
  auto cloud = Plummer<TypeParam>(6000);
  const std::string library =
      std::string(VESPER_LAW_PATH) + "/libvesper_law_barnes_hut_gravitation.so";
  const LawFile file(library);
  constexpr vesper_scalar_type kReal = std::is_same_v<TypeParam, float> ? VESPER_F32 : VESPER_F64;
  const vesper_law_desc& desc = *file.Laws(kReal).front();
  std::vector<vesper_property> properties;
  for (uint32_t u = 0; u < desc.use_count; ++u) {
    const vesper_property_use& use = desc.uses[u];
    const auto hand_over = [&](std::vector<TypeParam>& values) {
      properties.push_back({sizeof(vesper_property), use.scalar_type, use.name, use.kind,
                            use.components, use.access, values.data(),
                            values.size() / use.components, 0});
    };
    const std::string name = use.name;
    if (name == "gravitationalConstant") hand_over(cloud.gravitational_constant);
    if (name == "softening") hand_over(cloud.softening);
    if (name == "mass") hand_over(cloud.mass);
    if (name == "position") hand_over(cloud.position);
    if (name == "externalForce") hand_over(cloud.external_force);
  }
  const BareLaw law(desc, properties);
  EXPECT_NEAR(law.PotentialEnergy() / cloud.Potential(), 1, 1e-3);
}

// The run lasts 6 time units, which is about one period. Relaxation and the errors of the scheme
// are much slower.
TYPED_TEST(BarnesHutGravitationTest, APlummerSphereInEquilibriumKeepsItsEnergyAndMomentum) {
  auto cloud = Plummer<TypeParam>(4300);
  cloud.softening = {TypeParam(0.05)};
  PhysicsEngine engine = cloud.MakeEngine(0.7, 2);
  engine.LoadPhysicsLaw("velocity_verlet");
  const double before = cloud.KineticEnergy() + cloud.Potential();
  const Vec3<double> momentum = cloud.Momentum();
  engine.Advance(0.04, 150);
  const double after = cloud.KineticEnergy() + cloud.Potential();
  EXPECT_NEAR(after / before, 1, 1e-3) << "seed " << kSeed;
  // The law's forces are not exactly opposite in pairs, so momentum drifts with their error.
  EXPECT_LT(Length(cloud.Momentum() - momentum), 1e-3) << "seed " << kSeed;
}

TEST(BarnesHutGravitationInputTest, NamesTheBodyWhoseMassBecomesNegativeUnnoticed) {
  auto cloud = Plummer<double>(10);
  PhysicsEngine engine = cloud.MakeEngine(0.5, 1);
  engine.Advance(1);
  cloud.mass[3] = -2;
  try {
    engine.Advance(1);
    FAIL() << "took it";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), VESPER_LAW_FAILED);
    EXPECT_NE(std::string(error.what()).find("'mass' of body 3"), std::string::npos)
        << error.what();
  }
}

TEST(BarnesHutGravitationInputTest, NamesTheBodyWhosePositionIsNoNumber) {
  auto cloud = Plummer<double>(2000);
  cloud.position[3 * 1234 + 1] = std::numeric_limits<double>::infinity();
  try {
    cloud.Forces(0.5);
    FAIL() << "took it";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("'position' of body 1234"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace vesper
