// SPDX-License-Identifier: Apache-2.0
// Fields in laws as text: functions of position that a text reads or provides.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "text_engine.hpp"
#include "vesper/vesper.hpp"

namespace vesper::test {
namespace {

std::string AirPrototype(const std::string& base) {
  return "prototype air extends " + base +
         "\n"
         "world wind: field x3 [km/h] read\n"
         "world warmth: field x1 [K] read\n"
         "world depth: field x1 [J] read\n"
         "body temperature: real x1 [K] read_write\n"
         "body heating: real x1 [W] accumulate\n";
}

constexpr const char* kWeather =
    "law weather \"Wind and warmth.\"\n"
    "  parameter shear = 2 1/s\n"
    "  let top = 40 m\n"
    "  field wind at place = (shear place.y, 0, 1 m/s if place.x > 1 m else 0)\n"
    "  field warmth at here = 280 K + 20 K (here.y / top)^2 \"Warmth of the air.\"\n";

constexpr const char* kDrift =
    "law drift\n"
    "  each body:\n"
    "    velocity = wind\n"
    "    temperature = warmth\n";

PreparedLibrary Prepared(const std::string& text) {
  vesper_prepared_library* prepared = nullptr;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_library_prepare_text("x.law", text.data(), text.size(), &prepared, error);
  }));
  return PreparedLibrary(prepared);
}

/// Bodies at (i, 2i, 3i), in either precision.
template <class Real>
class Air {
 public:
  explicit Air(size_t count, uint32_t threads = 1, bool rest = false)
      : mass(count, 1),
        position(3 * count),
        velocity(3 * count),
        temperature(count),
        heating(count),
        force(3 * count),
        prototype_(AirPrototype(std::is_same_v<Real, float> ? "si-f32" : "si-f64").c_str(),
                   "air.prototype"),
        engine(prototype_.get(), {.threads = threads,
                                  .law_path = VESPER_TEST_LAWS,
                                  .rest_without_fields = rest,
                                  .log = [this](uint32_t level, const char* line) {
                                    if (level >= VESPER_LOG_WARNING) warnings.push_back(line);
                                  }}) {
    for (size_t i = 0; i < count; ++i) {
      for (size_t axis = 0; axis < 3; ++axis) {
        position[3 * i + axis] = static_cast<Real>((axis + 1) * i);
      }
    }
    auto provider = engine.PropertyProvider();
    provider.AddPhysicalProperty("mass", mass);
    provider.AddPhysicalProperty("position", position);
    provider.AddPhysicalProperty("velocity", velocity);
    provider.AddPhysicalProperty("temperature", temperature);
    provider.AddPhysicalProperty("heating", heating);
    provider.AddPhysicalProperty("externalForce", force);
  }

  vesper_library_id Load(const std::string& text, std::vector<ParameterValue> parameters = {}) {
    return engine.LoadPhysicsLaw(Prepared(text), parameters);
  }

  /// Returns the message with which the engine refuses a text.
  std::string Refusal(const std::string& text) {
    try {
      Load(text);
    } catch (const Error& error) {
      return error.what();
    }
    ADD_FAILURE() << "not refused: " << text;
    return {};
  }

  /// Returns the failure of a step.
  Error Failure() {
    try {
      engine.Advance(1);
    } catch (const Error& error) {
      return error;
    }
    ADD_FAILURE() << "no law failed";
    return Error(vesper_error{});
  }

  std::vector<Real> mass, position, velocity, temperature, heating, force;
  std::vector<std::string> warnings;  // lines of the log

 private:
  LoadedPrototype prototype_;

 public:
  PhysicsEngine engine;
};

template <class Real>
class TextFieldsTest : public testing::Test {};
using Precisions = testing::Types<double, float>;
TYPED_TEST_SUITE(TextFieldsTest, Precisions);

