// SPDX-License-Identifier: Apache-2.0
// Tests the OpenCL laws alone, together, and mixed with laws of the CPU.
#include <cstdlib>
#include <initializer_list>

#include "scene.hpp"

namespace vesper {
namespace {

constexpr double kG = 1, kSoftening = 0.05;

template <class Real>
class OpenClTest : public ::testing::Test {
 protected:
  static constexpr bool kDoubles = std::is_same_v<Real, double>;
  static constexpr double kRounding = kDoubles ? 1e-12 : 2e-5;

  /// Creates a cloud of 100 bodies of about 1/100 kg within 1 m, the first of them immovable.
  OpenClTest() {
    std::mt19937_64 random(20);
    std::uniform_real_distribution<double> number(-1, 1);
    const auto next = [&] { return static_cast<Real>(number(random)); };
    for (int i = 0; i < 100; ++i) {
      const Real mass = i == 0 ? Real(0) : Real(0.01) + Real(0.001) * next();
      const Vec3<Real> at{next(), next(), next()}, moving{next(), next(), next()};
      scene_.AddBody(mass, at, moving * Real(0.1));
    }
  }

  PhysicsEngine MakeEngine(Scene<Real>& scene, bool validate = true, bool deferred = false) {
    PhysicsEngine engine(kDoubles ? "si-f64" : "si-f32",
                         {.validate = validate, .law_path = VESPER_LAW_PATH, .deferred = deferred});
    PhysicalPropertyProvider provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("mass", scene.mass);
    provider.AddPhysicalProperty("position", scene.position);
    provider.AddPhysicalProperty("velocity", scene.velocity);
    provider.AddPhysicalProperty("externalForce", scene.external_force);
    provider.AddPhysicalProperty("gravity", scene.gravity);
    provider.AddPhysicalProperty("gravitationalConstant", constant_);
    provider.AddPhysicalProperty("softening", softening_);
    return engine;
  }

  /// Returns the scene after `steps` steps with these laws.
  Scene<Real> After(int steps, std::initializer_list<const char*> laws) {
    Scene<Real> scene = scene_;
    PhysicsEngine engine = MakeEngine(scene);
    for (const char* law : laws) engine.LoadPhysicsLaw(law);
    engine.Advance(0.01, steps);
    return scene;
  }

  static double Largest(const std::vector<Real>& values) {
    double largest = 0;
    for (const Real value : values) largest = std::max(largest, std::abs(double{value}));
    return largest;
  }
  static void ExpectNear(const std::vector<Real>& found, const std::vector<Real>& expected) {
    const double tolerance = kRounding * Largest(expected);
    for (size_t i = 0; i < expected.size(); ++i) {
      ASSERT_NEAR(double{found[i]}, double{expected[i]}, tolerance) << "value " << i;
    }
  }

