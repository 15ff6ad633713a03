// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>

#include "rigid_scene.hpp"

namespace vesper {
namespace {

using rigid::JointType;
using rigid::Quaternion;
using rigid::ShapeCode;
using Vector = Vec3<double>;

constexpr double kFrame = 1.0 / 60, kG = 9.81;
const std::vector<ParameterValue> kSleeps = {{"sleepTime", 0.5}};

template <class Real>
class RigidSleepTest : public ::testing::Test {};
TYPED_TEST_SUITE(RigidSleepTest, Precisions);

/// Returns a scene with gravity and a stack of boxes of 2 kg on immovable scenery.
template <class Real>
RigidScene<Real> Stack(int boxes) {
  RigidScene<Real> scene;
  scene.gravity = {0, Real(-kG), 0};
  scene.AddGround();
  for (int i = 0; i < boxes; ++i) scene.AddBox({1, 1, 1}, 2, {0, 0.5 + i, 0});
  return scene;
}

template <class Real>
PhysicsEngine Sleeping(RigidScene<Real>& scene, uint32_t threads = 1) {
  scene.asleep.assign(scene.mass.size(), 7);
  return scene.MakeRigidEngine(kSleeps, threads);
}

template <class Real>
int64_t Asleep(const RigidScene<Real>& scene) {
  return std::count(scene.asleep.begin(), scene.asleep.end(), 1);
}

/// The work of the law in some steps.
struct Work {
  uint64_t pairs = 0, contacts = 0;
};

/// Advances a scene by the steps, and returns the work of the law in them.
template <class Real>
Work WorkOf(RigidScene<Real>& scene, double sleep_time, uint32_t before, uint32_t steps) {
  Work work;
  scene.law = RIGID_TEST_FOLDER "libvesper_law_counted_rigid_contact.so";
  scene.log = [&](uint32_t, const char* line) {
    size_t pairs = 0, contacts = 0;
    const char* found = std::strstr(line, "pairs ");
    ASSERT_TRUE(found != nullptr &&
                std::sscanf(found, "pairs %zu contacts %zu", &pairs, &contacts) == 2)
        << line;
    work.pairs += pairs;
    work.contacts += contacts;
  };
  PhysicsEngine engine = scene.MakeRigidEngine({{"sleepTime", sleep_time}});
  engine.Advance(kFrame, before);
  work = {};
  engine.Advance(kFrame, steps);
  return work;
}

TYPED_TEST(RigidSleepTest, SleepingStackCostsNoContacts) {
  auto awake = Stack<TypeParam>(5), asleep = Stack<TypeParam>(5);
  // A ball that bounces far from the stack keeps the law at work.
  for (auto* scene : {&awake, &asleep}) scene->AddBall(0.5, 1, {20, 300, 0});
  const Work all = WorkOf(awake, 0, 120, 60), rest = WorkOf(asleep, 0.5, 120, 60);
  EXPECT_GE(all.contacts, 5u * 60);
  EXPECT_GE(all.pairs, 5u * 60);
  EXPECT_EQ(rest.contacts, 0u);
  EXPECT_EQ(rest.pairs, 0u);
}

TYPED_TEST(RigidSleepTest, SleepingStackStaysWhereItIsToTheBit) {
  auto scene = Stack<TypeParam>(5), awake = Stack<TypeParam>(5);
  PhysicsEngine engine = Sleeping(scene), other = awake.MakeRigidEngine();
  engine.Advance(kFrame, 25);
  other.Advance(kFrame, 25);
  EXPECT_EQ(Asleep(scene), 0) << "it has not rested for half a second";
  EXPECT_EQ(scene.position, awake.position);
  engine.Advance(kFrame, 95);
  ASSERT_EQ(Asleep(scene), 5);
  const auto position = scene.position, orientation = scene.orientation;
  engine.Advance(kFrame, 600);
  other.Advance(kFrame, 695);
  EXPECT_EQ(Asleep(scene), 5);
  EXPECT_EQ(scene.position, position);
  EXPECT_EQ(scene.orientation, orientation);
  EXPECT_EQ(scene.TotalKineticEnergy(), 0);
  for (uint32_t i = 0; i < 5; ++i) {
    EXPECT_LT(Length(scene.Position(i) - awake.Position(i)), 1e-3) << i;
  }
}

TYPED_TEST(RigidSleepTest, SleepIsOffByDefault) {
  auto scene = Stack<TypeParam>(3);
  scene.asleep.assign(3, 7);
  PhysicsEngine engine = scene.MakeRigidEngine();
  engine.Advance(kFrame, 300);
  EXPECT_EQ(scene.asleep, std::vector<int32_t>(3, 0));
}

// A ball without friction hits a sleeping box, without restitution. Both then have the speed of the
// centre of mass, so the box has its own mass already in the step of the impact.
TYPED_TEST(RigidSleepTest, SleepingBoxTakesItsShareOfTheMomentumOfABallThatHitsIt) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddGround();
  scene.AddBox({1, 1, 1}, 2, {0, 0.5, 0});
  scene.AddBall(0.5, 3, {-6.97, 0.5, 0}, {4, 0, 0});
  scene.asleep.assign(2, 7);
  PhysicsEngine engine = scene.MakeRigidEngine({{"sleepTime", 0.5}, {"friction", 0}});
  engine.Advance(kFrame, 60);
  ASSERT_EQ(scene.asleep, (std::vector<int32_t>{1, 0}));
  engine.Advance(kFrame, 60);
  EXPECT_EQ(Asleep(scene), 0);
  EXPECT_NEAR(scene.Velocity(0).x, 3 * 4 / 5.0, 2e-3);
  EXPECT_NEAR(scene.Velocity(1).x, 3 * 4 / 5.0, 2e-3);
}

/// A change that must wake a sleeping stack of three boxes (rows 1 to 3) on an immovable box
/// (row 0).
template <class Real>
struct Change {
  const char* name;
  std::function<void(RigidScene<Real>&)> make;
};

TYPED_TEST(RigidSleepTest, AnyChangeWakesTheWholeStack) {
  using Scene = RigidScene<TypeParam>;
  const Change<TypeParam> changes[] = {
      {"place", [](Scene& s) { s.position[3 * 2] += TypeParam(1e-3); }},
      {"velocity", [](Scene& s) { s.velocity[3 * 3 + 1] = TypeParam(1e-3); }},
      {"spin", [](Scene& s) { s.spin[3 * 1 + 2] = TypeParam(1e-3); }},
      {"rotation", [](Scene& s) { s.orientation[4 * 2] = TypeParam(1e-3); }},
      {"mass", [](Scene& s) { s.mass[3] = 3; }},
      {"inertia", [](Scene& s) { s.inertia[3 * 2] = 1; }},
      {"size", [](Scene& s) { s.size[3 * 3] = 0.5; }},
      {"shape", [](Scene& s) { s.shape[3] = int32_t(ShapeCode::kSphere); }},
      {"force", [](Scene& s) { s.applied_force[3 * 3] = TypeParam(0.5); }},
      {"gravity", [](Scene& s) { s.gravity[1] *= TypeParam(1.01); }},
      {"rolling friction", [](Scene& s) { s.rolling[1] = TypeParam(0.1); }},
      {"spin friction", [](Scene& s) { s.spinning[1] = TypeParam(0.1); }},
      {"layer", [](Scene& s) { s.layer[2] = 3; }},
      {"support moved", [](Scene& s) { s.position[0] += TypeParam(1e-3); }},
      {"support turned", [](Scene& s) { s.orientation[1] = TypeParam(1e-3); }},
      {"support resized", [](Scene& s) { s.size[0] += 1e-3; }},
      {"support away", [](Scene& s) { s.position[0] = 100; }},
      {"scenery near", [](Scene& s) { s.scenery_position[0] = TypeParam(1.005); }},
  };
  for (const auto& change : changes) {
    SCOPED_TRACE(change.name);
    Scene scene;
    scene.gravity = {0, TypeParam(-kG), 0};
    scene.has_layers = scene.has_rolling = scene.has_spinning = true;
    scene.AddBox({4, 1, 4}, 0, {0, -0.5, 0});
    for (int i = 0; i < 3; ++i) scene.AddBox({1, 1, 1}, 2, {0, 0.5 + i, 0});
    scene.AddBox({1, 1, 1}, 2, {1.6, 0.5, 1.6});  // an island of its own
    scene.AddScenery(ShapeCode::kBox, {1, 1, 1}, {50, 2.5, 0});
    PhysicsEngine engine = Sleeping(scene);
    engine.Advance(kFrame, 120);
    ASSERT_EQ(scene.asleep, (std::vector<int32_t>{0, 1, 1, 1, 1}));
    engine.Advance(kFrame, 60);
    ASSERT_EQ(Asleep(scene), 4);
    change.make(scene);
    engine.Advance(kFrame);
    EXPECT_EQ(scene.asleep[1] + scene.asleep[2] + scene.asleep[3], 0);
    engine.Advance(kFrame, 60);
    for (const TypeParam x : scene.position) ASSERT_TRUE(std::isfinite(x));
  }
}

TYPED_TEST(RigidSleepTest, OtherIslandsSleepOn) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddGround();
  for (int i = 0; i < 4; ++i) scene.AddBox({1, 1, 1}, 2, {3.0 * i, 0.5, 0});
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(kFrame, 120);
  ASSERT_EQ(Asleep(scene), 4);
  const Vector at = scene.Position(2);
  scene.velocity[3 * 1] = -2;
  engine.Advance(kFrame, 20);
  EXPECT_EQ(scene.asleep, (std::vector<int32_t>{1, 0, 1, 1}));
  EXPECT_EQ(scene.Position(2), at);
  engine.Advance(kFrame, 120);
  EXPECT_EQ(Asleep(scene), 4) << "it sleeps again";
}