TYPED_TEST(TextFieldsTest, TextReadsWhatAnotherTextProvides) {
  Air<TypeParam> air(3);
  air.Load(kWeather);
  air.Load(kDrift);
  air.engine.Advance(0.1);
  EXPECT_EQ(air.velocity, (std::vector<TypeParam>{0, 0, 0, 4, 0, 0, 8, 0, 1}));
  for (size_t i = 0; i < 3; ++i) {
    const double y = 2.0 * static_cast<double>(i);
    EXPECT_NEAR(air.temperature[i], 280 + 20 * y * y / 1600, 2e-5) << i;
  }
}

TYPED_TEST(TextFieldsTest, ParametersOfTheProviderCount) {
  Air<TypeParam> air(2);
  air.Load(kDrift);
  air.Load(kWeather, {{"shear", 5}});
  air.engine.Advance(0.1);
  EXPECT_EQ(air.velocity[3], 10);
}

TYPED_TEST(TextFieldsTest, EachBlockReadsTheFieldAtThePresentPositions) {
  Air<TypeParam> air(2);
  air.Load(kWeather);
  air.Load(
      "law move\n"
      "  each body: position.y += 1 m\n"
      "  each body: velocity = wind\n");
  air.engine.Advance(0.1);
  EXPECT_EQ(air.velocity[0], 2);
  EXPECT_EQ(air.velocity[3], 6);
  air.engine.Advance(0.1);
  EXPECT_EQ(air.velocity[0], 4);
}

TYPED_TEST(TextFieldsTest, PairsReadTheFieldAtBothBodies) {
  Air<TypeParam> air(2);
  air.Load(kWeather);
  air.Load(
      "law conduction\n"
      "  each pair a and b of bodies:\n"
      "    let flow = 1 W/K (a.warmth - b.warmth)\n"
      "    a.heating -= flow; b.heating += flow\n");
  air.engine.Advance(0.1);
  EXPECT_NEAR(air.heating[0], 20.0 * 4 / 1600, 2e-5);
  EXPECT_EQ(air.heating[1], -air.heating[0]);
}

TEST(TextFieldTest, TextsOfThePageAreRight) {
  std::ifstream file(VESPER_ROOT "/docs/laws-as-text.md");
  std::ostringstream content;
  content << file.rdbuf();
  const std::string page = content.str();
  Air<double> air(2);
  size_t loaded = 0;
  for (size_t at = 0; (at = page.find("\n```law\n", at)) != std::string::npos; ++loaded) {
    const size_t begin = at + 8;
    at = page.find("\n```", begin);
    air.Load(page.substr(begin, at + 1 - begin));
  }
  ASSERT_EQ(loaded, 3u);
  air.velocity[3] = 4;
  air.engine.Advance(1);
  EXPECT_EQ(air.force[3], 2 * (0.5 * 2 - 4) - 3) << "at (1, 2, 3) m";
}

TEST(TextFieldTest, ResultsDoNotDependOnThreads) {
  const size_t count = 20000;
  Air<double> one(count), many(count, 4);
  for (Air<double>* air : {&one, &many}) {
    air->Load(kWeather);
    air->Load(kDrift);
    air->engine.Advance(0.1);
  }
  EXPECT_EQ(one.velocity, many.velocity);
  EXPECT_EQ(one.temperature, many.temperature);
  EXPECT_EQ(one.velocity[3 * 19999], 2 * 2 * 19999);
}

TEST(TextFieldTest, CompiledLawReadsTheFieldOfAText) {
  Air<double> air(2);
  air.Load(kWeather);
  air.engine.LoadPhysicsLaw("windy_per_hour");  // writes positions back in m/h
  air.engine.Advance(1);
  EXPECT_NEAR(air.velocity[3], 4, 1e-12);
}

TEST(TextFieldTest, TextReadsTheFieldOfACompiledLibrary) {
  Air<double> air(2);
  air.Load("law drift\n  each body: velocity = wind\n");
  air.engine.LoadPhysicsLaw("weather");
  air.engine.Advance(1);
  EXPECT_DOUBLE_EQ(air.velocity[3], 6) << "3 per second times the height";
}