  Scene<Real> scene_;
  std::vector<Real> constant_ = {Real(kG)};
  std::vector<Real> softening_ = {Real(kSoftening)};
};

using Reals = ::testing::Types<float, double>;
TYPED_TEST_SUITE(OpenClTest, Reals);

TYPED_TEST(OpenClTest, ForcesAreThoseOfADirectSumInDoubles) {
  for (const double fast : {0.0, 1.0}) {
    Scene<TypeParam> scene = this->scene_;
    PhysicsEngine engine = this->MakeEngine(scene);
    engine.LoadPhysicsLaw("opencl_gravitation", {{"fast", fast}});
    engine.Advance(0.01);
    std::vector<TypeParam> expected;
    for (uint64_t i = 0; i < scene.mass.size(); ++i) {
      Vec3<double> pull;
      for (uint64_t j = 0; j < scene.mass.size(); ++j) {
        const auto a = scene.At(scene.position, i), b = scene.At(scene.position, j);
        const Vec3<double> d{double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z};
        const double squared = Dot(d, d) + kSoftening * kSoftening;
        pull += d * (kG * scene.mass[i] * scene.mass[j] / (squared * std::sqrt(squared)));
      }
      for (const double force : {pull.x, pull.y, pull.z}) expected.push_back(TypeParam(force));
    }
    this->ExpectNear(scene.external_force, expected);
  }
}

TYPED_TEST(OpenClTest, LawsOfTheDeviceAndOfTheCpuMoveBodiesAlikeInAnyMixture) {
  const auto cpu = this->After(100, {"newton_gravitation", "newton_motion"});
  for (const auto& laws : {std::initializer_list<const char*>{"opencl_nbody"},
                           {"opencl_gravitation", "newton_motion"},
                           {"newton_gravitation", "opencl_motion"},
                           {"opencl_gravitation", "opencl_motion"}}) {
    const auto other = this->After(100, laws);
    this->ExpectNear(other.position, cpu.position);
    this->ExpectNear(other.velocity, cpu.velocity);
  }
  EXPECT_NE(cpu.position, this->scene_.position);
}

TYPED_TEST(OpenClTest, ForcesOfOtherLawsAreSummedWithThoseOfTheSuite) {
  this->scene_.gravity = {0, TypeParam(-9.81), 0};
  const auto cpu = this->After(50, {"newton_gravitation", "gravity_field", "newton_motion"});
  const auto mixed = this->After(50, {"opencl_nbody", "gravity_field"});
  this->ExpectNear(mixed.position, cpu.position);
  this->ExpectNear(mixed.external_force, cpu.external_force);
}

TYPED_TEST(OpenClTest, OnlyWhatTheClientAsksForComesBack) {
  Scene<TypeParam> scene = this->scene_;
  PhysicsEngine engine = this->MakeEngine(scene, false, true);
  engine.LoadPhysicsLaw("opencl_nbody");
  engine.Advance(0.01, 10);
  EXPECT_EQ(scene.position, this->scene_.position);  // the array is stale: new values are on the
                                                     // device
  engine.Synchronize({"position"});
  EXPECT_NE(scene.position, this->scene_.position);
  EXPECT_EQ(scene.velocity, this->scene_.velocity);
  const auto expected = this->After(10, {"opencl_nbody"});
  EXPECT_EQ(scene.position, expected.position);
  engine.Synchronize({"velocity", "externalForce"});
  EXPECT_EQ(scene.velocity, expected.velocity);
  EXPECT_EQ(scene.external_force, expected.external_force);
}

TYPED_TEST(OpenClTest, WhatTheClientEditsReachesTheDevice) {
  Scene<TypeParam> scene = this->scene_;
  PhysicsEngine engine = this->MakeEngine(scene);
  engine.LoadPhysicsLaw("opencl_nbody");
  engine.Advance(0.01, 5);
  for (auto* column : {&scene.position, &scene.velocity}) (*column)[30] += TypeParam(0.25);
  Scene<TypeParam> reference = scene;
  engine.PropertyProvider().Touch({"position", "velocity"});
  engine.Advance(0.01, 5);
  PhysicsEngine fresh = this->MakeEngine(reference);
  fresh.LoadPhysicsLaw("opencl_nbody");
  fresh.Advance(0.01, 5);
  EXPECT_EQ(scene.position, reference.position);
}

TYPED_TEST(OpenClTest, MassZeroNeitherMovesNorPulls) {
  const auto after = this->After(20, {"opencl_nbody"});
  EXPECT_EQ(after.At(after.position, 0), this->scene_.At(this->scene_.position, 0));
  EXPECT_EQ(after.At(after.external_force, 0), Vec3<TypeParam>{});
}

TYPED_TEST(OpenClTest, NoBodiesAreFine) {
  this->scene_ = {};
  EXPECT_TRUE(this->After(2, {"opencl_nbody"}).position.empty());
}

/// Expects that the suite is refused in a process whose environment contains this variable.
void ExpectRefusal(const char* variable, const char* value, const char* reason) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // a process that has not loaded a driver yet
  EXPECT_EXIT(
      {
        setenv(variable, value, 1);
        PhysicsEngine engine("si-f64", {.law_path = VESPER_LAW_PATH});
        try {
          engine.LoadPhysicsLaw("opencl_nbody");
        } catch (const Error& error) {
          std::fprintf(stderr, "%s", error.what());
        }
        engine.LoadPhysicsLaw("newton_motion");  // other columns are unchanged
        std::exit(engine.Laws(1).size() == 1 ? 0 : 1);
      },
      ::testing::ExitedWithCode(0), reason);
}

TEST(OpenClRefusalTest, MachineWithoutADeviceIsToldSoAndGoesOn) {
  ExpectRefusal("OCL_ICD_VENDORS", "/nonexistent", "no OpenCL device on this machine");
}

TEST(OpenClRefusalTest, NumberOfADeviceThatIsNotThereIsNamed) {
  ExpectRefusal("VESPER_OPENCL_DEVICE", "200", "VESPER_OPENCL_DEVICE is '200'");
}

}  // namespace
}  // namespace vesper