// After its support has gone, the body falls as the closed form of the integrator says: n steps
// from rest give the height -g dt^2 n (n + 1) / 2.
TYPED_TEST(RigidSleepTest, BodyFallsWhenItsSupportIsRemoved) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddBox({1, 1, 1}, 2, {0, 10.5, 0});
  scene.AddBox({9, 1, 9}, 0, {0, 9.5, 0});
  scene.AddBox({1, 1, 1}, 2, {3, 10.5, 0});
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(kFrame, 120);
  ASSERT_EQ(scene.asleep, (std::vector<int32_t>{1, 0, 1}));
  const double top = scene.Position(0).y;
  // The last row takes the place of the support, as a client does when it removes an item.
  for (uint32_t k = 0; k < 3; ++k) {
    scene.position[3 + k] = scene.position[6 + k];
    scene.size[3 + k] = scene.size[6 + k];
  }
  scene.mass[1] = 2;
  scene.mass[2] = 0;
  scene.position[6] = 1000;
  engine.MoveRow("body", 2, 1);
  engine.Advance(kFrame, 30);
  const double way = kG * kFrame * kFrame * 30 * 31 / 2;
  EXPECT_NEAR(scene.Position(0).y, top - way, 1e-4);
  EXPECT_NEAR(scene.Position(1).y, top - way, 1e-4);
}

