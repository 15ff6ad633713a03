// SPDX-License-Identifier: Apache-2.0
// Tests properties that are functions of position, from the client or from a law library.
#include <functional>
#include <limits>

#include "test_kit.hpp"
#include "vesper/vesper.hpp"

namespace vesper::test {
namespace {

constexpr auto kPrototype =
    "prototype windy extends si-f64\n"
    "world wind: field x3 [m/s] read \"Speed of the air.\"\n"
    "world temperature: field x1 [K] read\n";

/// Computes out = user's factor times (y, z, x).
void Turn(void* user, uint64_t count, const double* at, double* out) {
  const double factor = *static_cast<double*>(user);
  for (uint64_t i = 0; i < count; ++i) {
    for (size_t c = 0; c < 3; ++c) out[3 * i + c] = factor * at[3 * i + (c + 1) % 3];
  }
}

void Cold(void*, uint64_t count, const double* at, double* out) {
  for (uint64_t i = 0; i < count; ++i) out[i] = 300 - 20 * at[3 * i];
}

class FieldTest : public testing::TestWithParam<bool> {
 protected:
  FieldTest()
      : engine(LoadedPrototype(kPrototype, "windy.prototype").get(),
               {.validate = GetParam(), .law_path = VESPER_TEST_LAWS}) {
    auto provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("mass", bodies.mass);
    provider.AddPhysicalProperty("position", bodies.position);
    provider.AddPhysicalProperty("velocity", bodies.velocity);
  }

  vesper_field Wind(double& factor) { return {sizeof(vesper_field), 0, &factor, Turn}; }

  void ExpectRefused(vesper_status status, const std::string& text,
                     const std::function<void()>& call) {
    try {
      call();
      ADD_FAILURE() << "not refused: " << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), status) << error.what();
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  }

  Bodies bodies{4};  // position (i, 2i, 3i), velocity (1, 0, i)
  PhysicsEngine engine;
  double factor = 2;
};
IN_BOTH_MODES(FieldTest);

TEST_P(FieldTest, ClientsFunctionIsWhatTheLawReads) {
  engine.PropertyProvider().SetField("wind", Wind(factor));
  engine.LoadPhysicsLaw("windy");
  engine.Advance(1);
  EXPECT_EQ(bodies.velocity, (std::vector<double>{0, 0, 0, 4, 6, 2, 8, 12, 4, 12, 18, 6}));
}

TEST_P(FieldTest, LawInCppReadsItPlaceByPlace) {
  engine.PropertyProvider().SetField("wind", Wind(factor));
  engine.LoadPhysicsLaw("drifting");
  engine.Advance(1);
  EXPECT_EQ(bodies.velocity[9], 12);
  factor = 0.5;
  engine.PropertyProvider().SetField("temperature", {sizeof(vesper_field), 0, nullptr, Cold});
  engine.Advance(1);
  EXPECT_EQ(bodies.velocity[3], 1) << "at 280 K it blows";
  EXPECT_EQ(bodies.velocity[6], 8) << "at 260 K it does not";
}

TEST_P(FieldTest, ValuesComeInTheUnitThatTheLawDeclares) {
  engine.PropertyProvider().SetField("wind", Wind(factor));
  engine.LoadPhysicsLaw("windy_per_hour");  // writes positions back in that unit too
  engine.Advance(1);
  EXPECT_DOUBLE_EQ(bodies.velocity[9], 12);
}

TEST_P(FieldTest, AnotherFunctionCanTakeItsPlace) {
  engine.PropertyProvider().SetField("wind", Wind(factor));
  engine.LoadPhysicsLaw("windy");
  engine.Advance(1);
  double stronger = 20;
  engine.PropertyProvider().SetField("wind", Wind(stronger));
  engine.Advance(1);
  EXPECT_EQ(bodies.velocity[9], 120);
}

TEST_P(FieldTest, FieldsHaveNoRowsAndNoPlaceInTheHash) {
  const uint64_t before = engine.StateHash();
  auto provider = engine.PropertyProvider();
  provider.SetField("wind", Wind(factor));
  EXPECT_EQ(engine.StateHash(), before);
  const vesper_property found = provider.FindPhysicalProperty("wind");
  EXPECT_EQ(found.row_count, 0u);
  EXPECT_EQ(static_cast<const vesper_field*>(found.data)->user, &factor);
  std::vector<double> gravity(3);
  provider.AddPhysicalProperty("gravity", gravity);  // same kind, which has one row
  engine.Advance(1);
}

TEST_P(FieldTest, MissingFieldIsNamed) {
  engine.LoadPhysicsLaw("windy");
  ExpectRefused(VESPER_NOT_FOUND, "law windy: needs property wind, which is not bound",
                [&] { engine.Advance(1); });
}

TEST_P(FieldTest, ArraysAndFieldsAreNotMixedUp) {
  auto provider = engine.PropertyProvider();
  std::vector<double> wind(3);
  double* data = wind.data();
  ExpectRefused(VESPER_TYPE_MISMATCH, "mass is no field; it has f64 x 1",
                [&] { provider.SetField("mass", Wind(factor)); });
  ExpectRefused(VESPER_INVALID_ARGUMENT, "property wind: field.evaluate is null",
                [&] { provider.SetField("wind", {sizeof(vesper_field), 0, data, nullptr}); });
  ExpectRefused(VESPER_INVALID_ARGUMENT, "field.struct_size is 0",
                [&] { provider.SetField("wind", {0, 0, data, Turn}); });
  EXPECT_EQ(vesper_provider_set_field(nullptr, "wind", nullptr, nullptr), VESPER_INVALID_ARGUMENT);
}

TEST_P(FieldTest, LibraryBringsAFieldAndTakesItAway) {
  const vesper_library_id weather = engine.LoadPhysicsLaw("weather");
  engine.LoadPhysicsLaw("windy");
  engine.Advance(1);
  EXPECT_EQ(bodies.velocity[9], 18) << "3 per second times a height of 6";
  ExpectRefused(VESPER_ALREADY_EXISTS, "field wind comes from library weather",
                [&] { engine.PropertyProvider().SetField("wind", Wind(factor)); });
  engine.UnloadPhysicsLaw(weather);
  ExpectRefused(VESPER_NOT_FOUND, "needs property wind", [&] { engine.Advance(1); });
  engine.PropertyProvider().SetField("wind", Wind(factor));
  engine.Advance(1);
  EXPECT_EQ(bodies.velocity[9], 12);
  ExpectRefused(VESPER_ALREADY_EXISTS, "library weather: field wind is bound already",
                [&] { engine.LoadPhysicsLaw("weather"); });
}

TEST_P(FieldTest, LibraryFailsForAFieldThatIsNotFinite) {
  const vesper_library_id weather = engine.LoadPhysicsLaw("weather_lost");
  engine.LoadPhysicsLaw("drifting");
  try {
    engine.Advance(1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), VESPER_LAW_FAILED);
    EXPECT_EQ(error.library(), weather);
    EXPECT_EQ(error.property(), "wind");
    EXPECT_NE(std::string(error.what()).find("library weather: field wind: found "),
              std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("at (0, 0, 0) m, where law drifting reads it"),
              std::string::npos)
        << error.what();
  }
}