TEST(TextFieldTest, FieldOfAClientIsReadInTheUnitOfTheText) {
  Air<double> air(2);
  const auto blow = [](void*, uint64_t count, const double* at, double* out) {
    for (uint64_t i = 0; i < 3 * count; ++i) out[i] = 36 * at[i];  // [km/h]
  };
  air.engine.PropertyProvider().SetField("wind", {sizeof(vesper_field), 0, nullptr, blow});
  air.Load("law drift\n  each body: velocity = wind\n");
  air.engine.Advance(1);
  EXPECT_DOUBLE_EQ(air.velocity[5], 30);
}

TEST(TextFieldTest, LawWithAFieldOnlyActsOnNothingAndGoesWithItsField) {
  Air<double> air(2);
  const vesper_library_id weather = air.Load(kWeather);
  air.engine.Advance(1);
  EXPECT_EQ(air.velocity[3], 0);
  air.Load(kDrift);
  air.engine.Advance(1);
  EXPECT_EQ(air.velocity[3], 4);
  air.engine.UnloadPhysicsLaw(weather);
  EXPECT_THROW(air.engine.Advance(1), Error);
}

constexpr const char* kHole = "law hole\n  field wind at r = 1 m^2/s/|r| * (1, 0, 0)\n";

TYPED_TEST(TextFieldsTest, ValueThatIsNotFiniteFailsTheProvider) {
  Air<TypeParam> air(3, 1, true);
  air.Load("law drift\n  each body: velocity = wind\n");
  const vesper_library_id hole = air.Load(kHole);
  const Error error = air.Failure();
  EXPECT_EQ(error.status(), VESPER_LAW_FAILED);
  EXPECT_EQ(error.library(), hole);
  EXPECT_EQ(error.law(), "hole");
  EXPECT_EQ(error.property(), "wind");
  EXPECT_NE(std::string(error.what())
                .find("x.law:2:21: field wind: '1 m^2/s/|r|' divides by zero "
                      "at (0, 0, 0) m, where law drift reads it"),
            std::string::npos)
      << error.what();
  air.velocity.assign(9, 5);
  air.engine.UnloadPhysicsLaw(hole);
  air.engine.Advance(1);
  EXPECT_EQ(air.velocity, std::vector<TypeParam>(9, 5)) << "the reader rests";
  air.Load(kWeather);
  air.engine.Advance(1);
  EXPECT_EQ(air.velocity[6], 8) << "the reader acts again";
}

TYPED_TEST(TextFieldsTest, ProviderFailsThoughTheReaderChecksLimitsOrSumsPairs) {
  for (const char* reader : {"law reader\n  each body has heat in m/s, from 0\n"
                             "  each body: heat = wind.x\n",
                             "law reader\n  each pair a and b of bodies within 9 m:\n"
                             "    let f = 1 kg/s (a.wind - b.wind)\n"
                             "    a.force += f; b.force -= f\n",
                             "law reader\n  each pair a and b of bodies:\n"
                             "    a.heating += 1 N * a.wind.x; b.heating += 1 N * b.wind.x\n"}) {
    Air<TypeParam> air(3);
    air.Load(reader);
    const vesper_library_id hole = air.Load(kHole);
    const Error error = air.Failure();
    EXPECT_EQ(error.library(), hole) << reader << error.what();
    EXPECT_NE(std::string(error.what()).find("where law reader reads it"), std::string::npos)
        << reader << error.what();
  }
}

TYPED_TEST(TextFieldsTest, ValueThatTheReaderDoesNotUseFailsNoLaw) {
  Air<TypeParam> air(3);
  air.Load(kHole);
  air.Load("law drift\n  each body:\n    if mass > 2 kg: velocity = wind\n");
  air.engine.Advance(1);
  EXPECT_EQ(air.velocity, std::vector<TypeParam>(9, 0));
}

