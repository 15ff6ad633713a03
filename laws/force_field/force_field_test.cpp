// SPDX-License-Identifier: Apache-2.0
#include <atomic>

#include "scene.hpp"

namespace vesper {
namespace {

/// The field f(x) = -k (x - centre), provided by a client.
struct Trap {
  double stiffness;
  Vec3<double> centre;
  std::atomic<uint64_t> calls = 0, positions = 0;

  static void Evaluate(void* user, uint64_t count, const double* at, double* out) {
    auto& trap = *static_cast<Trap*>(user);
    ++trap.calls;
    trap.positions += count;
    const double centre[] = {trap.centre.x, trap.centre.y, trap.centre.z};
    for (uint64_t i = 0; i < 3 * count; ++i) out[i] = -trap.stiffness * (at[i] - centre[i % 3]);
  }
  vesper_field Function() { return {sizeof(vesper_field), 0, this, &Evaluate}; }
};

template <class Real>
class ForceFieldTest : public ::testing::Test {};
TYPED_TEST_SUITE(ForceFieldTest, Precisions);

TYPED_TEST(ForceFieldTest, EveryBodyFeelsTheFieldWhereItIs) {
  for (const uint32_t bodies : {1u, 128u, 129u, 3000u}) {
    Scene<TypeParam> scene;
    for (uint32_t i = 0; i < bodies; ++i) scene.AddBody(i % 3, {TypeParam(i), 2, TypeParam(i) / 4});
    Trap trap{2, {1, 0, -1}};
    PhysicsEngine engine = scene.MakeEngine(2);
    engine.PropertyProvider().SetField("forceField", trap.Function());
    engine.LoadPhysicsLaw("force_field");
    engine.Advance(0.01);
    for (uint32_t i = 0; i < bodies; ++i) {
      const Vec3<TypeParam> at = scene.At(scene.position, i);
      const Vec3<TypeParam> expected{-2 * (at.x - 1), -2 * at.y, -2 * (at.z + 1)};
      ASSERT_EQ(scene.At(scene.external_force, i), expected) << i;
    }
    EXPECT_EQ(trap.positions, bodies);
    EXPECT_EQ(trap.calls, (bodies + 127) / 128);
  }
}

TYPED_TEST(ForceFieldTest, BodyInAHarmonicTrapSwingsAsTheClosedFormSays) {
  Scene<TypeParam> scene;
  scene.AddBody(2, {3, 0, 1}, {0, 4, 0});
  Trap trap{8, {1, 0, 1}};
  PhysicsEngine engine = scene.MakeEngine();
  engine.PropertyProvider().SetField("forceField", trap.Function());
  engine.LoadPhysicsLaw("force_field");
  engine.LoadPhysicsLaw("runge_kutta4");
  const uint32_t steps = 600;
  const double time = 3;
  engine.Advance(time / steps, steps);
  const double tolerance = 1e-7 + Rounding<TypeParam>(steps * 4);
  EXPECT_NEAR(scene.position[0], 1 + 2 * std::cos(2 * time), tolerance);
  EXPECT_NEAR(scene.position[1], 2 * std::sin(2 * time), tolerance);
  EXPECT_EQ(scene.position[2], 1);
}

TYPED_TEST(ForceFieldTest, MassZeroFeelsTheForceAndNeverMoves) {
  Scene<TypeParam> scene;
  scene.AddBody(0, {3, 0, 1});
  Trap trap{8, {1, 0, 1}};
  PhysicsEngine engine = scene.MakeEngine();
  engine.PropertyProvider().SetField("forceField", trap.Function());
  engine.LoadPhysicsLaw("force_field");
  engine.LoadPhysicsLaw("newton_motion");
  engine.Advance(0.1, 10);
  EXPECT_EQ(scene.external_force, (std::vector<TypeParam>{-16, 0, 0}));
  EXPECT_EQ(scene.position, (std::vector<TypeParam>{3, 0, 1}));
}

TYPED_TEST(ForceFieldTest, FieldThatTheClientReplacesActsFromTheNextStepOn) {
  Scene<TypeParam> scene;
  scene.AddBody(1, {1, 0, 0});
  Trap weak{1, {}}, strong{4, {}};
  PhysicsEngine engine = scene.MakeEngine();
  engine.PropertyProvider().SetField("forceField", weak.Function());
  engine.LoadPhysicsLaw("force_field");
  engine.Advance(0.1);
  EXPECT_EQ(scene.external_force[0], -1);
  engine.PropertyProvider().SetField("forceField", strong.Function());
  engine.Advance(0.1);
  EXPECT_EQ(scene.external_force[0], -4);
}

TYPED_TEST(ForceFieldTest, WorldWithoutTheFieldIsToldWhatIsMissing) {
  Scene<TypeParam> scene;
  scene.AddBody(1, {1, 0, 0});
  PhysicsEngine engine = scene.MakeEngine();
  engine.LoadPhysicsLaw("force_field");
  try {
    engine.Advance(0.1);
    FAIL() << "ran without the field";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), VESPER_NOT_FOUND);
    EXPECT_EQ(error.property(), "forceField");
  }
}

}  // namespace
}  // namespace vesper
