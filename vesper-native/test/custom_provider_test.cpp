// SPDX-License-Identifier: Apache-2.0
// Tests a property provider of the client, through the C++ layer.
#include <cstring>
#include <functional>
#include <map>
#include <stdexcept>

#include "test_kit.hpp"
#include "vesper/vesper.hpp"

namespace vesper::test {
namespace {

/// A store of columns by name, as a client's own store.
class Store : public CustomPropertyProvider {
 public:
  struct Entry {
    std::vector<double>* values;
    uint64_t components;
    uint64_t version = 0;
    std::vector<uint32_t> indices = {};
  };

  std::optional<vesper_provided_property> FindPhysicalProperty(std::string_view name) override {
    ++asked;
    if (name == failing) throw std::runtime_error("the disk is on fire");
    const auto found = entries.find(name);
    if (found == entries.end()) return std::nullopt;
    Entry& entry = found->second;
    vesper_provided_property property{};
    property.data = entry.values->data();
    property.value_count = entry.values->size() / entry.components;
    property.object_count = property.value_count;
    if (!entry.indices.empty()) {
      property.indices = entry.indices.data();
      property.object_count = entry.indices.size();
    }
    property.version = entry.version;
    return property;
  }
  uint64_t Version() const noexcept override { return version; }

  void Lend(Bodies& bodies) {
    entries = {{"mass", {&bodies.mass, 1}},           {"position", {&bodies.position, 3}},
               {"velocity", {&bodies.velocity, 3}},   {"acceleration", {&bodies.acceleration, 3}},
               {"externalForce", {&bodies.force, 3}}, {"orientation", {&bodies.orientation, 4}}};
    ++version;
  }

  std::map<std::string, Entry, std::less<>> entries;
  std::string failing;
  uint64_t version = 0;
  uint64_t asked = 0;
};

class CustomProviderTest : public testing::TestWithParam<bool> {
 protected:
  CustomProviderTest()
      : engine("si-f64", {.validate = GetParam(),
                          .law_path = VESPER_TEST_LAWS,
                          .log = [this](uint32_t, const char* line) { log.push_back(line); }}) {
    store.Lend(bodies);
    engine.SetPropertyProvider(&store);
  }

  vesper_status StatusOf(const std::function<void()>& call) {
    try {
      call();
      return VESPER_OK;
    } catch (const Error& error) {
      message = error.what();
      return error.status();
    }
  }

