// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "sphere_scene.hpp"

namespace vesper {
namespace {

template <class Real>
class SphereContactTest : public ::testing::Test {};
TYPED_TEST_SUITE(SphereContactTest, Precisions);

/// Returns the coefficient of restitution of a spring and dashpot that never attract (Schwager and
/// Poeschel 2007).
double Restitution(double damping_ratio) {
  return std::exp(-2 * damping_ratio * std::acos(damping_ratio) /
                  std::sqrt(1 - damping_ratio * damping_ratio));
}

TYPED_TEST(SphereContactTest, HeadOnCollisionRestitutesAsTheClosedFormSays) {
  for (const double damping : {0.0, 0.1, 0.3, 0.7, 0.99}) {
    SphereScene<TypeParam> scene;
    scene.AddSphere(2, 0.5, {0, 0, 0}, {1, 0, 0});
    scene.AddSphere(2, 0.5, {TypeParam(1.001), 0, 0}, {-1, 0, 0});
    PhysicsEngine engine = scene.MakeSphereEngine({{"dampingRatio", damping}});
    const double contact_time = std::numbers::pi * std::sqrt(1 / 1e4);
    engine.Advance(contact_time / 500, 2000);
    EXPECT_NEAR(scene.velocity[0], -Restitution(damping), 0.004) << damping;
    EXPECT_NEAR(scene.velocity[3], Restitution(damping), 0.004) << damping;
  }
}

TYPED_TEST(SphereContactTest, BallRestsOnTheFloorByItsWeightOverTheStiffness) {
  SphereScene<TypeParam> scene;
  scene.AddSphere(2, 0.5, {0, 1, 0});
  scene.gravity = {0, -10, 0};
  PhysicsEngine engine = scene.MakeSphereEngine({{"floorHeight", 0.25}, {"stiffness", 1e3}});
  engine.Advance(1.0 / 1000, 8000);
  EXPECT_NEAR(scene.position[1], 0.75 - 2 * 10 / 1e3, 1e-6);
  EXPECT_NEAR(scene.velocity[1], 0, 1e-4);
}

TYPED_TEST(SphereContactTest, ContactForcesAtRestAreTheWeights) {
  SphereScene<TypeParam> scene;
  scene.AddSphere(2, 0.5, {0, TypeParam(0.5), 0});
  scene.AddSphere(3, 0.4, {0, TypeParam(1.4), 0});
  scene.AddSphere(1, 0.5, {9, 40, 0});
  scene.gravity = {0, -10, 0};
  scene.contact.assign(scene.position.size(), 7);
  PhysicsEngine engine = scene.MakeSphereEngine({{"floorHeight", 0.0}, {"stiffness", 1e4}});
  engine.Advance(1.0 / 1000, 2500);
  // The net contact force on each ball is its own weight.
  EXPECT_NEAR(scene.contact[1], 20, 1e-2);
  EXPECT_NEAR(scene.contact[4], 30, 1e-2);
  EXPECT_NEAR(scene.contact[0], 0, 1e-2);
  EXPECT_EQ(scene.contact[7], 0) << "in free fall";
}

TYPED_TEST(SphereContactTest, SlidingBallComesToRollWithFiveSeventhsOfItsSpeed) {
  SphereScene<TypeParam> scene;
  scene.AddSphere(2, 0.5, {0, TypeParam(0.499), 0}, {7, 0, 0});
  scene.gravity = {0, -10, 0};
  PhysicsEngine engine = scene.MakeSphereEngine({{"floorHeight", 0.0}, {"stiffness", 2e4}});
  engine.Advance(1.0 / 1000, 1000);
  EXPECT_NEAR(scene.velocity[0], 5, 0.02);
  EXPECT_NEAR(scene.spin[2], -scene.velocity[0] / 0.499, 0.02);  // it rolls: v = omega x r
}

// The direction of gravity is tilted instead of the floor. Balls that cannot rotate slide like
// blocks.
TYPED_TEST(SphereContactTest, BlockRestsBelowTheAngleOfFrictionAndSlidesAboveIt) {
  for (const double angle : {0.40, 0.52}) {  // tan: 0.423, 0.573; friction 0.5
    SphereScene<TypeParam> scene;
    scene.AddSphere(2, 0.5, {0, TypeParam(0.499), 0});
    scene.inertia = {0, 0, 0};
    const double g = 10;
    scene.gravity = {TypeParam(g * std::sin(angle)), TypeParam(-g * std::cos(angle)), 0};
    PhysicsEngine engine = scene.MakeSphereEngine({{"floorHeight", 0.0}, {"stiffness", 2e4}});
    engine.Advance(1.0 / 500, 500);
    const double x = scene.position[0], v = scene.velocity[0];
    engine.Advance(1.0 / 500, 30 * 500);
    if (angle < std::atan(0.5)) {
      EXPECT_NEAR(scene.position[0], x, 1e-6);  // for half a minute
    } else {
      const double a = g * (std::sin(angle) - 0.5 * std::cos(angle));
      EXPECT_NEAR(scene.velocity[0], v + a * 30, 1e-3 * a * 30);
    }
  }
}

TYPED_TEST(SphereContactTest, SpinningBallsThatMeetKeepMomentumAndAngularMomentum) {
  SphereScene<TypeParam> scene = RandomSpheres<TypeParam>(60, 5);
  PhysicsEngine engine = scene.MakeSphereEngine();
  const Vec3<double> momentum = scene.Momentum(), angular = scene.TotalAngularMomentum();
  double touched = 0;
  for (int i = 0; i < 50; ++i) {
    engine.Advance(1.0 / 1000, 10);
    touched = std::max(touched, scene.LargestForce());
  }
  EXPECT_GT(touched, 100);
  const double size = 60 * 3 * 4;
  EXPECT_NEAR(Length(scene.Momentum() - momentum), 0, Rounding<TypeParam>(50 * size));
  EXPECT_NEAR(Length(scene.TotalAngularMomentum() - angular), 0, Rounding<TypeParam>(500 * size));
}

TYPED_TEST(SphereContactTest, DampingAndFrictionTakeEnergy) {
  for (const auto& [damping, friction] : {std::pair{0.2, 0.0}, std::pair{0.0, 0.5}}) {
    SphereScene<TypeParam> scene = RandomSpheres<TypeParam>(60, 6);
    PhysicsEngine engine =
        scene.MakeSphereEngine({{"dampingRatio", damping}, {"friction", friction}});
    const auto energy = [&] {
      return scene.KineticEnergy() + scene.SpinEnergy() + scene.ElasticEnergy(1e4);
    };
    const double begin = energy();
    engine.Advance(1.0 / 4000, 2000);
    EXPECT_LT(energy(), 0.95 * begin) << "damping " << damping << ", friction " << friction;
    EXPECT_GT(energy(), 0.05 * begin) << "damping " << damping << ", friction " << friction;
  }
}

TYPED_TEST(SphereContactTest, WithoutDampingAndFrictionEnergyIsKept) {
  SphereScene<TypeParam> scene = RandomSpheres<TypeParam>(60, 6);
  PhysicsEngine engine = scene.MakeSphereEngine({{"dampingRatio", 0}, {"friction", 0}});
  const double begin = scene.KineticEnergy() + scene.SpinEnergy() + scene.ElasticEnergy(1e4);
  engine.Advance(1.0 / 4000, 2000);
  EXPECT_NEAR((scene.KineticEnergy() + scene.SpinEnergy() + scene.ElasticEnergy(1e4)) / begin, 1,
              0.01);
}

// The expected forces are sums over all pairs, without grids and lists. The radii span three orders
// of magnitude.
TYPED_TEST(SphereContactTest, ForcesAreThoseOfAllPairs) {
  for (const uint32_t seed : {1u, 2u, 3u}) {
    SphereScene<TypeParam> scene = RandomSpheres<TypeParam>(300, seed);
    std::mt19937 random(seed);
    for (TypeParam& r : scene.radius) {
      r = static_cast<TypeParam>(0.003 * std::pow(1000.0, random() / 4294967296.0));
    }
    scene.radius[7] = 0;
    PhysicsEngine engine =
        scene.MakeSphereEngine({{"dampingRatio", 0}, {"friction", 0}, {"stiffness", 100}});
    for (int frame = 0; frame < 3; ++frame) {
      const auto before = scene.position;
      engine.Advance(1.0 / 100);
      const auto expected = scene.ElasticForces(before, 100);
      for (size_t i = 0; i < expected.size(); ++i) {
        ASSERT_NEAR(scene.external_force[i], expected[i], Rounding<TypeParam>(300 * 1000))
            << "value " << i << ", seed " << seed;
      }
    }
  }
}

TYPED_TEST(SphereContactTest, BallsWithoutMassBearOthersAndStay) {
  SphereScene<TypeParam> scene;
  for (int x = -3; x <= 3; ++x) {
    for (int z = -3; z <= 3; ++z) {
      scene.AddSphere(0, 0.5, {x * TypeParam(0.8), 0, z * TypeParam(0.8)});
    }
  }
  scene.AddSphere(1, 0.5, {TypeParam(0.3), 2, TypeParam(0.2)});
  scene.gravity = {0, -10, 0};
  const auto start = scene.position;
  PhysicsEngine engine = scene.MakeSphereEngine();
  engine.Advance(1.0 / 1000, 5000);
  const size_t ground = 3 * 49;
  EXPECT_TRUE(std::equal(start.begin(), start.begin() + ground, scene.position.begin()));
  EXPECT_GT(scene.position[ground + 1], 0.7);
  EXPECT_LT(Length(scene.At(scene.velocity, 49)), 0.2);  // it may continue to rock between them
}

TYPED_TEST(SphereContactTest, ClientWithoutRotationHasFrictionOfPoints) {
  SphereScene<TypeParam> scene;
  scene.AddSphere(2, 0.5, {0, TypeParam(0.499), 0}, {8, 0, 0});
  scene.gravity = {0, -10, 0};
  PhysicsEngine engine = scene.MakeEngine();
  engine.PropertyProvider().AddPhysicalProperty("radius", scene.radius);
  for (const char* law : {"gravity_field", "newton_motion"}) engine.LoadPhysicsLaw(law);
  engine.LoadPhysicsLaw("sphere_contact", {{"floorHeight", 0.0}, {"stiffness", 2e4}});
  engine.Advance(1.0 / 1000, 1000);
  EXPECT_NEAR(scene.velocity[0], 8 - 0.5 * 10, 0.02);
}

/// Returns a block of 468 balls above a rough disc of immovable balls; some fall over its edge.
template <class Real>
SphereScene<Real> Block() {
  SphereScene<Real> scene;
  for (int x = -7; x <= 7; ++x) {
    for (int z = -7; z <= 7; ++z) {
      if (x * x + z * z <= 50) scene.AddSphere(0, 0.5, {Real(x), 0, Real(z)});
    }
  }
  std::mt19937 random(11);
  const auto jitter = [&] { return 0.1 * random() / 4294967296.0 - 0.05; };
  for (int i = 0; i < 468; ++i) {
    const double x = 1.1 * (i % 6 - 2.5) + jitter(), z = 1.1 * (i / 6 % 6 - 2.5) + jitter();
    scene.AddSphere(1, 0.5, {Real(x), Real(1.2 + 1.1 * (i / 36) + jitter()), Real(z)});
  }
  scene.gravity = {0, Real(-9.81), 0};
  return scene;
}

// [m], closer to the edge of the disc, balls may roll over it at any time.
constexpr double kHeapRadius = 5;

/// Returns the slope [degrees] from the axis of the heap to its outermost metre, by the highest
/// ball of each.
template <class Real>
double SlopeDegrees(const SphereScene<Real>& scene) {
  double inner = 0, outer = 0;
  for (size_t i = 0; i < scene.radius.size(); ++i) {
    const auto at = scene.Wide(scene.At(scene.position, i));
    const double distance = std::hypot(at.x, at.z);
    if (distance < 1) inner = std::max(inner, at.y);
    if (distance > kHeapRadius - 1 && distance < kHeapRadius) outer = std::max(outer, at.y);
  }
  return std::atan((inner - outer) / (kHeapRadius - 1)) * 180 / std::numbers::pi;
}

/// Returns the largest displacement of a ball of the heap from its earlier position [m].
template <class Real>
double LargestWay(const SphereScene<Real>& scene, const std::vector<Real>& since) {
  double largest = 0;
  for (size_t i = 0; i < scene.radius.size(); ++i) {
    const auto at = scene.Wide(scene.At(scene.position, i));
    if (std::hypot(at.x, at.z) > kHeapRadius || at.y < 0) continue;
    largest = std::max(largest, Length(at - scene.Wide(scene.At(since, i))));
  }
  return largest;
}

TEST(SpherePile, ComesToRestAtItsAngleOfReposeAndKeepsIt) {
  auto scene = Block<float>();
  PhysicsEngine engine = scene.MakeSphereEngine({{"stiffness", 4e4}}, 2, false);
  engine.Advance(1.0 / 600, 10 * 600);
  const double slope = SlopeDegrees(scene);
  EXPECT_GT(slope, 20);
  EXPECT_LT(slope, 30);
  EXPECT_LT(scene.LargestOverlap(), 0.02);  // 2 % of the diameter
  const auto before = scene.position;
  engine.Advance(1.0 / 600, 4 * 600);
  EXPECT_LT(LargestWay(scene, before), 1e-6);  // less than a diameter per month
}

TYPED_TEST(SphereContactTest, BitsDependNeitherOnThreadsNorOnWhenNeighboursWereListed) {
  auto reference = Block<TypeParam>();
  PhysicsEngine one = reference.MakeSphereEngine({{"stiffness", 2e4}}, 1, false);
  one.Advance(1.0 / 600, 900);
  for (const uint32_t threads : {2u, 8u}) {
    auto scene = Block<TypeParam>();
    PhysicsEngine before = scene.MakeSphereEngine({{"stiffness", 2e4}}, threads, false);
    before.Advance(1.0 / 600, 437);
    PhysicsEngine after = scene.MakeSphereEngine({{"stiffness", 2e4}}, threads, false);
    after.LoadState(before.SaveState());
    after.Advance(1.0 / 600, 900 - 437);
    EXPECT_EQ(scene.position, reference.position);
    EXPECT_EQ(scene.spin, reference.spin);
    EXPECT_EQ(after.StateHash(), one.StateHash());
  }
}

}  // namespace
}  // namespace vesper
