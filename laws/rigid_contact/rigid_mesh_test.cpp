// SPDX-License-Identifier: Apache-2.0
// Convex hulls that move, surfaces of triangles, bodies of several shapes, layers and sensors.
#include <cmath>

#include "rigid_scene.hpp"

namespace vesper {
namespace {

using rigid::Quaternion;
using rigid::ShapeCode;
using Vector = Vec3<double>;
using Points = std::vector<Vector>;

constexpr double kFrame = 1.0 / 60, kG = 9.81;

template <class Real>
class RigidMeshTest : public ::testing::Test {};
TYPED_TEST_SUITE(RigidMeshTest, Precisions);

Quaternion TurnBy(Vector axis, double angle) {
  return {axis * std::sin(angle / 2), std::cos(angle / 2)};
}

template <class Real>
RigidScene<Real> Falling() {
  RigidScene<Real> scene;
  scene.gravity = {0, Real(-kG), 0};
  return scene;
}

/// The functions below return the corners of a tetrahedron and an octahedron with edges of length
/// 1, and of a prism with 24 sides.
Points Tetrahedron() {
  const double s = 1 / std::sqrt(8.0);
  return {{s, s, s}, {s, -s, -s}, {-s, s, -s}, {-s, -s, s}};
}
Points Octahedron() {
  const double s = std::sqrt(0.5);
  return {{s, 0, 0}, {-s, 0, 0}, {0, s, 0}, {0, -s, 0}, {0, 0, s}, {0, 0, -s}};
}
Points Prism(int sides, double radius, double height) {
  Points points;
  for (int i = 0; i < 2 * sides; ++i) {
    const double angle = std::acos(-1.0) * 2 * (i / 2) / sides;
    points.push_back({radius * std::cos(angle), i % 2 == 0 ? height / 2 : -height / 2,
                      radius * std::sin(angle)});
  }
  return points;
}

// The centre of a tetrahedron at rest is at 1 / sqrt(24) of the length of its edge. The centre of
// an octahedron is at 1 / sqrt(6).
TYPED_TEST(RigidMeshTest, HullsRestOnAFace) {
  const Vector turned{1 / std::sqrt(2.0), 0, -1 / std::sqrt(2.0)};
  const struct {
    Points points;
    Quaternion q;
    double height;
  } hulls[] = {
      // The face with the normal (-1 -1 -1) points downwards.
      {Tetrahedron(), TurnBy(turned, -std::acos(1 / std::sqrt(3.0))), 1 / std::sqrt(24.0)},
      {Octahedron(), TurnBy(turned, -std::acos(1 / std::sqrt(3.0))), 1 / std::sqrt(6.0)},
      {Prism(24, 0.5, 0.4), {}, 0.2},
      {BoxCorners({1, 0.5, 2}), {}, 0.25},
  };
  for (const auto& hull : hulls) {
    for (const int ground : {0, 1, 2}) {
      RigidScene<TypeParam> scene = Falling<TypeParam>();
      scene.AddHull(hull.points, 3, {0.1, hull.height + 0.05, 0.2}, {}, hull.q);
      if (ground == 0) scene.AddGround();
      if (ground == 1) scene.AddScenery(ShapeCode::kPlane, {20, 0, 20}, {0, 0, 0});
      if (ground == 2) scene.AddTerrain(9, 6, [](double, double) { return 0.0; });
      PhysicsEngine engine = scene.MakeRigidEngine();
      engine.Advance(kFrame, 240);
      SCOPED_TRACE(testing::Message() << hull.points.size() << " corners, ground " << ground);
      EXPECT_NEAR(scene.Position(0).y, hull.height, 2e-3);
      EXPECT_LT(Length(scene.Velocity(0)), 2e-3);
      EXPECT_LT(Length(scene.Spin(0)), 5e-3);
    }
  }
}

// A hull with the corners of a box moves like a box, both in the air and on the ground.
TYPED_TEST(RigidMeshTest, HullOfABoxMovesLikeTheBox) {
  const Vector size{0.4, 0.6, 1};
  RigidScene<TypeParam> box = Falling<TypeParam>(), hull = box;
  const Quaternion q = TurnBy({0.6, 0.8, 0}, 0.4);
  box.AddBox(size, 2, {0, 3, 0}, {1, 0, 0.5}, q);
  hull.AddHull(BoxCorners(size), 2, {0, 3, 0}, {1, 0, 0.5}, q);
  box.spin = hull.spin = {1, 2, 3};
  for (auto* scene : {&box, &hull}) scene->AddGround();
  PhysicsEngine one = box.MakeRigidEngine(), other = hull.MakeRigidEngine();
  one.Advance(kFrame, 30);
  other.Advance(kFrame, 30);
  EXPECT_LT(Length(box.Position(0) - hull.Position(0)), Rounding<TypeParam>(100));
  EXPECT_LT(Length(box.Spin(0) - hull.Spin(0)), Rounding<TypeParam>(1000));
  one.Advance(kFrame, 570);
  other.Advance(kFrame, 570);
  for (auto* scene : {&box, &hull}) {
    EXPECT_NEAR(scene->Position(0).y, 0.2, 2e-3);  // on its largest side
    EXPECT_LT(Length(scene->Velocity(0)) + Length(scene->Spin(0)), 5e-3);
  }
}

TYPED_TEST(RigidMeshTest, StackOfHullsStands) {
  RigidScene<TypeParam> scene = Falling<TypeParam>();
  scene.AddTerrain(8, 4, [](double, double) { return 0.0; });
  for (int i = 0; i < 4; ++i) {
    scene.AddHull(Prism(i % 2 == 0 ? 6 : 24, 0.5, 0.4), 2, {0, 0.2 + 0.4 * i, 0});
  }
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 600);
  for (uint32_t i = 0; i < 4; ++i) {
    EXPECT_LT(Length(scene.Position(i) - Vector{0, 0.2 + 0.4 * i, 0}), 0.01) << i;
    EXPECT_LT(Length(scene.Velocity(i)), 2e-3) << i;
  }
}

// Each shape rests on a large hull, which rests on the ground.
TYPED_TEST(RigidMeshTest, EveryShapeRestsOnAHull) {
  const struct {
    ShapeCode code;
    Vector size;
    double height;
    Quaternion q;
  } shapes[] = {{ShapeCode::kBox, {0.4, 0.2, 0.3}, 0.1, {}},
                {ShapeCode::kSphere, {0.4, 0.4, 0.4}, 0.2, {}},
                {ShapeCode::kCylinder, {0.4, 0.3, 0.4}, 0.15, {}},
                {ShapeCode::kCapsule, {0.2, 0.8, 0.2}, 0.1, TurnBy({0, 0, 1}, std::acos(0.0))}};
  for (const auto& shape : shapes) {
    RigidScene<TypeParam> scene = Falling<TypeParam>();
    scene.AddGround();
    scene.AddHull(Prism(8, 1, 0.5), 50, {0, 0.25, 0});
    scene.Add(shape.code, shape.size, 1, {0.1, 0.55 + shape.height, 0}, {}, shape.q);
    PhysicsEngine engine = scene.MakeRigidEngine();
    engine.Advance(kFrame, 300);
    SCOPED_TRACE(testing::Message() << "shape " << int(shape.code));
    EXPECT_NEAR(scene.Position(1).y, 0.5 + shape.height, 3e-3);
    EXPECT_LT(std::abs(scene.Velocity(1).y), 1e-3);
    EXPECT_LT(Length(scene.Velocity(1)), 0.01) << "it may roll slowly";
  }
}

// Bodies move on a flat surface of many triangles as on one large box, because no edge stops them.
TYPED_TEST(RigidMeshTest, EdgesWithinAFlatSurfaceAreNotFelt) {
  for (const bool ball : {true, false}) {
    RigidScene<TypeParam> flat = Falling<TypeParam>(), cells = flat;
    flat.AddGround();
    cells.AddTerrain(40, 12, [](double, double) { return 0.0; });
    for (auto* scene : {&flat, &cells}) {
      if (ball) {
        scene->AddBall(0.2, 1, {-4, 0.2, 0.07}, {4, 0, 0.3});
      } else {
        scene->AddBox({0.5, 0.2, 0.5}, 1, {-4, 0.1, 0.07}, {4, 0, 0.3});
      }
    }
    PhysicsEngine one = flat.MakeRigidEngine({{"friction", 0.2}});
    PhysicsEngine other = cells.MakeRigidEngine({{"friction", 0.2}});
    for (int i = 0; i < 90; ++i) {
      one.Advance(kFrame);
      other.Advance(kFrame);
      ASSERT_LT(std::abs(cells.Velocity(0).y), 0.02) << "frame " << i << ", ball " << ball;
    }
    EXPECT_LT(Length(flat.Position(0) - cells.Position(0)), 0.01) << "ball " << ball;
    EXPECT_LT(Length(flat.Velocity(0) - cells.Velocity(0)), 0.02) << "ball " << ball;
  }
}

// A ball that rolls without slipping on a ramp of triangles has the acceleration 5/7 g sin(slope).
TYPED_TEST(RigidMeshTest, BallRollsDownATerrainAsTheClosedFormSays) {
  RigidScene<TypeParam> scene = Falling<TypeParam>();
  const double slope = 0.25, radius = 0.3;
  scene.AddTerrain(60, 30, [&](double x, double) { return -std::tan(slope) * x; });
  scene.AddBall(
      radius, 2,
      Vector{-8, std::tan(slope) * 8, 0} + Vector{std::sin(slope), std::cos(slope), 0} * radius);
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 120);
  EXPECT_NEAR(Length(scene.Velocity(0)), 2 * 5.0 / 7 * kG * std::sin(slope), 0.02);
}

