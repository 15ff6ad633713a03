// SPDX-License-Identifier: Apache-2.0
// Tests contacts between edges of meshes.
#include <array>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "convex_bodies.hpp"

namespace vesper {
namespace {

constexpr double kGravity = 9.81;  // [m/s^2]

template <class Real>
class EdgeContactTest : public ::testing::Test {};
TYPED_TEST_SUITE(EdgeContactTest, Precisions);

// The test compares forces with differences of the energy, for random pairs that penetrate each
// other with corners and edges. Depths of up to 0.25 m have the rounding errors of coordinates of 1
// m, and a difference contains them twice.
TYPED_TEST(EdgeContactTest, ForcesAreTheSlopeOfTheEnergy) {
  const uint32_t seed = 11;
  const double hardness = 1000, rounding = 2 * Rounding<TypeParam>(hardness * 0.25);
  Random random(seed);
  const auto h = static_cast<TypeParam>(sizeof(TypeParam) == 4 ? 1e-4 : 1e-7);
  int felt = 0;
  for (int pair = 0; pair < 40; ++pair) {
    ContactScene<TypeParam> scene;
    const Material material{hardness, 0, 0};
    const ConvexBody first = random.Body(), second = random.Body();
    AddBody(scene, first, {}, {}, {1, 1, 0}, material);
    AddBody(scene, second, random.Direction() * random.Between(0.7, 1.2), {}, {1, 1, 0}, material);
    PhysicsEngine engine = scene.MakeEngine();
    const auto law = engine.LoadPhysicsLaw("surface_contact");
    engine.Advance(1e-9);
    const std::vector<TypeParam> forces = scene.external_force;
    for (size_t i = 0; i < forces.size(); ++i) {
      TypeParam& x = scene.position[i];
      const TypeParam at = x;
      const double right = x = at + h;
      const double above = engine.PotentialEnergy(law);
      const double left = x = at - h;
      const double below = engine.PotentialEnergy(law);
      x = at;
      EXPECT_NEAR(forces[i], (below - above) / (right - left), 1e-3 + rounding / (right - left))
          << "pair " << pair << ", number " << i << ", seed " << seed;
      felt += forces[i] != 0;
    }
  }
  EXPECT_GT(felt, 100);
}

/// Returns the current corners of a body.
template <class Real>
std::vector<Vec3<double>> CornersNow(const ContactScene<Real>& scene, Rows rows) {
  std::vector<Vec3<double>> corners;
  for (uint32_t i = 0; i < rows.count; ++i) {
    corners.push_back(scene.Wide(scene.At(scene.position, rows.first + i)));
  }
  return corners;
}

/// Half of the angle [rad] by which a bar is rotated to stand on an edge.
const double kEighth = std::numbers::pi / 8;

/// Returns a square bar along x that stands on an edge; its upper and lower edge are `half` from
/// its axis.
ConvexBody BarAlongX(double length, double half) {
  const double side = half / std::numbers::sqrt2;
  return Turned(Box({length / 2, side, side}), {std::sin(kEighth), 0, 0, std::cos(kEighth)});
}
ConvexBody BarAlongZ(double length, double half) {
  const double side = half / std::numbers::sqrt2;
  return Turned(Box({side, side, length / 2}), {0, 0, std::sin(kEighth), std::cos(kEighth)});
}

// An edge that crosses another right-angled edge at a distance d below it is d / sqrt(2) deep. The
// faces, inclined by 45 degrees, push it with k times this depth, which is k d / 2 upwards. Each
// bar presses into the other bar.
TYPED_TEST(EdgeContactTest, CrossedBarsHoldWhereHardnessCarriesTheWeight) {
  const double k = 1e4, mass = 8;
  ContactScene<TypeParam> scene;
  scene.gravity = {0, static_cast<TypeParam>(-kGravity), 0};
  const Material material{k, std::sqrt(k * mass), 0.5};
  AddBody(scene, BarAlongX(3, 0.25), {}, {}, {0, 0, 0}, material);
  const Rows upper =
      AddBody(scene, BarAlongZ(3, 0.25), {0, 0.5, 0}, {}, {mass / 8, 2e5, 50}, material);
  PhysicsEngine engine = scene.MakeEngine();
  scene.LoadAllLaws(engine);
  engine.Advance(5e-4, 2500);
  double lowest = 1;
  for (const auto& p : CornersNow(scene, upper)) lowest = std::min(lowest, p.y);
  EXPECT_NEAR(0.25 - lowest, mass * kGravity / k, 0.01 * mass * kGravity / k);
  EXPECT_NEAR(Length(scene.CentreVelocity(upper)), 0, 1e-3);
}

// The squared sine of the angle between a face of a regular tetrahedron and the middle plane of its
// edge is 1/3. The push of both faces together is 2/3 of k d, and the damping the same fraction of
// c v. The rest is the bounce of a spring with a damper; see surface_contact_test.cpp.
TYPED_TEST(EdgeContactTest, TetrahedraThatMeetEdgeFirstBounceByTheClosedForm) {
  const double k = 2000, c = 8, speed = 0.5, mass = 4;
  ContactScene<TypeParam> scene;
  const Material material{k, c, 0.3};
  const Frame frame{mass / 4, 1e6, 500};
  const double half = 1 / std::sqrt(8.0);
  const double away = half + 1e-3;
  const Rows lower = AddBody(scene, Tetrahedron(1), {0, -away, 0}, {0, speed, 0}, frame, material);
  const Rows upper = AddBody(scene, Tetrahedron(1), {0, away, 0}, {0, -speed, 0}, frame, material);
  PhysicsEngine engine = scene.MakeEngine();
  scene.LoadAllLaws(engine);
  const Vec3<double> momentum = scene.Momentum(), angular = scene.AngularMomentum();
  engine.Advance(5e-5, 4000);
  EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(200));
  EXPECT_LT(Length(scene.AngularMomentum() - angular), Rounding<TypeParam>(200));
  const double reduced = mass / 2, stiffness = 2 * k / 3, damping = 2 * c / 3;
  const double beta = damping / (2 * reduced), omega = std::sqrt(stiffness / reduced - beta * beta);
  const double phase = std::numbers::pi - std::atan2(2 * beta * omega, omega * omega - beta * beta);
  const double bounce = double{scene.CentreVelocity(upper).y - scene.CentreVelocity(lower).y};
  EXPECT_NEAR(bounce / (2 * speed), std::exp(-beta / omega * phase), 0.01);
}

/// Two masses on a line across a fixed ridge along x. The line is the lower edge of a surface whose
/// third corner is fixed above. Its weight pulls along the ridge with the sine of the angle.
template <class Real>
struct Slider {
  Slider(double tangent, double coefficient) {
    const double angle = std::atan(tangent), k = 1e4;
    scene.Tilt(angle, kGravity);
    const Material material{k, 100, coefficient};
    AddBody(scene, BarAlongX(40, 0.25), {}, {}, {0, 0, 0}, material);
    const double depth = 2 * kGravity * std::cos(angle) / (k / 2);
    const auto y = static_cast<Real>(0.25 - depth);
    rows = {scene.AddBody(1, {0, y, -0.5f}), 2};
    scene.AddBody(1, {0, y, 0.5f});
    const uint32_t above = scene.AddBody(0, {0, 2, 0});
    scene.AddSpring(rows.first, rows.first + 1, 1, 1e4, 20);
    scene.AddSurface({rows.first, rows.first + 1, above}, {0, 0, 0});
    engine.emplace(scene.MakeEngine());
    scene.LoadAllLaws(*engine);
  }
  double X() const { return double{scene.Centre(rows).x}; }
  double Speed() const { return double{scene.CentreVelocity(rows).x}; }