TYPED_TEST(TextFieldsTest, ReaderThatFailsByItselfIsTheCause) {
  Air<TypeParam> air(3);
  air.Load(kWeather);
  const vesper_library_id drift =
      air.Load("law drift\n  each body: velocity = wind * (1 kg / (mass - 1 kg))\n");
  const Error error = air.Failure();
  EXPECT_EQ(error.library(), drift);
  EXPECT_NE(std::string(error.what()).find("divides by zero"), std::string::npos) << error.what();
}

TEST(TextFieldTest, ValueThatIsTooLargeForThePrecisionFailsTheProvider) {
  Air<float> air(2);
  const vesper_library_id gale = air.Load("law gale\n  field wind at r = 1e39 1/s * r\n");
  air.Load("law drift\n  each body: velocity = wind\n");
  const Error error = air.Failure();
  EXPECT_EQ(error.library(), gale);
  EXPECT_NE(std::string(error.what()).find("is too large at (1, 2, 3) m"), std::string::npos)
      << error.what();
}

TEST(TextFieldTest, MessageDoesNotDependOnThreads) {
  std::vector<std::string> messages;
  for (const uint32_t threads : {1u, 4u}) {
    Air<double> air(20000, threads);
    air.Load("law wall\n  field wind at r = 1 m^2/s/max(0 m, 15000.5 m - r.x) * (0, 1, 0)\n");
    air.Load("law drift\n  each body: velocity = wind\n");
    messages.push_back(air.Failure().what());
  }
  EXPECT_EQ(messages[0], messages[1]);
  EXPECT_NE(messages[0].find("at (15001, 30002, 45003) m"), std::string::npos) << messages[0];
}

TYPED_TEST(TextFieldsTest, LawWithoutItsFieldRestsAndAddsNothing) {
  Air<TypeParam> air(2, 1, true);
  const vesper_library_id weather = air.Load(kWeather);
  air.Load("law sail\n  each body: force += 1 kg/s wind\n");
  air.Load("law push\n  each body: force += (0, 3, 0) N\n");
  air.engine.Advance(1);
  EXPECT_EQ(air.force, (std::vector<TypeParam>{0, 3, 0, 4, 3, 0}));
  air.engine.UnloadPhysicsLaw(weather);
  air.engine.Advance(1, 2);
  EXPECT_EQ(air.force, (std::vector<TypeParam>{0, 3, 0, 0, 3, 0}));
  ASSERT_EQ(air.warnings.size(), 1u) << "one line, not one in each step";
  EXPECT_EQ(air.warnings[0],
            "law sail rests, because no law provides the field wind; load a law that provides it");
  air.Load(kWeather);
  air.engine.Advance(1);
  EXPECT_EQ(air.force, (std::vector<TypeParam>{0, 3, 0, 4, 3, 0}));
}

TYPED_TEST(TextFieldsTest, FieldDependsOnTheTimeAtTheStartOfTheStep) {
  Air<TypeParam> air(2);
  air.Load("law thermometer\n  each body: temperature = warmth\n");
  air.Load("law tide\n  field warmth at r = 1 K/s * time + 1 K/m * r.y\n");
  for (int step = 0; step < 4; ++step) {
    air.engine.Advance(0.5);
    EXPECT_EQ(air.temperature[1], 2 + 0.5 * step);
  }
  air.engine.Advance(0.5, 3);
  EXPECT_EQ(air.temperature[1], 2 + 0.5 * 6);
  air.engine.SetStepCount(100, 0.25);
  air.engine.Advance(0.25);
  EXPECT_EQ(air.temperature[1], 2 + 25);
}

TYPED_TEST(TextFieldsTest, MessageNamesTheTimeDependentPart) {
  Air<TypeParam> air(2);
  air.Load("law thermometer\n  each body: temperature = warmth\n");
  air.Load("law tide\n  field warmth at r = 1 K * 1 s / (1 s - time)\n");
  air.engine.Advance(1);
  EXPECT_NE(std::string(air.Failure().what()).find("/ (1 s - time)' divides by zero"),
            std::string::npos);
}