// A surface is solid on one side, and a body on its edge falls off.
TYPED_TEST(RigidMeshTest, BodiesPassASurfaceFromBehindAndLeaveItAtItsEdge) {
  RigidScene<TypeParam> scene = Falling<TypeParam>();
  scene.AddTerrain(4, 4, [](double, double) { return 0.0; });
  scene.AddBall(0.2, 1, {0, -1, 0}, {0, 8, 0});
  scene.AddBox({0.5, 0.5, 0.5}, 1, {2.1, 0.25, 0});
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 30);
  EXPECT_GT(scene.Position(0).y, 1);
  engine.Advance(kFrame, 60);
  EXPECT_LT(scene.Position(1).y, -1);
}

// A body of two half boxes moves like the whole box.
TYPED_TEST(RigidMeshTest, PartsMoveLikeTheWhole) {
  const Vector size{1.2, 0.4, 0.6};
  RigidScene<TypeParam> whole = Falling<TypeParam>(), parts = whole;
  const Quaternion q = TurnBy({0.6, 0, 0.8}, 0.3);
  whole.AddBox(size, 2, {0, 2, 0}, {0.5, 0, 0}, q);
  const uint32_t body = parts.Add(ShapeCode::kNone, {}, 2, {0, 2, 0}, {0.5, 0, 0}, q);
  for (const double side : {-1, 1}) {
    const Vector at = Vector{0, 2, 0} + q.Rotate({0.3 * side, 0, 0});
    parts.Attach(parts.AddBox({0.6, 0.4, 0.6}, 0, at, {}, q), body);
  }
  for (auto* scene : {&whole, &parts}) {
    std::copy_n(std::vector<TypeParam>{1, 2, 3}.begin(), 3, scene->spin.begin());
    scene->AddGround();
  }
  PhysicsEngine one = whole.MakeRigidEngine(), other = parts.MakeRigidEngine();
  one.Advance(kFrame, 25);
  other.Advance(kFrame, 25);
  EXPECT_LT(Length(whole.Position(0) - parts.Position(0)), Rounding<TypeParam>(100));
  EXPECT_LT(Length(whole.Spin(0) - parts.Spin(0)), Rounding<TypeParam>(1000));
  one.Advance(kFrame, 575);
  other.Advance(kFrame, 575);
  EXPECT_NEAR(parts.Position(0).y, whole.Position(0).y, 2e-3);
  EXPECT_LT(Length(parts.Velocity(0)) + Length(parts.Spin(0)), 5e-3);
  // The parts have kept their places relative to each other.
  const Vector between = parts.Position(2) - parts.Position(1);
  EXPECT_NEAR(Length(between), 0.6, Rounding<TypeParam>(1e4));
}

