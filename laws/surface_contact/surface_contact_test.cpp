// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numbers>

#include "contact_scene.hpp"

namespace vesper {
namespace {

template <class Real>
class SurfaceContactTest : public ::testing::Test {};
TYPED_TEST_SUITE(SurfaceContactTest, Precisions);

constexpr double kGravity = 9.81;  // [m/s^2]

// A damped half oscillation that ends when the force becomes zero, because it never attracts (T.
// Schwager, T. Poeschel, Coefficient of Restitution and Linear-Dashpot Model Revisited, 2007).
TYPED_TEST(SurfaceContactTest, BouncesWithTheRestitutionOfTheClosedForm) {
  const double mass = 2, k = 5000, c = 20, dt = 1e-5;
  ContactScene<TypeParam> scene;
  scene.AddGround({k, c, 0});
  const uint32_t ball = scene.AddBody(mass, {0, 0.01f, 0}, {0, -1, 0});
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("surface_contact");
  engine.LoadPhysicsLaw("newton_motion");
  engine.Advance(dt, 10000);
  const double beta = c / (2 * mass), omega = std::sqrt(k / mass - beta * beta);
  const double phase = std::numbers::pi - std::atan2(2 * beta * omega, omega * omega - beta * beta);
  EXPECT_NEAR(scene.At(scene.velocity, ball).y, std::exp(-beta / omega * phase), 3e-3);
  EXPECT_GT(scene.At(scene.position, ball).y, 0);
}

TYPED_TEST(SurfaceContactTest, RestsWhereTheHardnessCarriesTheWeight) {
  const double mass = 3, k = 2000;
  ContactScene<TypeParam> scene;
  scene.gravity = {0, static_cast<TypeParam>(-kGravity), 0};
  scene.AddGround({k, 2 * std::sqrt(k * mass), 0});
  const uint32_t ball = scene.AddBody(mass, {0.3f, 0.001f, 0.2f});
  PhysicsEngine engine = scene.MakeEngine();
  for (const char* law : {"gravity_field", "surface_contact", "newton_motion"}) {
    engine.LoadPhysicsLaw(law);
  }
  engine.Advance(1e-3, 2000);
  EXPECT_NEAR(scene.At(scene.position, ball).y, -mass * kGravity / k, Rounding<TypeParam>(10));
  EXPECT_NEAR(Length(scene.At(scene.velocity, ball)), 0, Rounding<TypeParam>(1000));
}

TYPED_TEST(SurfaceContactTest, ContactForcesAtRestAreTheWeightAndItsReaction) {
  const double mass = 3, k = 2000;
  ContactScene<TypeParam> scene;
  scene.gravity = {0, static_cast<TypeParam>(-kGravity), 0};
  scene.AddGround({k, 2 * std::sqrt(k * mass), 0});
  const uint32_t ball = scene.AddBody(mass, {0.3f, 0.001f, 0.2f});
  std::vector<TypeParam> contact(scene.position.size(), 7);
  PhysicsEngine engine = scene.MakeEngine();
  engine.PropertyProvider().AddPhysicalProperty("contactForce", contact);
  for (const char* law : {"gravity_field", "surface_contact", "newton_motion"}) {
    engine.LoadPhysicsLaw(law);
  }
  engine.Advance(1e-3, 2000);
  EXPECT_NEAR(scene.At(contact, ball).y, mass * kGravity, 1e-4 * mass * kGravity);
  double sum = 0;
  for (size_t i = 1; i < contact.size(); i += 3) sum += contact[i];
  EXPECT_NEAR(sum, 0, 1e-4 * mass * kGravity) << "the ground bears the ball";
}

TYPED_TEST(SurfaceContactTest, MassZeroBearsTheWeightAndKeepsItsBits) {
  const double mass = 3, k = 2000;
  ContactScene<TypeParam> scene;
  scene.gravity = {0, static_cast<TypeParam>(-kGravity), 0};
  scene.AddGround({k, 2 * std::sqrt(k * mass), 0});
  const auto height = static_cast<TypeParam>(-mass * kGravity / k);
  const uint32_t ball = scene.AddBody(mass, {0.3f, height, 0});
  const auto ground = scene.position;
  PhysicsEngine engine = scene.MakeEngine();
  for (const char* law : {"gravity_field", "surface_contact", "newton_motion"}) {
    engine.LoadPhysicsLaw(law);
  }
  engine.Advance(1e-3, 100);
  double borne = 0;
  for (uint32_t corner = 0; corner < ball; ++corner) {
    borne += scene.At(scene.external_force, corner).y;
    EXPECT_EQ(
        scene.At(scene.position, corner),
        (Vec3<TypeParam>{ground[3 * corner], ground[3 * corner + 1], ground[3 * corner + 2]}));
    EXPECT_EQ(scene.At(scene.velocity, corner), (Vec3<TypeParam>{}));
  }
  EXPECT_NEAR(borne, -mass * kGravity, Rounding<TypeParam>(1000 * k * 0.015));
}

/// A point on an inclined plane: its weight pulls along +x with the sine of the angle.
template <class Real>
struct Slope {
  Slope(double tangent, double friction, Vec3<Real> speed = {}) {
    const double angle = std::atan(tangent);
    scene.gravity = {static_cast<Real>(kGravity * std::sin(angle)),
                     static_cast<Real>(-kGravity * std::cos(angle)), 0};
    scene.AddGround({1e4, 100, friction});
    const double depth = kGravity * std::cos(angle) / 1e4;
    block = scene.AddBody(1, {0, static_cast<Real>(-depth), 0}, speed);
    engine.emplace(scene.MakeEngine());
    for (const char* law : {"gravity_field", "surface_contact", "newton_motion"}) {
      engine->LoadPhysicsLaw(law);
    }
  }
  double X() const { return double{scene.At(scene.position, block).x}; }
  double Speed() const { return double{scene.At(scene.velocity, block).x}; }