  ContactScene<Real> scene;
  Rows rows;
  std::optional<PhysicsEngine> engine;
};

TYPED_TEST(EdgeContactTest, EdgeRestsBelowTheFrictionAngleWithoutCreeping) {
  Slider<TypeParam> slider(0.49, 0.5);
  slider.engine->Advance(1e-3, 3000);
  const double x = slider.X();
  slider.engine->Advance(1e-3, 4000);
  EXPECT_NEAR(slider.X(), x, Rounding<TypeParam>(1));
  EXPECT_LT(x, 0.01);
}

TYPED_TEST(EdgeContactTest, EdgeSlidesAboveTheFrictionAngleAsCoulombSays) {
  Slider<TypeParam> slider(0.52, 0.5);
  slider.engine->Advance(1e-3, 1000);
  const double speed = slider.Speed(), angle = std::atan(0.52);
  slider.engine->Advance(1e-3, 1000);
  EXPECT_NEAR(slider.Speed() - speed, kGravity * (std::sin(angle) - 0.5 * std::cos(angle)), 1e-3);
}

// A plank lies flat on two ridges. No corner is inside a body, so the long edges carry the plank.
TYPED_TEST(EdgeContactTest, PlankComesToRestOnTwoRidges) {
  const double k = 2e4, mass = 8;
  ContactScene<TypeParam> scene;
  scene.gravity = {0, static_cast<TypeParam>(-kGravity), 0};
  const Material ridge{k, 200, 0.5};
  AddBody(scene, BarAlongX(2, 0.25), {0, 0, -0.6}, {}, {0, 0, 0}, ridge);
  AddBody(scene, BarAlongX(2, 0.25), {0, 0, 0.6}, {}, {0, 0, 0}, ridge);
  const Rows plank = AddBody(scene, Box({0.3, 0.1, 1.2}), {0, 0.36, 0}, {0.2, 0, 0.1},
                             {mass / 8, 1e6, 100}, {0, 0, 0});
  PhysicsEngine engine = scene.MakeEngine();
  scene.LoadAllLaws(engine);
  engine.Advance(2e-4, 10000);
  const double depth = mass * kGravity / (2 * 2 * k / 2);  // 2 ridges, 2 edges, k / 2 for each
  for (const auto& p : CornersNow(scene, plank)) {
    EXPECT_NEAR(p.y < 0.3 ? p.y : p.y - 0.2, 0.25 - depth, 0.1 * depth);
  }
  EXPECT_LT(scene.KineticEnergy(), 1e-6);
}

// The edges of a box that lies flat are as deep as its corners. Only the corners carry the box in
// this case.
TYPED_TEST(EdgeContactTest, WhatCornersCarryIsNotCarriedTwice) {
  const double k = 1e4, mass = 8;
  ContactScene<TypeParam> scene;
  scene.gravity = {0, static_cast<TypeParam>(-kGravity), 0};
  AddBody(scene, Box({1, 0.5, 1}), {}, {}, {0, 0, 0}, {k, 200, 0.5});
  const Rows upper = AddBody(scene, Box({0.3, 0.3, 0.3}), {0.1, 0.801, 0.05}, {},
                             {mass / 8, 2e5, 50}, {k, 200, 0.5});
  PhysicsEngine engine = scene.MakeEngine();
  scene.LoadAllLaws(engine);
  engine.Advance(5e-4, 2000);
  double lowest = 1;
  for (const auto& p : CornersNow(scene, upper)) lowest = std::min(lowest, p.y);
  const double depth = mass * kGravity / (4 * k);
  EXPECT_NEAR(0.5 - lowest, depth, 0.01 * depth);
}

/// Two random bodies that move towards each other.
template <class Real>
struct Meeting {
  Meeting(Random& random, const Frame& frame, const Material& material)
      : shapes{random.Body(), random.Body()} {
    const Vec3<double> way = random.Direction();
    const double speed = random.Between(0.5, 2);
    rows[0] = AddBody(scene, shapes[0], way * -1.35, way * speed, frame, material);
    rows[1] = AddBody(scene, shapes[1], way * 1.35, way * -speed, frame, material);
    engine.emplace(scene.MakeEngine());
    springs = engine->LoadPhysicsLaw("hooke_spring");
    contact = engine->LoadPhysicsLaw("surface_contact");
    engine->LoadPhysicsLaw("newton_motion");
  }
  double Energy() {
    return scene.KineticEnergy() + engine->PotentialEnergy(springs) +
           engine->PotentialEnergy(contact);
  }
  double OverlapNow() const {
    return Overlap(CornersNow(scene, rows[0]), shapes[0], CornersNow(scene, rows[1]), shapes[1]);
  }