// A table stands on its legs, and a ball rests on it.
TYPED_TEST(RigidMeshTest, TableStandsOnItsLegs) {
  RigidScene<TypeParam> scene = Falling<TypeParam>();
  scene.AddTerrain(10, 6, [](double, double) { return 0.0; });
  const uint32_t table = scene.AddBox({2, 0.1, 1}, 10, {0, 1.05, 0});
  for (int i = 0; i < 4; ++i) {
    const Vector at{i % 2 == 0 ? 0.9 : -0.9, 0.5, i < 2 ? 0.4 : -0.4};
    scene.Attach(scene.AddBox({0.1, 1, 0.1}, 0, at), table);
  }
  const uint32_t ball = scene.AddBall(0.2, 1, {0.3, 1.35, 0.1});
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 600);
  EXPECT_NEAR(scene.Position(table).y, 1.05, 3e-3);
  EXPECT_NEAR(scene.Position(ball).y, 1.3, 2e-3);
  EXPECT_LT(Length(scene.Position(table) - Vector{0, 1.05, 0}), 3e-3) << "it creeps";
  EXPECT_LT(Length(scene.Velocity(table)) + Length(scene.Spin(table)), 5e-3);
}

TYPED_TEST(RigidMeshTest, HullsAndPartsKeepMomentumAndGainNoEnergy) {
  RigidScene<TypeParam> scene;
  const Points shapes[] = {Tetrahedron(), Octahedron(), Prism(7, 0.4, 0.6)};
  for (int i = 0; i < 27; ++i) {
    const Vector at{2.0 * (i % 3) - 2, 2.0 * (i / 3 % 3) - 2, 2.0 * (i / 9) - 2};
    const Quaternion q = TurnBy({0, 0.6, 0.8}, i);
    if (i % 4 < 3) {
      scene.AddHull(shapes[i % 4], 1 + i % 3, at, at * -1.0, q);
      continue;
    }
    const uint32_t body = scene.AddBall(0.3, 2, at, at * -1.0);
    scene.inertia.end()[-3] = scene.inertia.end()[-2] = scene.inertia.end()[-1] = 0.3;
    scene.Attach(scene.AddBall(0.3, 0, at + q.Rotate({0.5, 0, 0})), body);
  }
  // The hulls are homogeneous; their moments are those that the law computes.
  PhysicsEngine engine = scene.MakeRigidEngine();
  const Vector momentum = scene.Momentum();
  const double begin = scene.KineticEnergy();
  engine.Advance(kFrame, 120);
  EXPECT_LT(scene.KineticEnergy(), 0.9 * begin) << "they have not met";
  EXPECT_LT(Length(scene.Momentum() - momentum), Rounding<TypeParam>(1e5));
}

