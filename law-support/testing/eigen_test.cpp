// SPDX-License-Identifier: Apache-2.0
// Tests law_eigen.hpp with the real engine: forces against the equation, and equal bits on a CPU
// with wider vectors.
#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <type_traits>

#include "scene.hpp"
#include "vesper/law_eigen.hpp"

namespace vesper {
namespace {

const std::string kLaws = SDK_TEST_FOLDER "libvesper_law_sdk_test_eigen.so";
const std::string kLawsForAvx2 = SDK_TEST_FOLDER "libvesper_law_sdk_test_eigen_avx2.so";

using ConstVector = decltype(VectorAt(std::declval<Read<Vec3<float>>&>(), 0));
using Vector = decltype(VectorAt(std::declval<Accumulate<Vec3<float>>&>(), 0));
static_assert(std::is_same_v<ConstVector, Eigen::Map<const Eigen::Vector3f>>);
static_assert(std::is_same_v<Vector, Eigen::Map<Eigen::Vector3f>>);
static_assert(std::is_same_v<decltype(ArrayOf(std::declval<ReadWrite<double>&>())),
                             Eigen::Map<Eigen::Array<double, 1, Eigen::Dynamic>>>);

template <class Real>
class EigenTest : public ::testing::Test {
 protected:
  EigenTest() : scene_(RandomNetwork<Real>(101, 7)) {
    scene_.mass[0] = 2;  // the accelerometer divides by this mass
    acceleration_.resize(scene_.position.size());
  }

  /// Runs one step of the laws in `library`.
  void Step(const std::string& library, std::vector<Real>* orientation = nullptr) {
    PhysicsEngine engine = scene_.MakeEngine();
    engine.PropertyProvider().AddPhysicalProperty("acceleration", acceleration_);
    if (orientation) engine.PropertyProvider().AddPhysicalProperty("orientation", *orientation);
    engine.LoadPhysicsLaw(library);
    engine.Advance(0.01);
  }

  Vec3<double> ExpectedForce(uint64_t row) const {
    Vec3<double> moment;
    double mass = 0;
    for (uint64_t i = 0; i < scene_.mass.size(); ++i) {
      moment += Wide(scene_.position, i) * double{scene_.mass[i]};
      mass += double{scene_.mass[i]};
    }
    const Vec3<double> omega{1, 2, -0.5}, r = Wide(scene_.position, row) - moment * (1 / mass);
    return Cross(omega, Cross(omega, r)) * -double{scene_.mass[row]};
  }

  Vec3<double> Wide(const std::vector<Real>& column, uint64_t row) const {
    return scene_.Wide(scene_.At(column, row));
  }

  Scene<Real> scene_;
  std::vector<Real> acceleration_;
};
TYPED_TEST_SUITE(EigenTest, Precisions);

TYPED_TEST(EigenTest, RowsAndColumnsAreWhatTheEquationSays) {
  this->Step(kLaws);
  for (uint64_t i = 0; i < this->scene_.mass.size(); ++i) {
    const Vec3<double> force = this->ExpectedForce(i);
    const Vec3<double> error = this->Wide(this->scene_.external_force, i) - force;
    EXPECT_LE(Length(error), Rounding<TypeParam>(100 * (Length(force) + 1))) << "row " << i;
    for (uint64_t k = 3 * i; k < 3 * i + 3; ++k) {
      EXPECT_EQ(this->acceleration_[k], this->scene_.external_force[k] / this->scene_.mass[i]);
    }
  }
}

TYPED_TEST(EigenTest, QuaternionsAreUnitQuaternionsXyzw) {
  const TypeParam half = std::sqrt(TypeParam(0.5));
  std::vector<TypeParam> turned;  // a rotation by 90 degrees about z: the body's x axis is the
                                  // world's y axis
  for (uint64_t i = 0; i < this->scene_.mass.size(); ++i) {
    turned.insert(turned.end(), {0, 0, half, half});
  }
  this->Step(kLaws, &turned);
  for (uint64_t i = 0; i < this->scene_.mass.size(); ++i) {
    const Vec3<double> a =
        this->Wide(this->scene_.external_force, i) * (1 / double{this->scene_.mass[i]});
    const Vec3<double> error = this->Wide(this->acceleration_, i) - Vec3<double>{a.y, -a.x, a.z};
    EXPECT_LE(Length(error), Rounding<TypeParam>(10 * Length(a))) << "row " << i;
  }
}

TYPED_TEST(EigenTest, CompilingForAWiderCpuChangesNoBit) {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    GTEST_SKIP() << "this CPU has no AVX2 and FMA";
  }
  for (uint32_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    this->scene_ = RandomNetwork<TypeParam>(101, seed);
    // The bodies are far from the origin, where the last bit of the sum of masses affects every
    // force.
    for (TypeParam& x : this->scene_.position) x += 1000;
    this->scene_.mass[0] = 2;
    this->Step(kLaws);
    const std::vector<TypeParam> expected = this->scene_.external_force;
    this->Step(kLawsForAvx2);
    EXPECT_EQ(this->scene_.external_force, expected);
  }
}

TYPED_TEST(EigenTest, FailedAssertionOfEigenIsAFailureOfTheLaw) {
  PhysicsEngine engine = this->scene_.MakeEngine();
  engine.PropertyProvider().AddPhysicalProperty("acceleration", this->acceleration_);
  const auto id = engine.LoadPhysicsLaw(kLaws, {{"act", 1}});
  try {
    engine.Advance(0.01);
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), VESPER_LAW_FAILED);
    EXPECT_EQ(error.library(), id);
    EXPECT_NE(std::string(error.what()).find("law unequal: Eigen: expected"), std::string::npos)
        << error.what();
  }
}

std::string ReadFile(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(EigenPageTest, ExampleOfThePageIsTheLawTestedHere) {
  const std::string page = ReadFile(VESPER_DOCS "/writing-a-law.md");
  const std::string law = ReadFile(TEST_SOURCES "/sdk_test_eigen.cpp");
  const std::string fence = "```cpp\n";
  const size_t begin = page.find(fence, page.find("## Equations with Eigen"));
  ASSERT_NE(begin, std::string::npos);
  const size_t end = page.find("```", begin + fence.size());
  const std::string example = page.substr(begin + fence.size(), end - begin - fence.size());
  EXPECT_NE(law.find(example), std::string::npos) << example;
}

}  // namespace
}  // namespace vesper
