// SPDX-License-Identifier: Apache-2.0
// Laws that are compiled and are there as text too give the same numbers, up to rounding. Each
// folder of laws/ has such a text, or the README of laws/ says why it has none.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <regex>
#include <set>
#include <sstream>
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

/// The laws that this test compares, and whether each is an integrator.
constexpr std::pair<const char*, bool> kTwins[] = {
    {"gravity_field", false},      {"drag", false},
    {"lorentz_field", false},      {"hooke_spring", false},
    {"newton_gravitation", false}, {"coulomb", false},
    {"newton_motion", true},       {"velocity_verlet", true},
    {"runge_kutta4", true}};

TYPED_TEST(TwinTest, TextAndCompiledLawGiveTheSameNumbers) {
  for (const auto& [law, integrates] : kTwins) {
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

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns the folders of laws/ and whether each contains a text of its name.
std::map<std::string, bool> LawFolders() {
  std::map<std::string, bool> folders;
  for (const auto& entry : std::filesystem::directory_iterator(LAW_SOURCES)) {
    if (!entry.is_directory()) continue;
    const std::string name = entry.path().filename();
    folders[name] = std::filesystem::exists(entry.path() / (name + ".law"));
  }
  return folders;
}

TEST(TwinsTest, EveryTextOfTheFoldersIsCompared) {
  std::set<std::string> compared, texts;
  for (const auto& [law, integrates] : kTwins) compared.insert(law);
  for (const auto& [law, has_text] : LawFolders()) {
    if (has_text) texts.insert(law);
  }
  // The test of angular_motion compares its text on bodies that rotate.
  const std::string spinning = ReadFile(LAW_SOURCES "/angular_motion/angular_motion_test.cpp");
  EXPECT_NE(spinning.find("\"angular_motion.law\""), std::string::npos);
  compared.insert("angular_motion");
  EXPECT_EQ(compared, texts);
}

/// The last column of the table in laws/README.md is `NAME.law` files or the reason for none.
TEST(TwinsTest, EachFolderHasATextOrTheReadmeSaysWhyItHasNone) {
  const std::string page = ReadFile(LAW_SOURCES "/README.md");
  std::map<std::string, std::string> told;
  const std::regex link("\\[([a-z0-9_]+)\\]\\([a-z0-9_]+/README\\.md\\)");
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| [")) continue;
    ASSERT_TRUE(line.ends_with(" |")) << line;
    const size_t last = line.rfind(" | ");
    const std::string names = line.substr(0, line.find(" | "));
    for (std::sregex_iterator name(names.begin(), names.end(), link), end; name != end; ++name) {
      told[(*name)[1]] = line.substr(last + 3, line.size() - last - 5);
    }
  }
  const std::map<std::string, bool> folders = LawFolders();
  EXPECT_EQ(told.size(), folders.size());
  for (const auto& [law, has_text] : folders) {
    ASSERT_TRUE(told.contains(law)) << law;
    const bool says_text = told[law].find("(" + law + "/" + law + ".law)") != std::string::npos;
    EXPECT_EQ(says_text, has_text) << law << ": " << told[law];
    EXPECT_EQ(told[law].starts_with("no: "), !has_text) << law << ": " << told[law];
  }
}

}  // namespace
}  // namespace vesper
