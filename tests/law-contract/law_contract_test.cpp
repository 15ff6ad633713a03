// What every law library promises, checked on every library in a folder.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <regex>
#include <set>
#include <span>

#include "vesper/kit/law_file.hpp"
#include "vesper/kit/world.hpp"

namespace vesper {
namespace {

std::string law_folder = VESPER_LAW_PATH;
std::string source_folder = VESPER_LAW_SOURCES;

constexpr uint32_t kSeed = 20260;
constexpr double kDt = 1.0 / 240;

std::vector<std::string> LawFiles() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(law_folder)) {
    if (!LawFile::NameOf(entry.path()).empty()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// A test per library.
class LawFileContract : public ::testing::TestWithParam<std::string> {
 protected:
  const std::string name_ = LawFile::NameOf(GetParam());
};

/// A test per library and precision.
class LawContract
    : public ::testing::TestWithParam<std::tuple<std::string, vesper_scalar_type>> {
 protected:
  World MakeWorld(uint64_t rows, uint32_t seed = kSeed) const {
    return World(real_type_, rows, seed);
  }
  /// Claims that all laws of the library make.
  bool Claims(uint32_t claim) const {
    return std::ranges::all_of(laws_, [&](const auto* law) { return (law->claims & claim) != 0; });
  }
  /// Of sums over some hundred numbers of that size.
  double Tolerance(double size) const {
    return size * (real_type_ == VESPER_F64 ? 1e-12 : 1e-4);
  }
  /// Uses of all laws of the library.
  std::vector<vesper_property_use> Uses() const {
    std::vector<vesper_property_use> uses;
    for (const vesper_law_desc* law : laws_) {
      uses.insert(uses.end(), law->uses, law->uses + law->use_count);
    }
    return uses;
  }
  std::set<std::string> Written() const {
    std::set<std::string> names;
    for (const vesper_property_use& use : Uses()) {
      if (use.access != VESPER_READ) names.insert(use.name);
    }
    return names;
  }
  /// What the laws wrote must agree, up to rounding.
  void ExpectSameResults(const World& a, const World& b, double slack = 1) const {
    for (const std::string& name : Written()) {
      const AnyColumn &x = a[name], &y = b[name];
      for (uint64_t i = 0; i < x.size(); ++i) {
        ASSERT_NEAR(x.Get(i), y.Get(i), Tolerance(slack * (1 + x.Largest())))
            << name << ", row " << i / x.descriptor().components << ", seed " << kSeed;
      }
    }
  }

  const std::string file_ = std::get<0>(GetParam());
  const vesper_scalar_type real_type_ = std::get<1>(GetParam());
  const LawFile library_{file_};
  const std::vector<const vesper_law_desc*> laws_ = library_.Laws(real_type_);
};

// --- the file ------------------------------------------------------------------------------------

TEST_P(LawFileContract, ExportsItsEntryAndNothingElse) {
  EXPECT_EQ(LawFile(GetParam()).Exports(), std::vector<std::string>{VESPER_LAW_LIBRARY_ENTRY});
}

TEST_P(LawFileContract, TakesSymbolsFromTheStandardLibrariesOnly) {
  const std::regex allowed(".*\\((libc\\.so\\.6|libm\\.so\\.6|libstdc\\+\\+\\.so\\.6.*|"
                           "libgcc_s\\.so\\.1|ld-linux.*)\\)");
  const std::vector<std::string> imports = LawFile(GetParam()).Imports();
  EXPECT_FALSE(imports.empty());
  for (const std::string& import : imports) {
    EXPECT_TRUE(std::regex_match(import, allowed)) << import;
  }
}

TEST_P(LawFileContract, LinksTheStandardLibrariesOnly) {
  const std::set<std::string> allowed{"libc.so.6", "libm.so.6", "libstdc++.so.6", "libgcc_s.so.1",
                                      "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"};
  for (const std::string& needed : LawFile(GetParam()).Needed()) {
    EXPECT_TRUE(allowed.contains(needed)) << needed;
  }
}

TEST_P(LawFileContract, ReadmeHasTheSectionsThatUsersNeed) {
  const std::string path = source_folder + "/" + name_ + "/README.md";
  std::ifstream file(path);
  ASSERT_TRUE(file) << path;
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  for (const char* section : {"Equation", "Properties", "Parameters", "Mass 0", "Limits"}) {
    EXPECT_NE(text.find("\n## " + std::string(section) + "\n"), std::string::npos) << section;
  }
  const LawFile library(GetParam());
  for (const vesper_law_desc* law : library.Laws(VESPER_F64)) {
    for (const auto& use : std::span(law->uses, law->use_count)) {
      EXPECT_NE(text.find("`" + std::string(use.name) + "`"), std::string::npos) << use.name;
    }
    for (const auto& parameter : std::span(law->parameters, law->parameter_count)) {
      EXPECT_NE(text.find("`" + std::string(parameter.name) + "`"), std::string::npos)
          << parameter.name;
    }
  }
}

TEST_P(LawFileContract, TableIsComplete) {
  const LawFile file(GetParam());
  EXPECT_EQ(file.table().name, name_);
  EXPECT_EQ(file.table().abi_version, VESPER_ABI_VERSION);
  EXPECT_EQ(file.table().open == nullptr, file.table().close == nullptr);
  ASSERT_GT(file.table().law_count, 0u);
  for (const auto& law : std::span(file.table().laws, file.table().law_count)) {
    SCOPED_TRACE(law.name);
    EXPECT_TRUE(std::regex_match(law.name, std::regex("[a-z][a-z0-9_]*")));
    EXPECT_TRUE(std::regex_match(law.version, std::regex("\\d+\\.\\d+\\.\\d+")));
    EXPECT_NE(std::string(law.doc), "");
    EXPECT_GE(law.phase, VESPER_PHASE_FORCE);
    EXPECT_LE(law.phase, VESPER_PHASE_OBSERVE);
    EXPECT_EQ(law.stages > 0, law.phase == VESPER_PHASE_INTEGRATE);
    EXPECT_GT(law.use_count, 0u);
    EXPECT_TRUE(law.create && law.bind && law.advance && law.destroy);
    for (const auto& parameter : std::span(law.parameters, law.parameter_count)) {
      EXPECT_LE(parameter.minimum, parameter.default_value) << parameter.name;
      EXPECT_LE(parameter.default_value, parameter.maximum) << parameter.name;
      EXPECT_NE(std::string(parameter.doc), "") << parameter.name;
    }
  }
}

TEST_P(LawFileContract, BothPrecisionsDeclareTheSame) {
  const LawFile file(GetParam());
  const auto f32 = file.Laws(VESPER_F32), f64 = file.Laws(VESPER_F64);
  ASSERT_EQ(f32.size(), f64.size());
  for (size_t i = 0; i < f32.size(); ++i) {
    EXPECT_STREQ(f32[i]->name, f64[i]->name);
    EXPECT_EQ(f32[i]->claims, f64[i]->claims);
    ASSERT_EQ(f32[i]->use_count, f64[i]->use_count);
    for (uint32_t u = 0; u < f32[i]->use_count; ++u) {
      const vesper_property_use &a = f32[i]->uses[u], &b = f64[i]->uses[u];
      EXPECT_STREQ(a.name, b.name);
      EXPECT_EQ(a.access, b.access) << a.name;
      EXPECT_EQ(a.scalar_type == VESPER_F32, b.scalar_type == VESPER_F64) << a.name;
    }
  }
}

// --- the law in an engine ------------------------------------------------------------------------

/// Mappings of law libraries in this process.
int CountMappings() {
  std::ifstream maps("/proc/self/maps");
  int count = 0;
  for (std::string line; std::getline(maps, line);) {
    if (line.find("libvesper_law_") != std::string::npos) ++count;
  }
  return count;
}

size_t CountOpenFiles() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return static_cast<size_t>(std::distance(begin(files), end(files)));
}

TEST_P(LawContract, LoadsAndUnloadsAHundredTimesAndLeavesNothing) {
  World world = MakeWorld(7);
  PhysicsEngine engine = world.MakeEngine(file_);
  engine.UnloadPhysicsLaw(1);
  const int mappings = CountMappings();
  const size_t files = CountOpenFiles();
  for (int i = 0; i < 100; ++i) {
    const vesper_library_id id = engine.LoadPhysicsLaw(file_);
    engine.Advance(kDt);
    ASSERT_GT(CountMappings(), mappings);
    engine.UnloadPhysicsLaw(id);
  }
  EXPECT_EQ(CountMappings(), mappings);
  EXPECT_EQ(CountOpenFiles(), files);
}

TEST_P(LawContract, RunsOnAnyNumberOfRows) {
  for (const uint64_t rows : {0, 1, 7, 1021}) {
    SCOPED_TRACE(rows);
    World world = MakeWorld(rows);
    PhysicsEngine engine = world.MakeEngine(file_);
    engine.Advance(kDt, 3);
    EXPECT_EQ(engine.StepCount(), 3u);
  }
}

TEST_P(LawContract, SameBitsForAnyNumberOfThreads) {
  const uint64_t rows = 40009;  // several chunks for every thread
  World one = MakeWorld(rows);
  PhysicsEngine reference = one.MakeEngine(file_, 1);
  reference.Advance(kDt, 2);
  for (const uint32_t threads : {2, 8}) {
    World many = MakeWorld(rows);
    PhysicsEngine engine = many.MakeEngine(file_, threads);
    engine.Advance(kDt, 2);
    EXPECT_EQ(engine.StateHash(), reference.StateHash()) << threads << " threads";
    for (const AnyColumn& column : one.columns()) {
      const std::string name = column.descriptor().name;
      EXPECT_EQ(many[name].bytes(), column.bytes()) << name << ", " << threads << " threads";
    }
  }
}

TEST_P(LawContract, EveryParameterTakesItsLimits) {
  for (const vesper_law_desc* law : laws_) {
    for (const auto& parameter : std::span(law->parameters, law->parameter_count)) {
      World world = MakeWorld(7);
      PhysicsEngine engine = world.MakeEngine(file_);
      engine.UnloadPhysicsLaw(1);
      const std::string name = std::string(law->name) + "." + parameter.name;
      engine.UnloadPhysicsLaw(engine.LoadPhysicsLaw(file_, {{name, parameter.minimum}}));
      engine.UnloadPhysicsLaw(engine.LoadPhysicsLaw(file_, {{name, parameter.maximum}}));
    }
  }
}

// An input that is not a number is reported, or it has no influence at all: never a silent NaN.
TEST_P(LawContract, NotANumberInAnInputIsReportedOrHasNoInfluence) {
  const uint64_t rows = 7;
  int reported = 0;
  for (const vesper_property_use& use : Uses()) {
    World clean = MakeWorld(rows), poisoned = MakeWorld(rows);
    AnyColumn& input = poisoned[use.name];
    if (!input.is_real() || (use.access & VESPER_READ) == 0) continue;
    if ((input.descriptor().law_access & VESPER_ACCUMULATE) != 0) continue;  // the engine's own sum
    SCOPED_TRACE(use.name);
    input.Set(input.rows() / 2 * use.components, std::numeric_limits<double>::quiet_NaN());
    PhysicsEngine reference = clean.MakeEngine(file_), engine = poisoned.MakeEngine(file_);
    reference.Advance(kDt);
    try {
      engine.Advance(kDt);
      for (const std::string& name : Written()) {
        EXPECT_EQ(poisoned[name].bytes(), clean[name].bytes()) << name;
      }
    } catch (const Error& error) {
      ++reported;
      EXPECT_TRUE(error.status() == VESPER_LAW_MISBEHAVED || error.status() == VESPER_LAW_FAILED)
          << error.what();
      EXPECT_TRUE(std::ranges::any_of(laws_, [&](auto* l) { return l->name == error.law(); }))
          << error.what();
      EXPECT_TRUE(Written().contains(std::string(error.property()))) << error.what();
      EXPECT_NE(std::string(error.what()).find(error.law()), std::string::npos) << error.what();
    }
  }
  EXPECT_TRUE(reported > 0 || Written().empty());
}

// --- claims --------------------------------------------------------------------------------------

TEST_P(LawContract, ForcesSumToZeroIfItClaimsMomentum) {
  if (!Claims(VESPER_CLAIM_MOMENTUM)) return;
  World world = MakeWorld(101);
  world.Clear("appliedForce");
  PhysicsEngine engine = world.MakeEngine(file_);
  engine.Advance(kDt);
  const AnyColumn& force = world["externalForce"];
  Vec3<double> sum;
  for (uint64_t i = 0; i < force.rows(); ++i) sum += force.GetVector(i);
  EXPECT_GT(force.Largest(), 0);
  EXPECT_LT(Length(sum), Tolerance(force.Largest())) << "seed " << kSeed;
}

TEST_P(LawContract, MomentsSumToZeroIfItClaimsAngularMomentum) {
  if (!Claims(VESPER_CLAIM_ANGULAR_MOMENTUM)) return;
  World world = MakeWorld(101);
  world.Clear("appliedForce");
  PhysicsEngine engine = world.MakeEngine(file_);
  engine.Advance(kDt);
  const AnyColumn &force = world["externalForce"], &torque = world["torque"];
  Vec3<double> sum;
  for (uint64_t i = 0; i < force.rows(); ++i) {
    sum += Cross(world["position"].GetVector(i), force.GetVector(i)) + torque.GetVector(i);
  }
  EXPECT_GT(force.Largest(), 0);
  EXPECT_LT(Length(sum), Tolerance(10 * force.Largest())) << "seed " << kSeed;
}

TEST_P(LawContract, MovingTheOriginChangesNothingElseIfItClaimsTranslation) {
  if (!Claims(VESPER_CLAIM_TRANSLATION)) return;
  const Vec3<double> by{8, -4, 16};
  World here = MakeWorld(101), there = MakeWorld(101);
  there.Translate(by);
  PhysicsEngine engine_here = here.MakeEngine(file_), engine_there = there.MakeEngine(file_);
  engine_here.Advance(kDt, 4);
  engine_there.Advance(kDt, 4);
  here.Translate(by);
  ExpectSameResults(here, there, 10);
}

TEST_P(LawContract, TurningTheWorldTurnsTheResultsIfItClaimsRotation) {
  if (!Claims(VESPER_CLAIM_ROTATION)) return;
  const Quaternion by{{0.1, -0.5, 0.7}, 0.5};  // of length 1
  World straight = MakeWorld(101), turned = MakeWorld(101);
  turned.Rotate(by);
  PhysicsEngine engine_straight = straight.MakeEngine(file_);
  PhysicsEngine engine_turned = turned.MakeEngine(file_);
  engine_straight.Advance(kDt, 4);
  engine_turned.Advance(kDt, 4);
  straight.Rotate(by);
  ExpectSameResults(straight, turned, 10);
}

/// The world's columns as a law would be given them.
std::vector<vesper_property> PropertiesOf(World& world, const vesper_law_desc& law) {
  std::vector<vesper_property> properties;
  for (const auto& use : std::span(law.uses, law.use_count)) {
    AnyColumn& column = world[use.name];
    properties.push_back({sizeof(vesper_property), use.scalar_type, use.name, use.kind,
                          use.components, use.access, column.data(), column.rows(), 0});
  }
  return properties;
}

// F = -dU/dx by central differences, for bodies at rest (friction is then zero).
TEST_P(LawContract, ForcesAreTheGradientOfThePotentialEnergy) {
  if (real_type_ != VESPER_F64) return;  // differences of f32 energies say nothing
  const double h = 1e-5;
  for (const vesper_law_desc* desc : laws_) {
    if (desc->potential_energy == nullptr) continue;
    ASSERT_EQ(laws_.size(), 1u) << "forces of a suite cannot be told apart";
    World world = MakeWorld(7), probe = MakeWorld(7);
    world.Clear("appliedForce");
    world.Clear("velocity");
    PhysicsEngine engine = world.MakeEngine(file_);
    engine.Advance(kDt);
    const BareLaw law(*desc, PropertiesOf(probe, *desc));
    AnyColumn& position = probe["position"];
    const AnyColumn& force = world["externalForce"];
    for (uint64_t i = 0; i < position.size(); ++i) {
      const double x = position.Get(i);
      position.Set(i, x + h);
      const double after = law.PotentialEnergy();
      position.Set(i, x - h);
      const double before = law.PotentialEnergy();
      position.Set(i, x);
      EXPECT_NEAR(force.Get(i), -(after - before) / (2 * h), 1e-6 * (1 + force.Largest()))
          << "row " << i / 3 << ", seed " << kSeed;
    }
  }
}

std::string PrintFile(const ::testing::TestParamInfo<std::string>& info) {
  return LawFile::NameOf(info.param);
}

std::string PrintCase(const ::testing::TestParamInfo<LawContract::ParamType>& info) {
  return LawFile::NameOf(std::get<0>(info.param)) +
         (std::get<1>(info.param) == VESPER_F64 ? "_f64" : "_f32");
}

INSTANTIATE_TEST_SUITE_P(Laws, LawFileContract, ::testing::ValuesIn(LawFiles()), PrintFile);
INSTANTIATE_TEST_SUITE_P(Laws, LawContract,
                         ::testing::Combine(::testing::ValuesIn(LawFiles()),
                                            ::testing::Values(VESPER_F32, VESPER_F64)),
                         PrintCase);

}  // namespace
}  // namespace vesper

int main(int argc, char** argv) {
  std::vector<std::string> folders;
  for (const char* argument : std::span(argv + 1, argv + argc)) {
    if (argument[0] != '-') folders.push_back(argument);
  }
  if (folders.size() > 0) vesper::law_folder = folders[0];
  if (folders.size() > 1) vesper::source_folder = folders[1];
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