// The scenery of a world may change its rows without a change of the bodies on it.
TYPED_TEST(RigidSleepTest, RowsOfSceneryDoNotMatter) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddGround();
  scene.AddScenery(ShapeCode::kBox, {1, 1, 1}, {50, 0.5, 0});
  scene.AddBox({1, 1, 1}, 2, {0, 0.5, 0});
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(kFrame, 120);
  ASSERT_EQ(Asleep(scene), 1);
  for (uint32_t k = 0; k < 3; ++k) {
    std::swap(scene.scenery_position[k], scene.scenery_position[3 + k]);
    std::swap(scene.scenery_size[k], scene.scenery_size[3 + k]);
  }
  engine.Advance(kFrame, 30);
  EXPECT_EQ(Asleep(scene), 1);
  scene.scenery_size[4] = 1;  // the ground becomes thinner
  engine.Advance(kFrame);
  EXPECT_EQ(Asleep(scene), 0);
}

TYPED_TEST(RigidSleepTest, ChangeOfAParameterWakes) {
  auto scene = Stack<TypeParam>(2);
  scene.asleep.assign(2, 7);
  PhysicsEngine engine = scene.MakeEngine();
  {
    PhysicalPropertyProvider provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("shape", scene.shape);
    provider.AddPhysicalProperty("size", scene.size);
    provider.AddPhysicalProperty("orientation", scene.orientation);
    provider.AddPhysicalProperty("angularVelocity", scene.spin);
    provider.AddPhysicalProperty("sceneryShape", scene.scenery_shape);
    provider.AddPhysicalProperty("scenerySize", scene.scenery_size);
    provider.AddPhysicalProperty("sceneryPosition", scene.scenery_position);
    provider.AddPhysicalProperty("sceneryOrientation", scene.scenery_orientation);
    provider.AddPhysicalProperty("asleep", scene.asleep);
  }
  engine.LoadPhysicsLaw("gravity_field");
  vesper_library_id law = engine.LoadPhysicsLaw("rigid_contact", kSleeps);
  engine.Advance(kFrame, 120);
  ASSERT_EQ(Asleep(scene), 2);
  const auto reload = [&](std::vector<ParameterValue> parameters) {
    const std::vector<std::byte> state = engine.SaveState();
    engine.UnloadPhysicsLaw(law);
    law = engine.LoadPhysicsLaw("rigid_contact", parameters);
    engine.LoadState(state);
    engine.Advance(kFrame);
  };
  reload({{"sleepTime", 0.5}});
  EXPECT_EQ(Asleep(scene), 2) << "the same parameters";
  reload({{"sleepTime", 0.5}, {"friction", 0.4}});
  EXPECT_EQ(Asleep(scene), 0);
  engine.Advance(kFrame, 120);
  ASSERT_EQ(Asleep(scene), 2);
  reload({{"sleepTime", 0.5}, {"friction", 0.4}, {"spinFriction", 0.01}});
  EXPECT_EQ(Asleep(scene), 0);
}