TYPED_TEST(RigidMeshTest, BodiesPassTheLayersTheyName) {
  RigidScene<TypeParam> scene = Falling<TypeParam>();
  scene.has_layers = true;
  scene.AddGround();
  scene.AddBox({1, 1, 1}, 1, {0, 0.5, 0});
  const uint32_t ghost = scene.AddBox({1, 1, 1}, 1, {0, 2, 0});
  const uint32_t other = scene.AddBox({1, 1, 1}, 1, {0, 3.5, 0});
  scene.layer[0] = 3;
  scene.passes[ghost] = 1 << 3;
  scene.layer[other] = 2;
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 300);
  EXPECT_NEAR(scene.Position(0).y, 0.5, 2e-3);
  EXPECT_NEAR(scene.Position(ghost).y, 0.5, 2e-3) << "it passes the box, not the ground";
  EXPECT_NEAR(scene.Position(other).y, 1.5, 4e-3) << "it passes nothing";
}

TYPED_TEST(RigidMeshTest, SensorsCountAndExertNoForce) {
  RigidScene<TypeParam> scene = Falling<TypeParam>(), without = scene;
  scene.has_layers = true;
  for (auto* one : {&scene, &without}) {
    one->AddBall(0.2, 1, {0, 2, 0});
    one->AddGround();
  }
  const uint32_t sensor = scene.AddBox({1, 0.5, 1}, 0, {0, 1, 0});
  scene.sensor[sensor] = 1;
  PhysicsEngine engine = scene.MakeRigidEngine(), free = without.MakeRigidEngine();
  bool inside = false;
  for (int i = 0; i < 120; ++i) {
    const double height = scene.Position(0).y;  // the law reads it at the start of the step
    engine.Advance(kFrame);
    free.Advance(kFrame);
    EXPECT_EQ(scene.touch_count[sensor], std::abs(height - 1) < 0.45 ? 1 : 0) << height;
    inside = inside || scene.touch_count[sensor] > 0;
  }
  EXPECT_TRUE(inside);
  EXPECT_EQ(scene.Position(0), without.Position(0));
  EXPECT_EQ(scene.touch_count[0], 1) << "the ball lies on the ground";
}