TEST_P(FieldTest, ReaderFailsForAFieldOfTheClientThatIsNotFinite) {
  double lost = std::numeric_limits<double>::quiet_NaN();
  engine.PropertyProvider().SetField("wind", Wind(lost));
  const vesper_library_id drifting = engine.LoadPhysicsLaw("drifting");
  try {
    engine.Advance(1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), VESPER_LAW_MISBEHAVED);
    EXPECT_EQ(error.library(), drifting);
  }
}

TEST_P(FieldTest, CompiledLawRestsWithoutItsFieldAndAnOptionalFieldIsNotNeeded) {
  PhysicsEngine resting(
      LoadedPrototype(kPrototype, "windy.prototype").get(),
      {.validate = GetParam(), .law_path = VESPER_TEST_LAWS, .rest_without_fields = true});
  auto provider = resting.PropertyProvider();
  provider.AddPhysicalProperty("position", bodies.position);
  provider.AddPhysicalProperty("velocity", bodies.velocity);
  const vesper_library_id drifting = resting.LoadPhysicsLaw("drifting");
  EXPECT_EQ(resting.Laws(drifting)[0].resting, 0) << "no step has asked for the field";
  const std::vector<double> before = bodies.velocity;
  resting.Advance(1);
  EXPECT_EQ(bodies.velocity, before);
  EXPECT_EQ(resting.Laws(drifting)[0].resting, 1);
  provider.SetField("wind", Wind(factor));  // without the optional field `temperature`
  resting.Advance(1);
  EXPECT_EQ(bodies.velocity[9], 12);
  EXPECT_EQ(resting.Laws(drifting)[0].resting, 0);
}

TEST_P(FieldTest, LawThatLacksAColumnDoesNotRest) {
  PhysicsEngine resting(
      LoadedPrototype(kPrototype, "windy.prototype").get(),
      {.validate = GetParam(), .law_path = VESPER_TEST_LAWS, .rest_without_fields = true});
  resting.PropertyProvider().SetField("wind", Wind(factor));
  resting.LoadPhysicsLaw("drifting");
  ExpectRefused(VESPER_NOT_FOUND, "law drifting: needs property position",
                [&] { resting.Advance(1); });
}

TEST_P(FieldTest, UndoneChangesBringAFieldBack) {
  const vesper_library_id weather = engine.LoadPhysicsLaw("weather");
  engine.LoadPhysicsLaw("windy");
  engine.BeginChanges();
  engine.UnloadPhysicsLaw(weather);
  engine.EndChanges(false);
  engine.Advance(1);
  EXPECT_EQ(bodies.velocity[9], 18) << "3 per second times a height of 6";
  ExpectRefused(VESPER_ALREADY_EXISTS, "field wind comes from library weather",
                [&] { engine.PropertyProvider().SetField("wind", Wind(factor)); });
}

TEST_P(FieldTest, FieldOfALibraryIsConvertedToThePrototypesUnit) {
  engine.LoadPhysicsLaw("weather_in_km");
  engine.LoadPhysicsLaw("windy");
  engine.Advance(1);
  EXPECT_EQ(bodies.velocity[9], 18000);
}

TEST_P(FieldTest, FieldThatDoesNotFitIsRefused) {
  ExpectRefused(VESPER_TYPE_MISMATCH,
                "library weather: field wind: type is field x 1, expected field x 3",
                [&] { engine.LoadPhysicsLaw("weather_flat"); });
  ExpectRefused(VESPER_UNIT_MISMATCH, "field wind: unit is kg, expected m/s",
                [&] { engine.LoadPhysicsLaw("weather_heavy"); });
  PhysicsEngine plain("si-f64", {.law_path = VESPER_TEST_LAWS});
  ExpectRefused(VESPER_NOT_FOUND, "library weather: prototype si-f64 has no property 'wind'",
                [&] { plain.LoadPhysicsLaw("weather"); });
}

TEST_P(FieldTest, FieldsAreReadOnly) {
  try {
    LoadedPrototype("prototype p extends si-f64\nworld w: field x3 [m] read_write", "p.prototype");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("p.prototype:2:7: property w: a field must be READ"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace vesper::test
