// SPDX-License-Identifier: Apache-2.0
// Laws that are compiled and are there as text too give the same numbers, up to rounding.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "scene.hpp"

namespace vesper {
namespace {

constexpr uint64_t kBodies = 300, kSprings = 900;

template <class Real>
struct Twins : Scene<Real> {
  std::vector<Real> charge, linear, quadratic;
  std::vector<Real> gravitation{Real(0.7)}, softening{Real(0.05)}, coulomb{Real(1.5)};
  std::vector<Real> electric{1, -2, Real(0.5)}, magnetic{Real(0.3), 2, -1};

  Twins() {
    std::mt19937 random(20260);
    const auto draw = [&](double low, double high) {
      return static_cast<Real>(low + (high - low) * (static_cast<double>(random()) / 4294967296.0));
    };
    for (uint64_t i = 0; i < kBodies; ++i) {
      const Real mass = i % 7 == 0 ? Real(0) : draw(0.5, 2);
      this->AddBody(mass, {draw(-3, 3), draw(-3, 3), draw(-3, 3)},
                    {draw(-1, 1), draw(-1, 1), draw(-1, 1)});
      charge.push_back(draw(-1, 1));
      linear.push_back(draw(0, 1));
      quadratic.push_back(draw(0, 1));
    }
    for (uint32_t i = 0; i < kSprings; ++i) {
      const uint32_t a = i % kBodies, b = (a + 1 + i / kBodies * 3) % kBodies;
      this->AddSpring(a, i % 50 == 0 ? a : b, draw(0.1, 2), draw(1, 5), draw(0, 1));
    }
    this->gravity = {Real(0.1), Real(-9.81), Real(0.3)};
  }

  PhysicsEngine Engine() {
    PhysicsEngine engine = this->MakeEngine();
    PhysicalPropertyProvider provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("charge", charge);
    provider.AddPhysicalProperty("linearDragCoefficient", linear);
    provider.AddPhysicalProperty("dragCoefficient", quadratic);
    provider.AddPhysicalProperty("gravitationalConstant", gravitation);
    provider.AddPhysicalProperty("softening", softening);
    provider.AddPhysicalProperty("coulombConstant", coulomb);
    provider.AddPhysicalProperty("electricField", electric);
    provider.AddPhysicalProperty("magneticField", magnetic);
    return engine;
  }
};

template <class Real>
void ExpectNear(const std::vector<Real>& text, const std::vector<Real>& compiled,
                const std::string& what) {
  Real largest = 0;
  for (const Real value : compiled) largest = std::max(largest, std::abs(value));
  EXPECT_GT(largest, 0) << what;
  const Real tolerance = largest * 64 * std::numeric_limits<Real>::epsilon();
  for (size_t i = 0; i < text.size(); ++i) {
    ASSERT_NEAR(text[i], compiled[i], tolerance) << what << ", value " << i;
  }
}

/// Runs some steps with a law and an integrator, and returns the potential energy of the law.
template <class Real>
double Run(Twins<Real>& world, const std::string& law, bool integrates) {
  PhysicsEngine engine = world.Engine();
  if (integrates) {
    engine.LoadPhysicsLaw("gravity_field");
    engine.LoadPhysicsLaw("drag");
  }
  const vesper_library_id id = engine.LoadPhysicsLaw(law);
  if (!integrates) engine.LoadPhysicsLaw("newton_motion");
  engine.Advance(1.0 / 256, 5);
  try {
    return engine.PotentialEnergy(id, 0);
  } catch (const Error&) {
    return 0;
  }
}

template <class Real>
class TwinTest : public ::testing::Test {};
TYPED_TEST_SUITE(TwinTest, Precisions);

TYPED_TEST(TwinTest, TextAndCompiledLawGiveTheSameNumbers) {
  const std::pair<const char*, bool> laws[] = {
      {"gravity_field", false},      {"drag", false},
      {"lorentz_field", false},      {"hooke_spring", false},
      {"newton_gravitation", false}, {"coulomb", false},
      {"newton_motion", true},       {"velocity_verlet", true},
      {"runge_kutta4", true}};
  for (const auto& [law, integrates] : laws) {
    Twins<TypeParam> compiled, text;
    const std::string name = law;
    const double expected = Run(compiled, name, integrates);
    const double energy = Run(text, name + ".law", integrates);
    ExpectNear(text.external_force, compiled.external_force, name + ", force");
    ExpectNear(text.velocity, compiled.velocity, name + ", velocity");
    ExpectNear(text.position, compiled.position, name + ", position");
    EXPECT_NEAR(energy, expected,
                std::abs(expected) * 1e3 * std::numeric_limits<TypeParam>::epsilon())
        << name;
  }
}

}  // namespace
}  // namespace vesper