TYPED_TEST(TextFieldsTest, EnergyOfAFieldGivesTheForceOfItsSlope) {
  Air<TypeParam> air(2);
  air.Load("law well\n  field warmth at r = 280 K + 1 K/m^2 * |r|^2\n");
  const vesper_library_id trap = air.Load("law trap\n  each body: energy = 2 J/K warmth\n");
  air.engine.Advance(1);
  EXPECT_EQ(air.force, (std::vector<TypeParam>{0, 0, 0, -4, -8, -12}));
  EXPECT_NEAR(air.engine.PotentialEnergy(trap), 2 * 280 + 2 * (280 + 14), 1e-9);
}

TYPED_TEST(TextFieldsTest, EnergyReadsValueAndSlopeOfAVector) {
  Air<TypeParam> air(2);
  air.Load("law shear\n  field wind at r = (2 1/s * r.y, 1 m/s, 0)\n");
  air.Load("law x\n  each body: energy = 1 kg/s position · wind\n");
  air.engine.Advance(1);
  EXPECT_NEAR(air.force[3], -2 * 2, 1e-5);
  EXPECT_NEAR(air.force[4], -2 * 1 - 1, 1e-5);
  EXPECT_NEAR(air.force[5], 0, 1e-5);
}

constexpr const char* kHills =
    "law hills\n"
    "  field warmth at r = 280 K + 5 K * sin(r.x / 1 m) * exp(-(r.y / 3 m)^2)"
    " + (1 K/m^2 * r.z^2 if r.z > 4 m else 4 K/m * r.z)\n";

TEST(TextFieldTest, ForcesAreTheSlopeOfThePotentialEnergy) {
  for (const char* text :
       {"law x\n  each body: energy = 2 J/K^2 * (warmth - 270 K)^2 / (1 + position.x / 9 m)\n",
        "law x\n  each pair a and b of bodies:\n"
        "    energy = 1 J/K * (a.warmth - b.warmth) * exp(-|a.position - b.position| / 9 m)\n",
        "law x\n  each pair a and b of bodies within 5 m, r apart, energy shifted:\n"
        "    energy = 0.1 J/K * a.warmth / (r / 1 m)\n"}) {
    Air<double> air(3);
    air.Load(kHills);
    const vesper_library_id x = air.Load(text);
    air.engine.Advance(1);
    const std::vector<double> force = air.force;
    for (size_t i = 0; i < force.size(); ++i) {
      const double place = air.position[i], h = 1e-5;
      air.position[i] = place + h;
      const double after = air.engine.PotentialEnergy(x);
      air.position[i] = place - h;
      const double before = air.engine.PotentialEnergy(x);
      air.position[i] = place;
      EXPECT_NEAR(force[i], (before - after) / (2 * h), 2e-6 * (1 + std::abs(force[i])))
          << text << i;
    }
    EXPECT_NE(force, std::vector<double>(9, 0)) << text;
  }
}

TEST(TextFieldTest, SlopeThatIsNotFiniteFailsTheProvider) {
  Air<double> air(2);
  const vesper_library_id edge =
      air.Load("law edge\n  field warmth at r = 9 K * asin(r.x / 1 m)\n");
  air.Load("law x\n  each body: energy = 1 J/K warmth\n");
  const Error error = air.Failure();
  EXPECT_EQ(error.library(), edge);
  EXPECT_NE(std::string(error.what()).find("x.law:2:"), std::string::npos) << error.what();
  EXPECT_NE(std::string(error.what()).find(": slope of field warmth: "), std::string::npos)
      << error.what();
}