// Rolling friction with the lever arm b slows a ball by 5/7 b g / r.
TYPED_TEST(RigidMeshTest, RollingFrictionIsMeasuredBack) {
  for (const double arm : {0.002, 0.01}) {
    RigidScene<TypeParam> scene = Falling<TypeParam>();
    scene.has_rolling = true;
    scene.AddGround();
    scene.AddBall(0.25, 2, {0, 0.25, 0}, {2, 0, 0});
    scene.spin = {0, 0, -8};
    scene.rolling[0] = TypeParam(arm);
    PhysicsEngine engine = scene.MakeRigidEngine();
    engine.Advance(kFrame, 30);
    const double before = scene.Velocity(0).x;
    engine.Advance(kFrame, 60);
    EXPECT_NEAR(before - scene.Velocity(0).x, 5.0 / 7 * arm * kG / 0.25, 0.02 * arm * kG / 0.25);
  }
}

TYPED_TEST(RigidMeshTest, RollingFrictionHoldsABallOnASmallSlope) {
  for (const bool steep : {false, true}) {
    const double angle = steep ? 0.06 : 0.03;  // the ball rolls above b / r = 0.04
    RigidScene<TypeParam> scene;
    scene.gravity = {TypeParam(kG * std::sin(angle)), TypeParam(-kG * std::cos(angle)), 0};
    scene.AddGround();
    scene.AddBall(0.25, 2, {0, 0.25, 0});
    PhysicsEngine engine = scene.MakeRigidEngine({{"rollingFriction", 0.01}});
    engine.Advance(kFrame, 300);
    if (steep) {
      const double most = kG * std::sin(angle), held = 0.04 * kG * std::cos(angle);
      EXPECT_NEAR(scene.Velocity(0).x, 5 * 5.0 / 7 * (most - held), 0.02);
    } else {
      EXPECT_LT(scene.Position(0).x, 0.01);
    }
  }
}

}  // namespace
}  // namespace vesper