TYPED_TEST(RigidSleepTest, SlowIncreaseOfAForceWakesBeforeTheBoxShouldSlide) {
  auto scene = Stack<TypeParam>(1);
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(kFrame, 120);
  ASSERT_EQ(Asleep(scene), 1);
  scene.applied_force[0] = TypeParam(1e-3);  // 0.0005 m/s^2
  engine.Advance(kFrame);
  EXPECT_EQ(Asleep(scene), 1) << "too weak to matter";
  // The box slides when the force exceeds 0.5 * 2 kg * g = 9.81 N.
  for (int i = 0; i < 1200; ++i) {
    scene.applied_force[0] = TypeParam(0.01 * i);
    engine.Advance(kFrame);
    if (i < 970) {
      EXPECT_LT(Length(scene.Velocity(0)), 0.02) << i;
    }
  }
  EXPECT_GT(scene.Velocity(0).x, 0.1);
}

// Without an immovable shape that holds them, bodies keep their momentum.
TYPED_TEST(RigidSleepTest, BodiesThatNothingHoldsDriftOn) {
  RigidScene<TypeParam> scene;
  scene.AddBox({1, 1, 1}, 2, {0, 0, 0}, {0.01, 0, 0});
  scene.AddBox({1, 1, 1}, 2, {0, 1, 0}, {0.01, 0, 0});
  scene.AddBox({1, 1, 1}, 2, {5, 1, 0}, {0, 0.01, 0});
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(kFrame, 600);
  EXPECT_EQ(Asleep(scene), 0);
  EXPECT_NEAR(scene.Position(0).x, 0.1, 1e-4);
  EXPECT_NEAR(scene.Position(2).y, 1.1, 1e-4);
}

/// Returns boxes that fall on the ground and on each other.
template <class Real>
RigidScene<Real> Pile(int count) {
  std::mt19937 random(3);
  const auto draw = [&](double size) { return size * (random() / 4294967296.0 - 0.5); };
  RigidScene<Real> scene;
  scene.gravity = {0, Real(-kG), 0};
  scene.AddGround();
  for (int i = 0; i < count; ++i) {
    const Vector at{1.3 * (i % 6) + draw(0.3), 0.8 + 1.2 * (i / 36), 1.3 * (i / 6 % 6) + draw(0.3)};
    scene.AddBox(i % 3 == 0 ? Vector{0.7, 0.7, 0.7} : Vector{1, 0.8, 1}, 1 + i % 2, at);
  }
  scene.asleep.assign(scene.mass.size(), 7);
  return scene;
}

