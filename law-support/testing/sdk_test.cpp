// SPDX-License-Identifier: Apache-2.0
// Tests the C++ layers with the real engine: law.hpp in test laws, and vesper.hpp as their client.
#include <type_traits>
#include <utility>

#include "scene.hpp"

namespace vesper {
namespace {

const std::string kSuite = SDK_TEST_FOLDER "libvesper_law_sdk_test_suite.so";
const std::string kDeferred = SDK_TEST_FOLDER "libvesper_law_sdk_test_deferred.so";
const std::string kUnmakable = SDK_TEST_FOLDER "libvesper_law_sdk_unmakable.so";

static_assert(std::is_same_v<decltype(std::declval<Read<float>&>()[0]), const float&>);
static_assert(std::is_same_v<decltype(std::declval<Write<float>&>()[0]), float&>);
static_assert(!std::is_copy_constructible_v<PhysicsEngine>);
static_assert(std::is_nothrow_move_constructible_v<PhysicsEngine>);

/// A scene of 40 bodies with an engine, and the failures of its calls.
class SdkTest : public ::testing::Test {
 protected:
  SdkTest() : engine_(Make()) {
    engine_.PropertyProvider().AddPhysicalProperty("acceleration", acceleration_);
  }

  template <class Action>
  static Error ErrorOf(Action&& action) {
    try {
      action();
    } catch (const Error& error) {
      return error;
    }
    ADD_FAILURE() << "nothing was thrown";
    return Error(vesper_error{});
  }

  Scene<double> scene_;
  std::vector<double> acceleration_ = std::vector<double>(3 * 40);
  std::vector<double> charge_ = std::vector<double>(40, 3);
  std::vector<std::string> log_;
  PhysicsEngine engine_;