  Bodies bodies{3};
  Store store;
  std::vector<std::string> log;
  PhysicsEngine engine;
  std::string message;
};
IN_BOTH_MODES(CustomProviderTest);

TEST_P(CustomProviderTest, GivesTheSameBitsAsRegisteredArrays) {
  Bodies registered(3);
  TestEngine other({.validate = GetParam()});
  other.AddBodies(registered);
  other.Load("push");
  other.Load("euler");
  EXPECT_OK(other.Advance(0.1, 50));
  engine.LoadPhysicsLaw("push");
  engine.LoadPhysicsLaw("euler");
  engine.Advance(0.1, 50);
  EXPECT_EQ(bodies.position, registered.position);
  EXPECT_EQ(engine.StateHash(), other.StateHash());
}

TEST_P(CustomProviderTest, IsAskedOnceForEachPropertyUntilItsVersionChanges) {
  EXPECT_EQ(store.asked, 0u);
  engine.Advance(1);
  const uint64_t properties = vesper_prototype_standard("si-f64")->property_count;
  EXPECT_EQ(store.asked, properties);
  engine.Advance(1, 7);
  engine.StateHash();
  EXPECT_EQ(store.asked, properties);
  ++store.version;
  engine.Advance(1);
  EXPECT_EQ(store.asked, 2 * properties);
}

TEST_P(CustomProviderTest, ArraysThatGrewAreBoundAgain) {
  engine.LoadPhysicsLaw("euler");
  engine.Advance(1);
  Bodies more(40);
  store.Lend(more);
  engine.Advance(1);
  EXPECT_EQ(more.position[3 * 39], 40);
  EXPECT_EQ(bodies.position[0], 1) << "one step only";
  EXPECT_EQ(engine.PropertyProvider().FindPhysicalProperty("mass").row_count, 40u);
}

TEST_P(CustomProviderTest, VersionOfAPropertySaysThatValuesWereEdited) {
  std::vector<double> endpoints, hooke{5, 6};
  uint32_t ends[] = {0, 1, 1, 2};
  endpoints.resize(2);  // two rows of two u32
  std::memcpy(endpoints.data(), ends, sizeof ends);
  store.entries["endpoints"] = {&endpoints, 1};
  store.entries["hookeConstant"] = {&hooke, 1};
  ++store.version;
  engine.LoadPhysicsLaw("springs");
  engine.Advance(1);
  engine.Advance(1);
  EXPECT_EQ(log.size(), 1u);
  store.entries["endpoints"].version = 9;
  ++store.version;
  engine.Advance(1);
  EXPECT_EQ(log.size(), 2u) << "the law may cache, so it is bound again";
  ends[3] = 3;
  std::memcpy(endpoints.data(), ends, sizeof ends);
  store.entries["endpoints"].version = 10;
  ++store.version;
  EXPECT_EQ(StatusOf([&] { engine.Advance(1); }), VESPER_INVALID_ARGUMENT);
  EXPECT_NE(message.find("endpoints: row 1 refers to row 3 of kind body, which has 3"),
            std::string::npos)
      << message;
}

TEST_P(CustomProviderTest, SharedValuesAreExpanded) {
  std::vector<double> kinds{2, 4};
  store.entries["mass"] = {&kinds, 1, 0, {1, 0, 1}};
  ++store.version;
  engine.LoadPhysicsLaw("push");
  engine.LoadPhysicsLaw("euler");
  engine.Advance(1);
  EXPECT_EQ(bodies.velocity[0], 1 + 0.25);
  EXPECT_EQ(bodies.velocity[3], 1 + 0.5);
}

TEST_P(CustomProviderTest, ValuesThatALawWritesCannotBecomeShared) {
  engine.LoadPhysicsLaw("euler");
  engine.Advance(1);
  store.entries["position"].indices = {0, 0, 0};
  ++store.version;
  EXPECT_EQ(StatusOf([&] { engine.Advance(1); }), VESPER_ACCESS_CONFLICT);
  store.entries["position"].indices = {};
  EXPECT_EQ(StatusOf([&] { engine.Advance(1); }), VESPER_OK) << message;
}

TEST_P(CustomProviderTest, PropertyThatIsGoneIsMissedByTheLawThatNeedsIt) {
  engine.LoadPhysicsLaw("euler");
  engine.Advance(1);
  store.entries.erase("mass");
  ++store.version;
  EXPECT_EQ(StatusOf([&] { engine.Advance(1); }), VESPER_NOT_FOUND);
  EXPECT_NE(message.find("law euler: needs property mass"), std::string::npos) << message;
}

TEST_P(CustomProviderTest, WrongAnswersNameThePropertyAndChangeNothing) {
  engine.Advance(1);
  store.failing = "charge";
  ++store.version;
  EXPECT_EQ(StatusOf([&] { engine.Advance(1); }), VESPER_INVALID_ARGUMENT);
  EXPECT_NE(message.find("property charge: the client's provider answers INVALID_ARGUMENT: the "
                         "disk is on fire"),
            std::string::npos)
      << message;
  store.failing.clear();
  std::vector<double> few(2);
  store.entries["mass"].values = &few;
  EXPECT_EQ(StatusOf([&] { engine.Advance(1); }), VESPER_COUNT_MISMATCH);
  store.Lend(bodies);
  engine.Advance(1);
  EXPECT_EQ(engine.StepCount(), 2u);
}

TEST_P(CustomProviderTest, ArraysAreEitherRegisteredOrProvided) {
  std::vector<double> charge(3);
  auto provider = engine.PropertyProvider();
  EXPECT_EQ(StatusOf([&] { provider.AddPhysicalProperty("charge", charge); }),
            VESPER_ACCESS_CONFLICT);
  EXPECT_EQ(StatusOf([&] { provider.RemovePhysicalProperty("mass"); }), VESPER_ACCESS_CONFLICT);
  engine.SetPropertyProvider(nullptr);
  EXPECT_EQ(StatusOf([&] { provider.FindPhysicalProperty("mass"); }), VESPER_NOT_FOUND);
  provider.AddPhysicalProperty("charge", charge);
  EXPECT_EQ(StatusOf([&] { engine.SetPropertyProvider(&store); }), VESPER_ALREADY_EXISTS);
  EXPECT_NE(message.find("property charge is bound already"), std::string::npos) << message;
  provider.RemovePhysicalProperty("charge");
  engine.SetPropertyProvider(&store);
  EXPECT_EQ(provider.FindPhysicalProperty("mass").data, bodies.mass.data());
}

TEST(CustomProviderCallbacksTest, BothAreNeeded) {
  TestEngine engine;
  vesper_provider_callbacks callbacks{};
  const auto set = [&] {
    return Try([&](vesper_error* error) {
      return vesper_engine_set_property_provider(engine.get(), &callbacks, error);
    });
  };
  EXPECT_REFUSED(INVALID_ARGUMENT, "callbacks.struct_size is 0", set());
  callbacks.struct_size = sizeof callbacks;
  EXPECT_REFUSED(INVALID_ARGUMENT, "callbacks.find is null", set());
  callbacks.find = [](void*, const char*, vesper_provided_property*, vesper_error*) {
    return vesper_status{VESPER_NOT_FOUND};
  };
  EXPECT_REFUSED(INVALID_ARGUMENT, "callbacks.version is null", set());
  EXPECT_EQ(vesper_engine_set_property_provider(nullptr, nullptr, nullptr),
            VESPER_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace vesper::test