  ContactScene<Real> scene;
  std::array<ConvexBody, 2> shapes;
  std::array<Rows, 2> rows;
  std::optional<PhysicsEngine> engine;
  vesper_library_id springs = 0, contact = 0;
};

// At these speeds, the hardness stops masses of 6 kg and more within a tenth of a metre.
TYPED_TEST(EdgeContactTest, ConvexBodiesNeverPassThroughEachOther) {
  const uint32_t seed = 3;
  Random random(seed);
  int met = 0;
  for (int pair = 0; pair < 24; ++pair) {
    Meeting<TypeParam> meeting(random, {1, 2e5, 50}, {2e4, 20, 0.4});
    double deepest = -1;
    for (int n = 0; n < 300; ++n) {
      meeting.engine->Advance(5e-4, 10);
      deepest = std::max(deepest, meeting.OverlapNow());
    }
    EXPECT_LT(deepest, 0.1) << "pair " << pair << ", seed " << seed;
    EXPECT_LT(meeting.OverlapNow(), 0) << "pair " << pair << ", seed " << seed;
    met += deepest > 0.005;
  }
  EXPECT_GT(met, 12);
}

TYPED_TEST(EdgeContactTest, CollisionsWithoutDampingKeepEnergyAndWithItNeverGainAny) {
  const uint32_t seed = 5;
  Random random(seed);
  for (int pair = 0; pair < 6; ++pair) {
    const bool damped = pair % 2 == 1;
    Meeting<TypeParam> meeting(random, {1, 2e5, damped ? 20.0 : 0.0},
                               {2e4, damped ? 20.0 : 0.0, damped ? 0.5 : 0.0});
    const double start = meeting.Energy();
    for (int n = 0; n < 75; ++n) {
      meeting.engine->Advance(1e-4, 200);
      EXPECT_LT(meeting.Energy(), 1.01 * start) << "pair " << pair << ", seed " << seed;
    }
    const double kept = damped ? 0 : 0.99;
    EXPECT_GT(meeting.Energy(), kept * start) << "pair " << pair << ", seed " << seed;
  }
}

TYPED_TEST(EdgeContactTest, HeapOfRandomBodiesHasTheSameBitsOnAnyNumberOfThreads) {
  std::vector<TypeParam> reference;
  for (const uint32_t threads : {1, 2, 8}) {
    Random random(9);
    ContactScene<TypeParam> scene;
    scene.gravity = {0, static_cast<TypeParam>(-kGravity), 0};
    scene.AddGround({1e4, 50, 0.5});
    for (int i = 0; i < 60; ++i) {
      const Vec3<double> at{1.7 * (i % 4), 1.5 + 1.7 * (i / 16), 1.7 * (i / 4 % 4)};
      AddBody(scene, random.Body(), at, {0, -2, 0}, {1, 5000, 5}, {1e4, 50, 0.5});
    }
    PhysicsEngine engine = scene.MakeEngine(threads);
    scene.LoadAllLaws(engine);
    engine.Advance(1.0 / 960, 200);
    if (reference.empty()) reference = scene.position;
    EXPECT_EQ(scene.position, reference) << threads << " threads";
  }
}

}  // namespace
}  // namespace vesper