  ContactScene<Real> scene;
  uint32_t block;
  std::optional<PhysicsEngine> engine;
};

TYPED_TEST(SurfaceContactTest, RestsOnASlopeBelowTheFrictionAngleWithoutCreeping) {
  Slope<TypeParam> slope(0.49, 0.5);
  slope.engine->Advance(1e-3, 2000);
  const double x = slope.X();
  slope.engine->Advance(1e-3, 20000);
  EXPECT_NEAR(slope.X(), x, Rounding<TypeParam>(1));
  EXPECT_LT(x, 0.005);
}

TYPED_TEST(SurfaceContactTest, WhatRestsOnASlopeHasMovedByTheStretchOfTheSpringOfFriction) {
  Slope<TypeParam> slope(0.2, 0.5);
  slope.engine->Advance(1e-3, 2000);
  EXPECT_NEAR(slope.X(), double{slope.scene.gravity[0]} / 1e4, 1e-8);
}

TYPED_TEST(SurfaceContactTest, SlidesOnASlopeAboveTheFrictionAngleAsCoulombSays) {
  Slope<TypeParam> slope(0.52, 0.5);
  slope.engine->Advance(1e-3, 1000);
  const double speed = slope.Speed(), angle = std::atan(0.52);
  slope.engine->Advance(1e-3, 1000);
  EXPECT_NEAR(slope.Speed() - speed, kGravity * (std::sin(angle) - 0.5 * std::cos(angle)), 1e-4);
}

TYPED_TEST(SurfaceContactTest, SlidingSlowsDownByFrictionTimesGravityAndThenStops) {
  Slope<TypeParam> slope(0, 0.3, {2, 0, 0});
  slope.engine->Advance(1e-3, 500);
  EXPECT_NEAR(slope.Speed(), 2 - 0.3 * kGravity * 0.5, 1e-4);
  slope.engine->Advance(1e-3, 2000);
  EXPECT_NEAR(slope.Speed(), 0, Rounding<TypeParam>(100));
  EXPECT_NEAR(slope.X(), 2 * 2 / (2 * 0.3 * kGravity), 2e-3);  // v^2 / (2 mu g)
}

TYPED_TEST(SurfaceContactTest, WithoutFrictionItSlidesFreely) {
  Slope<TypeParam> slope(0.5, 0);
  slope.engine->Advance(1e-3, 1000);
  EXPECT_NEAR(slope.Speed(), kGravity * std::sin(std::atan(0.5)), 1e-4);
}

// A rigid icosahedron tips over above the angle at which its weight vector passes the lower edge of
// its base: tan = (edge to middle of the face) / (face to centre).
TYPED_TEST(SurfaceContactTest, IcosahedronTipsOverBeyondTheAngleOfTheRigidBody) {
  const double tipping = std::atan(1 / (std::sqrt(3) * kInsphere<double> / kHalfEdge<double>));
  for (const bool tips : {false, true}) {
    ContactScene<TypeParam> scene;
    scene.Tilt(tipping + (tips ? 0.05 : -0.05), kGravity);
    scene.AddGround({5e4, 500, 2});
    const auto body = scene.AddIcosahedronOnFace({1, 2e5, 100}, {1e4, 100, 0.5});
    PhysicsEngine engine = scene.MakeEngine();
    scene.LoadAllLaws(engine);
    engine.Advance(1e-3, 1200);
    EXPECT_EQ(double{scene.Centre(body).x} > 0.25, tips) << scene.Centre(body).x;
  }
}

// It rotates about its lower edge, with I = (2/3) M R^2 + M L^2 and L from edge to centre, and does
// not slip. The lost potential energy therefore equals I w^2 / 2.
TYPED_TEST(SurfaceContactTest, StiffIcosahedronRollsOverItsEdgeAsARigidBody) {
  const double slope = 0.45;
  ContactScene<TypeParam> scene;
  scene.Tilt(slope, kGravity);
  scene.AddGround({2e5, 200, 2});
  const auto body = scene.AddIcosahedronOnFace({1, 1e6, 300}, {1e4, 0, 0.5});
  PhysicsEngine engine = scene.MakeEngine();
  scene.LoadAllLaws(engine);
  const double arm = kMidsphere<double>, inertia = 12 * (2.0 / 3 + arm * arm);
  const auto above_edge = [&] {  // angle between the arm and the direction of gravity
    const auto centre = scene.Centre(body);
    const double beyond_edge = double{centre.x} - kHalfEdge<double> / std::sqrt(3);
    return std::atan2(beyond_edge, double{centre.y}) + slope;
  };
  const double start = above_edge();
  engine.Advance(2.5e-4, 1600);
  const double turned = above_edge();
  ASSERT_GT(turned - start, 0.05);
  const double expected =
      std::sqrt(2 * 12 * kGravity * arm * (std::cos(start) - std::cos(turned)) / inertia);
  EXPECT_NEAR(double{Length(scene.CentreVelocity(body))} / arm, expected, 0.05 * expected);
}

TYPED_TEST(SurfaceContactTest, CollidingMeshesKeepMomentumAndAngularMomentum) {
  ContactScene<TypeParam> scene;
  scene.AddIcosahedron({0, 0, 0}, {2, 0, 0}, {1, 2000, 5}, {2000, 10, 0.6});
  scene.AddIcosahedron({2.2f, 0.7f, 0.3f}, {-1, 0, 0}, {0.5, 2000, 5}, {3000, 10, 0.6});
  PhysicsEngine engine = scene.MakeEngine();
  scene.LoadAllLaws(engine);
  const Vec3<double> momentum = scene.Momentum(), angular = scene.AngularMomentum();
  const double before = scene.MechanicalEnergy();
  double relative = 3;  // speed of the second body towards the first [m/s]
  for (int n = 0; n < 100; ++n) {
    engine.Advance(1e-3, 10);
    const double now = double{scene.CentreVelocity({0, 12}).x - scene.CentreVelocity({12, 12}).x};
    relative = std::min(relative, now);
  }
  EXPECT_LT(relative, 0) << "they never met";
  EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(1e4));
  EXPECT_LT(Length(scene.AngularMomentum() - angular), Rounding<TypeParam>(1e4));
  EXPECT_LT(scene.MechanicalEnergy(), before);
}

TYPED_TEST(SurfaceContactTest, EnergyNeverGrowsWithDamping) {
  ContactScene<TypeParam> scene;
  scene.gravity = {0, static_cast<TypeParam>(-kGravity), 0};
  scene.AddGround({1e4, 50, 0.5});
  scene.AddIcosahedron({0, 2, 0}, {1, 0, 0.5f}, {1, 5000, 5}, {1e4, 50, 0.5});
  PhysicsEngine engine = scene.MakeEngine();
  scene.LoadAllLaws(engine);
  const double start = scene.MechanicalEnergy();
  double before = start;
  for (int n = 0; n < 60; ++n) {
    engine.Advance(2.5e-4, 200);
    const double now = scene.MechanicalEnergy();
    EXPECT_LT(now, before + 1e-3 * start) << "after " << 0.05 * (n + 1) << " s";
    before = now;
  }
  EXPECT_LT(before, 0.7 * start);
}

// The force above flat ground of two triangles equals that of one triangle at every position.
TYPED_TEST(SurfaceContactTest, ForceOverAnInnerEdgeIsThatOverAFace) {
  for (const double x : {-1e-3, -1e-7, 0.0, 1e-7, 1e-3}) {
    ContactScene<TypeParam> scene;
    for (const auto& [px, pz] : {std::pair{0, -5}, {5, 0}, {0, 5}, {-5, 0}}) {
      scene.AddBody(0, {TypeParam(px), 0, TypeParam(pz)});
    }
    scene.AddSurface({0, 2, 1}, {1000, 0, 0});
    scene.AddSurface({0, 3, 2}, {1000, 0, 0});
    scene.AddBody(1, {static_cast<TypeParam>(x), -0.0078125f, 0.5f});
    PhysicsEngine engine = scene.MakeEngine();
    engine.LoadPhysicsLaw("surface_contact");
    engine.Advance(1e-3);
    const auto force = scene.At(scene.external_force, 4);
    EXPECT_NEAR(force.y, 7.8125, Rounding<TypeParam>(1e4)) << "x = " << x;
    EXPECT_NEAR(std::hypot(force.x, force.z), 0, Rounding<TypeParam>(1e4)) << "x = " << x;
  }
}

// Inside a solid, the force is the hardness times the distance from its surface. This is also true
// near edges and corners, where different faces are the nearest one.
TYPED_TEST(SurfaceContactTest, ForceInsideASolidIsHardnessTimesTheDistanceFromItsSkin) {
  const uint32_t seed = 7;
  std::mt19937 random(seed);
  const auto draw = [&] { return static_cast<TypeParam>(random() / 2147483648.0 - 1); };
  ContactScene<TypeParam> scene;
  scene.AddIcosahedron({}, {}, {1, 1, 0}, {1000, 0, 0});
  std::vector<Vec3<TypeParam>> points;
  while (points.size() < 500) {
    const Vec3<TypeParam> p{draw(), draw(), draw()};
    if (Length(p) < 1 && Length(p) > 0.6f) points.push_back(p);
  }
  for (const auto& p : points) scene.AddBody(1, p);
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("surface_contact");
  engine.Advance(1e-3);
  int inside = 0;
  for (uint32_t i = 0; i < points.size(); ++i) {
    const double depth = scene.DepthInIcosahedron(points[i]);  // the nearest of 20 planes
    const double expected = depth > 0 && depth < 0.25 ? 1000 * depth : 0;
    EXPECT_NEAR(Length(scene.At(scene.external_force, 12 + i)), expected, Rounding<TypeParam>(1e4))
        << "point " << i << ", seed " << seed;
    inside += expected > 0;
  }
  EXPECT_GT(inside, 200);
}

// The test uses a notch, in which two sheets meet in a valley. A point below the edge of the valley
// is pushed towards this edge.
TYPED_TEST(SurfaceContactTest, PointUnderAConcaveEdgeIsPushedTowardsTheEdge) {
  ContactScene<TypeParam> scene;
  scene.AddBody(0, {0, 0, -5});
  scene.AddBody(0, {0, 0, 5});
  scene.AddBody(0, {5, 5, 0});
  scene.AddBody(0, {-5, 5, 0});
  scene.AddSurface({0, 1, 2}, {1000, 0, 0});
  scene.AddSurface({1, 0, 3}, {1000, 0, 0});
  const uint32_t below = scene.AddBody(1, {0.0009765625f, -0.125f, 0.3f});
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("surface_contact");
  engine.Advance(1e-3);
  const auto force = scene.At(scene.external_force, below);
  EXPECT_NEAR(Length(force), 1000 * std::hypot(1.0 / 1024, 0.125), Rounding<TypeParam>(1e4));
  EXPECT_NEAR(force.x / force.y, -1.0 / 128, Rounding<TypeParam>(100));
}

TYPED_TEST(SurfaceContactTest, NothingIsFeltOutsideBeyondBordersAndBelowTheMaximumDepth) {
  for (const Vec3<TypeParam>& at : std::vector<Vec3<TypeParam>>{
           {0, 1e-3f, 0}, {0, -0.26f, 0}, {200, -0.01f, 0}, {0, -0.01f, 300}}) {
    ContactScene<TypeParam> scene;
    scene.AddGround({1000, 0, 0});
    scene.AddBody(1, at);
    PhysicsEngine engine = scene.MakeEngine();
    engine.LoadPhysicsLaw("surface_contact");
    engine.Advance(1e-3);
    EXPECT_EQ(scene.external_force, std::vector<TypeParam>(12, 0)) << at.x << " " << at.y;
  }
}

TYPED_TEST(SurfaceContactTest, MaximumDepthIsAParameter) {
  ContactScene<TypeParam> scene;
  scene.AddGround({1000, 0, 0});
  const uint32_t point = scene.AddBody(1, {0, -2, 0});
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("surface_contact", {{"maximumDepth", 3}});
  engine.Advance(1e-3);
  EXPECT_NEAR(scene.At(scene.external_force, point).y, 2000, Rounding<TypeParam>(1e4));
}

TYPED_TEST(SurfaceContactTest, SurfacesWithoutAreaExertNoForce) {
  ContactScene<TypeParam> scene;
  scene.AddBody(1, {0, 0, 0});
  scene.AddBody(1, {1, 0, 0});
  scene.AddBody(1, {2, 0, 0});
  scene.AddSurface({0, 1, 2}, {1000, 0, 0});  // collinear corners
  scene.AddSurface({0, 1, 1}, {1000, 0, 0});  // one body twice
  scene.AddBody(1, {0.5f, -0.01f, 0});
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("surface_contact");
  engine.Advance(1e-3);
  EXPECT_EQ(scene.external_force, std::vector<TypeParam>(12, 0));
}

TYPED_TEST(SurfaceContactTest, PointsInTwoMeshesFeelBoth) {
  ContactScene<TypeParam> scene;
  scene.AddGround({1000, 0, 0});
  scene.AddBody(0, {0, -9, -9});
  scene.AddBody(0, {0, -9, 9});
  scene.AddBody(0, {0, 9, 0});
  scene.AddSurface({3, 5, 4}, {500, 0, 0});  // a wall that faces +x
  const uint32_t point = scene.AddBody(1, {-0.015625f, -0.0078125f, 0});
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("surface_contact");
  engine.Advance(1e-3);
  const auto force = scene.At(scene.external_force, point);
  EXPECT_NEAR(force.x, 7.8125, Rounding<TypeParam>(1e4));
  EXPECT_NEAR(force.y, 7.8125, Rounding<TypeParam>(1e4));
}

// The broad phase must find every pair. The test uses boxes of every size and large coordinates.
TYPED_TEST(SurfaceContactTest, EveryPointOnAStairOfGroundsOfAllSizesIsFound) {
  ContactScene<TypeParam> scene;
  std::vector<uint32_t> points;
  for (int i = 0; i < 40; ++i) {
    const auto size = static_cast<TypeParam>(std::exp2(i % 11)), x = TypeParam(100 * i - 2000);
    const auto y = static_cast<TypeParam>(3 * i);
    const uint32_t first = scene.AddBody(0, {x - size, y, -size});
    scene.AddBody(0, {x, y, size});
    scene.AddBody(0, {x + size, y, -size});
    scene.AddSurface({first, first + 1, first + 2}, {1000, 0, 0});
    points.push_back(scene.AddBody(1, {x, y - TypeParam(0.125), 0}));
  }
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("surface_contact");
  engine.Advance(1e-3);
  for (const uint32_t point : points) {
    EXPECT_NEAR(scene.At(scene.external_force, point).y, 125, Rounding<TypeParam>(1e4)) << point;
  }
}

TYPED_TEST(SurfaceContactTest, HeapOfIcosahedraHasTheSameBitsOnAnyNumberOfThreads) {
  std::vector<TypeParam> reference;
  for (const uint32_t threads : {1, 2, 8}) {
    ContactScene<TypeParam> scene;
    scene.gravity = {0, static_cast<TypeParam>(-kGravity), 0};
    scene.AddGround({1e4, 50, 0.5});
    for (int i = 0; i < 100; ++i) {
      const auto x = TypeParam(i % 5) * 2, y = TypeParam(1.5) + TypeParam(i / 25) * 2;
      scene.AddIcosahedron({x + y * 0.1f, y, TypeParam(i / 5 % 5) * 2}, {0, -2, 0}, {1, 5000, 5},
                           {1e4, 50, 0.5});
    }
    PhysicsEngine engine = scene.MakeEngine(threads);
    scene.LoadAllLaws(engine);
    engine.Advance(1.0 / 480, 150);
    if (reference.empty()) reference = scene.position;
    EXPECT_EQ(scene.position, reference) << threads << " threads";
  }
}

TYPED_TEST(SurfaceContactTest, WhatMustNotBeNegativeIsNamed) {
  const std::pair<Material, std::string> cases[] = {
      {{-1000, 0, 0}, "property hardness, row 0: is -1000, expected 0 or more"},
      {{1000, -1, 0}, "property surfaceDamping, row 0: is -1"},
      {{1000, 0, -1}, "property frictionCoefficient, row 0: is -1"}};
  for (const auto& [material, expected] : cases) {
    ContactScene<TypeParam> scene;
    scene.AddGround(material);
    PhysicsEngine engine = scene.MakeEngine();
    engine.LoadPhysicsLaw("surface_contact");
    try {
      engine.Advance(1e-3);
      ADD_FAILURE() << "nobody is told of " << expected;
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), VESPER_INVALID_ARGUMENT);
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  }
}

TYPED_TEST(SurfaceContactTest, APositionThatIsNotANumberIsNamed) {
  ContactScene<TypeParam> scene;
  scene.AddGround({1000, 0, 0});
  scene.AddBody(1, {0, std::numeric_limits<TypeParam>::quiet_NaN(), 0});
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("surface_contact");
  try {
    engine.Advance(1e-3);
    FAIL() << "nobody is told";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), VESPER_LAW_FAILED);
    EXPECT_NE(std::string(error.what()).find("'position' of body row 3"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace vesper