 private:
  PhysicsEngine Make() {
    for (int i = 0; i < 40; ++i) scene_.AddBody(1, {static_cast<double>(i), 0, 0});
    const auto log = [this](uint32_t, const char* line) { log_.push_back(line); };
    PhysicsEngine engine("si-f64", {.threads = 2, .validate = true, .log = log});
    engine.PropertyProvider().AddPhysicalProperty("mass", scene_.mass);
    engine.PropertyProvider().AddPhysicalProperty("externalForce", scene_.external_force);
    return engine;
  }
};

TEST_F(SdkTest, SuiteListsItsLawsWithWhatTheyDeclare) {
  const auto laws = engine_.Laws(engine_.LoadPhysicsLaw(kSuite));
  ASSERT_EQ(laws.size(), 2u);
  EXPECT_STREQ(laws[0].name, "pusher");
  EXPECT_STREQ(laws[0].version, "1.2.3");
  EXPECT_EQ(laws[0].phase, VESPER_PHASE_FORCE);
  EXPECT_EQ(laws[0].parameter_count, 3u);
  EXPECT_STREQ(laws[0].parameters[0].name, "push");
  EXPECT_EQ(laws[0].parameters[0].default_value, 2);
  EXPECT_STREQ(laws[0].uses[0].name, "charge");
  EXPECT_EQ(laws[0].uses[0].flags, VESPER_USE_OPTIONAL);
  EXPECT_EQ(laws[0].uses[1].access, VESPER_ACCUMULATE);
  EXPECT_EQ(laws[0].uses[1].components, 3u);
  EXPECT_STREQ(laws[1].name, "reporter");
  EXPECT_EQ(laws[1].uses[1].access, VESPER_WRITE);
}

TEST_F(SdkTest, ParametersHaveTheirDefaultsOrWhatTheClientGives) {
  const auto id = engine_.LoadPhysicsLaw(kSuite);
  engine_.Advance(0.1);
  EXPECT_EQ(scene_.external_force[0], 2);
  engine_.UnloadPhysicsLaw(id);
  engine_.LoadPhysicsLaw(kSuite, {{"push", -7.5}});
  engine_.Advance(0.1);
  EXPECT_EQ(scene_.external_force[0], -7.5);
}

TEST_F(SdkTest, ParameterOutOfRangeIsRefused) {
  const Error error = ErrorOf([&] { engine_.LoadPhysicsLaw(kSuite, {{"pusher.push", 101}}); });
  EXPECT_EQ(error.status(), VESPER_INVALID_ARGUMENT);
  EXPECT_NE(std::string(error.what()).find("push"), std::string::npos) << error.what();
}

TEST_F(SdkTest, OptionalPropertyActsWhenItIsThere) {
  engine_.PropertyProvider().AddPhysicalProperty("charge", charge_);
  engine_.LoadPhysicsLaw(kSuite);
  engine_.Advance(0.1);
  EXPECT_EQ(scene_.external_force[3 * 39], 2 + 0.5 * 3);
}

TEST_F(SdkTest, ObserverSeesTheForceOfTheSameStep) {
  engine_.LoadPhysicsLaw(kSuite);
  engine_.Advance(0.1);
  EXPECT_EQ(acceleration_, scene_.external_force);
}

TEST_F(SdkTest, LawLogsThroughTheEngine) {
  engine_.LoadPhysicsLaw(kSuite);
  log_.clear();
  engine_.Advance(0.25, 3);
  ASSERT_EQ(log_.size(), 1u);
  EXPECT_NE(log_[0].find("second step begins at 0.25"), std::string::npos) << log_[0];
}

TEST_F(SdkTest, LawsOfALibraryShareASuiteForEachEngine) {
  engine_.LoadPhysicsLaw(kSuite);
  std::vector<std::string> log;
  const auto keep = [&log](uint32_t, const char* line) { log.push_back(line); };
  PhysicsEngine other("si-f64", {.log = keep});
  other.PropertyProvider().AddPhysicalProperty("externalForce", scene_.external_force);
  other.PropertyProvider().AddPhysicalProperty("acceleration", acceleration_);
  other.LoadPhysicsLaw(kSuite);
  log_.clear();
  log.clear();
  engine_.Advance(0.25, 2);
  other.Advance(0.25, 2);
  for (const auto& lines : {log_, log}) {
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_NE(lines[0].find("2 laws in the suite"), std::string::npos) << lines[0];
  }
}

TEST(SdkDeferredTest, CopyIsSharedByTheLibraryAndWrittenWhenTheClientAsks) {
  for (const bool deferred : {false, true}) {
    std::vector<double> mass(4, 1), velocity(12, 5), acceleration(12);
    PhysicsEngine engine("si-f64", {.validate = true, .deferred = deferred});
    engine.PropertyProvider().AddPhysicalProperty("mass", mass);
    engine.PropertyProvider().AddPhysicalProperty("velocity", velocity);
    engine.PropertyProvider().AddPhysicalProperty("acceleration", acceleration);
    engine.LoadPhysicsLaw(kDeferred);
    engine.Advance(0.1, 3);
    EXPECT_EQ(acceleration[9], 8);
    EXPECT_EQ(velocity[9], deferred ? 5 : 8);
    engine.Synchronize({"velocity"});
    EXPECT_EQ(velocity, (std::vector<double>{8, 5, 5, 8, 5, 5, 8, 5, 5, 8, 5, 5}));
    velocity[9] = 20;
    engine.PropertyProvider().Touch({"velocity"});
    engine.Advance(0.1);
    engine.Synchronize();
    EXPECT_EQ(velocity, (std::vector<double>{9, 5, 5, 9, 5, 5, 9, 5, 5, 21, 5, 5}));
    EXPECT_EQ(acceleration[9], 21);
  }
}

TEST_F(SdkTest, ExceptionOfJoinRefusesTheLibrary) {
  const Error error = ErrorOf([&] { engine_.LoadPhysicsLaw(kSuite, {{"throwIn", 5.0}}); });
  EXPECT_EQ(error.status(), VESPER_LAW_FAILED);
  EXPECT_NE(std::string(error.what()).find("thrown by Join"), std::string::npos) << error.what();
  engine_.LoadPhysicsLaw(kSuite);  // no state of the failed load remains
}

TEST_F(SdkTest, ExceptionOfALawIsItsFailureWithItsMessage) {
  const std::pair<int, std::string> cases[] = {{1, "thrown by Bind"},
                                               {2, "thrown by Advance"},
                                               {3, "thrown from row 20"},
                                               {4, "no std::exception"}};
  for (const auto& [where, message] : cases) {
    SCOPED_TRACE(message);
    const auto id = engine_.LoadPhysicsLaw(kSuite, {{"throwIn", static_cast<double>(where)}});
    const Error error = ErrorOf([&] { engine_.Advance(0.1); });
    EXPECT_EQ(error.status(), VESPER_LAW_FAILED);
    EXPECT_EQ(error.library(), id);
    EXPECT_EQ(error.law(), "pusher");
    EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    engine_.UnloadPhysicsLaw(id);
  }
  EXPECT_EQ(engine_.StepCount(), 0u);
}

TEST_F(SdkTest, ExceptionOfAConstructorIsAFailedLoad) {
  const Error error = ErrorOf([&] { engine_.LoadPhysicsLaw(kUnmakable); });
  EXPECT_EQ(error.status(), VESPER_LAW_FAILED);
  EXPECT_NE(std::string(error.what()).find("thrown by the constructor"), std::string::npos)
      << error.what();
}

TEST_F(SdkTest, PreparedLibraryIsLoadedByMove) {
  PreparedLibrary prepared({}, kSuite);
  EXPECT_EQ(prepared.name(), "sdk_test_suite");
  const auto id = engine_.LoadPhysicsLaw(std::move(prepared), {{"push", 5}});
  engine_.Advance(0.1);
  EXPECT_EQ(scene_.external_force[0], 5);
  EXPECT_EQ(engine_.Laws(id)[0].calls, 1u);
}

TEST_F(SdkTest, EngineGoesOnWorkingAfterAMove) {
  PhysicsEngine moved = std::move(engine_);
  moved.LoadPhysicsLaw(kSuite);
  moved.PropertyProvider().AddPhysicalProperty("charge", charge_);
  moved.Advance(0.1, 2);
  EXPECT_EQ(moved.StepCount(), 2u);
  EXPECT_EQ(log_.size(), 1u);
}

TEST_F(SdkTest, ArrayOfAnotherTypeIsRefused) {
  std::vector<float> velocity(3 * 40);
  const Error error =
      ErrorOf([&] { engine_.PropertyProvider().AddPhysicalProperty("velocity", velocity); });
  EXPECT_EQ(error.status(), VESPER_TYPE_MISMATCH);
  EXPECT_EQ(error.property(), "velocity");
  EXPECT_STREQ(error.what(), "TYPE_MISMATCH: property 'velocity': array of f32, expected f64");
}

TEST_F(SdkTest, ArrayThatHoldsNoWholeRowsIsRefused) {
  std::vector<double> velocity(3 * 40 + 1);
  const Error error =
      ErrorOf([&] { engine_.PropertyProvider().AddPhysicalProperty("velocity", velocity); });
  EXPECT_EQ(error.status(), VESPER_COUNT_MISMATCH);
  EXPECT_EQ(error.property(), "velocity");
}

TEST_F(SdkTest, SharedValuesAreExpandedToRows) {
  std::vector<double> charge{10, 20};
  std::vector<uint32_t> indices(40, 0);
  indices[5] = 1;
  engine_.PropertyProvider().AddPhysicalProperty("charge", charge, indices);
  engine_.LoadPhysicsLaw(kSuite);
  engine_.Advance(0.1);
  EXPECT_EQ(scene_.external_force[3 * 4], 2 + 0.5 * 10);
  EXPECT_EQ(scene_.external_force[3 * 5], 2 + 0.5 * 20);
}

TEST_F(SdkTest, FoundPropertyIsTheOneThatWasAdded) {
  const vesper_property mass = engine_.PropertyProvider().FindPhysicalProperty("mass");
  EXPECT_EQ(mass.data, scene_.mass.data());
  EXPECT_EQ(mass.row_count, 40u);
  EXPECT_STREQ(mass.kind, "body");
  EXPECT_EQ(ErrorOf([&] { engine_.PropertyProvider().FindPhysicalProperty("masss"); }).status(),
            VESPER_NOT_FOUND);
}

TEST(StandardPrototypeTest, UnknownNameIsRefused) {
  EXPECT_THROW(StandardPrototype("si-f16"), Error);
}

}  // namespace
}  // namespace vesper