TEST(TextFieldTest, EnergyNeedsAProviderThatKnowsTheSlope) {
  constexpr const char* kEnergy = "law x\n  each body: energy = 1 kg/s position · wind\n";
  constexpr const char* kNeeds = "law x needs the slope of field wind, which ";
  Air<double> air(2);
  const vesper_library_id weather = air.engine.LoadPhysicsLaw("weather");
  EXPECT_NE(air.Refusal(kEnergy).find(kNeeds + std::string("library weather does not provide; "
                                                           "provide the field by a law as text")),
            std::string::npos);
  air.engine.UnloadPhysicsLaw(weather);
  const auto blow = [](void*, uint64_t count, const double*, double* out) {
    std::fill_n(out, 3 * count, 1.0);
  };
  const vesper_field of_client{sizeof(vesper_field), 0, nullptr, blow};
  air.engine.PropertyProvider().SetField("wind", of_client);
  EXPECT_NE(air.Refusal(kEnergy).find(kNeeds + std::string("the client")), std::string::npos);
  air.engine.PropertyProvider().RemovePhysicalProperty("wind");
  const vesper_library_id x = air.Load(kEnergy);
  const auto refused = [&](auto&& provide) {
    try {
      provide();
      ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), VESPER_ACCESS_CONFLICT);
      EXPECT_NE(std::string(error.what()).find(kNeeds), std::string::npos) << error.what();
    }
  };
  refused([&] { air.engine.LoadPhysicsLaw("weather"); });
  refused([&] { air.engine.PropertyProvider().SetField("wind", of_client); });
  air.Load("law shear\n  field wind at r = (2 1/s * r.y, 0, 0)\n");
  air.engine.Advance(1);
  EXPECT_NEAR(air.force[3], -4, 1e-12);
  EXPECT_EQ(ClaimsOf("law x\n  each body: energy = 1 m forceField · (1, 0, 0)\n") &
                (VESPER_CLAIM_ENERGY | VESPER_CLAIM_TRANSLATION | VESPER_CLAIM_MOMENTUM),
            0u);
  air.engine.UnloadPhysicsLaw(x);
}

TEST(TextFieldTest, LawThatRestsHasNoPotentialEnergy) {
  Air<double> air(2, 1, true);
  const vesper_library_id x = air.Load("law x\n  each body: energy = 1 J/K warmth\n");
  air.engine.Advance(1);
  EXPECT_EQ(air.engine.PotentialEnergy(x), 0);
  air.Load(kHills);
  EXPECT_GT(air.engine.PotentialEnergy(x), 500);
}

TEST(TextFieldTest, WrongTextsAreRefused) {
  Air<double> air(1);
  const std::array<std::pair<const char*, const char*>, 11> cases{{
      {"law x\n  field rain at r = 1 m/s\n", "x.law:2:9: this world declares no field 'rain'"},
      {"law x\n  field wind at r = 1 m/s\n",
       "x.law:2:21: '1 m/s' is a number, but the field 'wind'"},
      {"law x\n  field warmth at r = 1 m\n", "'1 m' is m (a length), but 'warmth' is K"},
      {"law x\n  field warmth at r = 1 K/s dt\n", "but this one depends on 'dt'"},
      {"law x\n  field warmth at r = 1 K/m |gravity|\n", "'1 K/m |gravity|'"},
      {"law x\n  field warmth at r = 1 K\n  field warmth at r = 1 K\n",
       "provides 'warmth' already"},
      {"law x\n  each spring: hookeConstant += 1 N/m/K warmth\n", "springs have no position"},
      {"law x\n  each pair of bodies, r apart: attraction = 1 N/K warmth\n",
       "this part of the law has no rows with a position"},
      {"law x\n  each body: warmth = 3 K\n", "laws only read it"},
      {"law x\n  each pair a and b of bodies: a.warmth += 3 K\n", "laws only read it"},
      {"law x\n  each body:\n    position.y += 1 m\n    temperature = warmth\n",
       "this block has set the position"},
  }};
  for (const auto& [text, message] : cases) {
    const std::string refusal = air.Refusal(text);
    EXPECT_NE(refusal.find(message), std::string::npos) << text << refusal;
  }
}

TEST(TextFieldTest, LawsWithFieldsClaimNoSymmetry) {
  const uint32_t claims = ClaimsOf("law x\n  each body: force += forceField\n");
  EXPECT_EQ(claims & (VESPER_CLAIM_TRANSLATION | VESPER_CLAIM_ROTATION | VESPER_CLAIM_MOMENTUM),
            0u);
}

}  // namespace
}  // namespace vesper::test