TYPED_TEST(RigidSleepTest, PileFallsAsleepWithTheSameBitsOnAnyNumberOfThreads) {
  RigidScene<TypeParam> one = Pile<TypeParam>(108), two = one;
  PhysicsEngine alone = Sleeping(one), together = Sleeping(two, 4);
  bool some = false;
  for (int i = 0; i < 60; ++i) {
    alone.Advance(kFrame, 10);
    together.Advance(kFrame, 10);
    ASSERT_EQ(one.position, two.position) << i;
    ASSERT_EQ(one.spin, two.spin) << i;
    ASSERT_EQ(one.asleep, two.asleep) << i;
    some = some || (Asleep(one) > 0 && Asleep(one) < 108);
  }
  for (uint32_t i = 0; i < 108; ++i) {
    if (!one.asleep[i])
      std::printf("%u %d at %.3f %.3f %.3f v %.4f w %.4f\n", i, one.shape[i], one.Position(i).x,
                  one.Position(i).y, one.Position(i).z, Length(one.Velocity(i)),
                  Length(one.Spin(i)));
  }
  EXPECT_TRUE(some) << "it should fall asleep in parts";
  EXPECT_EQ(Asleep(one), 108);
}

TYPED_TEST(RigidSleepTest, SavedStateContinuesWithTheSameBits) {
  RigidScene<TypeParam> scene = Pile<TypeParam>(108);
  PhysicsEngine engine = Sleeping(scene);
  for (int i = 0; i < 8; ++i) {
    engine.Advance(kFrame, 60);
    RigidScene<TypeParam> copy = scene;
    PhysicsEngine other = copy.MakeRigidEngine(kSleeps, 2);
    other.LoadState(engine.SaveState());
    RigidScene<TypeParam> straight = scene;
    PhysicsEngine third = straight.MakeRigidEngine(kSleeps);
    third.LoadState(engine.SaveState());
    for (auto* one : {&copy, &straight}) one->velocity[3 * 7 + 1] += 3;  // wakes a part
    other.Advance(kFrame, 60);
    third.Advance(kFrame, 20);
    const auto state = third.SaveState();
    RigidScene<TypeParam> last = straight;
    PhysicsEngine fourth = last.MakeRigidEngine(kSleeps);
    fourth.LoadState(state);
    fourth.Advance(kFrame, 40);
    ASSERT_EQ(copy.position, last.position) << i;
    ASSERT_EQ(copy.velocity, last.velocity) << i;
    ASSERT_EQ(copy.asleep, last.asleep) << i;
  }
}

TYPED_TEST(RigidSleepTest, ArmThatMotorsHoldSleepsUntilAMotorTurns) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddBox({0.1, 0.1, 0.1}, 0, {0, 0, 0});
  uint32_t last = 0;
  for (int link = 0; link < 3; ++link) {
    const uint32_t next = scene.AddBox({0.4, 0.1, 0.1}, 2.0 - 0.5 * link, {0.2 + 0.4 * link, 0, 0});
    scene.Join(JointType::kHinge, last, next, {0.4 * link, 0, 0}, {0, 0, 1});
    last = next;
  }
  scene.motor_speed = {0, 0, 0};
  scene.motor_torque = {100, 100, 100};
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(1.0 / 240, 480);
  ASSERT_EQ(scene.asleep, (std::vector<int32_t>{0, 1, 1, 1}));
  const auto force = scene.joint_force;
  EXPECT_NEAR(force[1], 4.5 * kG, 0.1);
  const double before = scene.Position(last).y;
  engine.Advance(1.0 / 240, 480);
  EXPECT_EQ(scene.joint_force, force) << "the load stays readable";
  EXPECT_EQ(scene.Position(last).y, before);
  // The speed is below sleepSpeed, but a joint that its motor turns does not rest.
  scene.motor_speed[2] = TypeParam(0.02);
  engine.Advance(1.0 / 240, 1200);
  EXPECT_EQ(Asleep(scene), 0);
  EXPECT_NEAR(scene.joint_angle[2], 0.1, 5e-3);
  scene.motor_speed[2] = 0;
  engine.Advance(1.0 / 240, 480);
  EXPECT_EQ(Asleep(scene), 3);
  scene.position[1] = TypeParam(0.5);  // of the immovable body at which the arm hangs
  engine.Advance(1.0 / 240);
  EXPECT_EQ(Asleep(scene), 0);
}

/// A rod of 1 kg that hangs from an immovable box, asleep.
template <class Real>
RigidScene<Real> HangingRod() {
  RigidScene<Real> scene;
  scene.gravity = {0, Real(-kG), 0};
  scene.AddBox({0.2, 0.2, 0.2}, 0, {0, 10, 0});
  scene.AddBox({0.1, 1.6, 0.1}, 1, {0, 9, 0});
  scene.Join(JointType::kHinge, 0, 1, {0, 9.8, 0}, {0, 0, 1});
  scene.breaking_force = {0};
  return scene;
}

TYPED_TEST(RigidSleepTest, SleepingJointBreaksWhenItsStrengthFalls) {
  RigidScene<TypeParam> scene = HangingRod<TypeParam>();
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(1.0 / 240, 480);
  ASSERT_EQ(Asleep(scene), 1);
  scene.breaking_force[0] = TypeParam(0.5 * kG);  // half of the rod's weight
  engine.Advance(1.0 / 240, 240);
  EXPECT_EQ(scene.broken[0], 1);
  EXPECT_LT(scene.Position(1).y, 6) << "after 1 s of free fall";
}

TYPED_TEST(RigidSleepTest, BodiesThatCorrectionsMoveStayAwakeUntilTheyArrive) {
  RigidScene<TypeParam> scene = HangingRod<TypeParam>();
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(1.0 / 240, 480);
  ASSERT_EQ(Asleep(scene), 1);
  const double before = scene.Position(1).y;
  scene.anchor[1] += 4;
  engine.Advance(1.0 / 240, 1200);
  EXPECT_NEAR(scene.Position(1).y, before + 4, 1e-2);
  EXPECT_EQ(Asleep(scene), 1) << "it sleeps in its new place";
}

TYPED_TEST(RigidSleepTest, SleepingBodiesKeepTheirContactForcesAndTouches) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.has_layers = true;
  scene.AddBox({4, 1, 4}, 0, {0, -0.5, 0});
  for (int i = 0; i < 3; ++i) scene.AddBox({1, 1, 1}, 2, {0, 0.5 + i, 0});
  scene.AddBox({0.5, 3, 0.5}, 0, {0, 1.5, 0});
  scene.sensor[4] = 1;
  scene.reaction.assign(scene.position.size(), 0);
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(kFrame, 180);
  ASSERT_EQ(Asleep(scene), 3);
  const double expected[] = {-6 * kG, 2 * kG, 2 * kG, 2 * kG};
  for (uint32_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(scene.reaction[3 * i + 1], expected[i], 2e-3 * 6 * kG) << i;
  }
  EXPECT_EQ(scene.touch_count, (std::vector<int32_t>{1, 3, 3, 2, 3}));
}

// A client may compute the places of attached items itself, with other rounding errors.
TYPED_TEST(RigidSleepTest, BodyOfSeveralShapesSleepsUntilAPartMoves) {
  RigidScene<TypeParam> scene;
  scene.gravity = {0, TypeParam(-kG), 0};
  scene.AddGround();
  const uint32_t body = scene.AddBox({1, 1, 1}, 2, {0, 0.5, 0});
  const uint32_t part = scene.AddBox({1, 1, 1}, 0, {1, 0.5, 0});
  scene.Attach(part, body);
  PhysicsEngine engine = Sleeping(scene);
  engine.Advance(kFrame, 120);
  ASSERT_EQ(Asleep(scene), 2);
  for (int i = 0; i < 60; ++i) {
    const TypeParam to = i % 2 == 0 ? TypeParam(2) : TypeParam(0);
    scene.position[3 * part] = std::nextafter(scene.position[3 * part], to);
    engine.Advance(kFrame);
  }
  EXPECT_EQ(Asleep(scene), 2);
  scene.position[3 * part + 1] += TypeParam(0.1);
  engine.Advance(kFrame);
  EXPECT_EQ(Asleep(scene), 0);
}

}  // namespace
}  // namespace vesper
