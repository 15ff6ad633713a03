// SPDX-License-Identifier: Apache-2.0
// Tests prototypes: the standard ones, and refused ones.
#include <cmath>
#include <functional>
#include <map>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

TEST(PrototypeTest, StandardPrototypesDifferInPrecisionOnly) {
  const vesper_prototype* f64 = vesper_prototype_standard("si-f64");
  const vesper_prototype* f32 = vesper_prototype_standard("si-f32");
  ASSERT_NE(f64, nullptr);
  ASSERT_NE(f32, nullptr);
  EXPECT_EQ(vesper_prototype_standard("si-f16"), nullptr);
  EXPECT_EQ(vesper_prototype_standard(nullptr), nullptr);
  EXPECT_EQ(f64->real_type, VESPER_F64);
  EXPECT_EQ(f32->real_type, VESPER_F32);
  ASSERT_EQ(f64->property_count, f32->property_count);
  for (uint32_t i = 0; i < f64->property_count; ++i) {
    const auto& a = f64->properties[i];
    const auto& b = f32->properties[i];
    EXPECT_STREQ(a.name, b.name);
    EXPECT_EQ(a.components, b.components) << a.name;
    EXPECT_EQ(a.law_access, b.law_access) << a.name;
    EXPECT_EQ(a.has_minimum, b.has_minimum) << a.name;
    EXPECT_EQ(a.minimum, 0) << a.name;
    if (a.scalar_type == VESPER_U32) {
      EXPECT_EQ(b.scalar_type, VESPER_U32) << a.name;
      EXPECT_STREQ(a.refers_to, std::string(a.name) == "geared" ? "joint" : "body") << a.name;
    } else if (a.scalar_type == VESPER_FIELD || a.scalar_type == VESPER_I32 ||
               std::string(a.name).ends_with("ize") ||
               std::string(a.name) == "meshPoints") {  // shapes are doubles in both
      EXPECT_EQ(b.scalar_type, a.scalar_type) << a.name;
    } else {
      EXPECT_EQ(a.scalar_type, VESPER_F64) << a.name;
      EXPECT_EQ(b.scalar_type, VESPER_F32) << a.name;
    }
  }
}

TEST(PrototypeTest, StandardPropertiesAreThoseOfTheContract) {
  struct Row {
    const char* kind;
    uint32_t components;
    const char* unit;
    vesper_access access;
  };
  constexpr vesper_access kSum = VESPER_READ | VESPER_ACCUMULATE;
  const std::map<std::string, Row> expected = {
      {"mass", {"body", 1, "kg", VESPER_READ}},
      {"charge", {"body", 1, "C", VESPER_READ}},
      {"position", {"body", 3, "m", VESPER_READ_WRITE}},
      {"velocity", {"body", 3, "m/s", VESPER_READ_WRITE}},
      {"acceleration", {"body", 3, "m/s^2", VESPER_WRITE}},
      {"externalForce", {"body", 3, "N", kSum}},
      {"appliedForce", {"body", 3, "N", VESPER_READ}},
      {"radius", {"body", 1, "m", VESPER_READ}},
      {"orientation", {"body", 4, "1", VESPER_READ_WRITE}},
      {"angularVelocity", {"body", 3, "rad/s", VESPER_READ_WRITE}},
      {"inertia", {"body", 3, "kg*m^2", VESPER_READ}},
      {"torque", {"body", 3, "N*m", kSum}},
      {"dragCoefficient", {"body", 1, "kg/m", VESPER_READ}},
      {"linearDragCoefficient", {"body", 1, "kg/s", VESPER_READ}},
      {"endpoints", {"spring", 2, "1", VESPER_READ}},
      {"length", {"spring", 1, "m", VESPER_READ}},
      {"hookeConstant", {"spring", 1, "N/m", VESPER_READ}},
      {"dampingConstant", {"spring", 1, "N*s/m", VESPER_READ}},
      {"vertices", {"surface", 3, "1", VESPER_READ}},
      {"hardness", {"surface", 1, "N/m", VESPER_READ}},
      {"surfaceDamping", {"surface", 1, "N*s/m", VESPER_READ}},
      {"frictionCoefficient", {"surface", 1, "1", VESPER_READ}},
      {"gravitationalConstant", {"world", 1, "m^3/(kg*s^2)", VESPER_READ}},
      {"gravity", {"world", 3, "m/s^2", VESPER_READ}},
      {"softening", {"world", 1, "m", VESPER_READ}},
      {"coulombConstant", {"world", 1, "N*m^2/C^2", VESPER_READ}},
      {"electricField", {"world", 3, "V/m", VESPER_READ}},
      {"magneticField", {"world", 3, "T", VESPER_READ}},
      {"forceField", {"world", 3, "N", VESPER_READ}},
      {"shape", {"body", 1, "1", VESPER_READ}},
      {"size", {"body", 3, "m", VESPER_READ_WRITE}},
      {"carrier", {"body", 1, "1", VESPER_READ}},
      {"sceneryPosition", {"scenery", 3, "m", VESPER_READ}},
      {"sceneryOrientation", {"scenery", 4, "1", VESPER_READ}},
      {"sceneryShape", {"scenery", 1, "1", VESPER_READ}},
      {"scenerySize", {"scenery", 3, "m", VESPER_READ}},
      {"sceneryCarrier", {"scenery", 1, "1", VESPER_READ}},
      {"rollingFriction", {"body", 1, "m", VESPER_READ}},
      {"touchLayer", {"body", 1, "1", VESPER_READ}},
      {"passesLayers", {"body", 1, "1", VESPER_READ}},
      {"touchSensor", {"body", 1, "1", VESPER_READ}},
      {"partOfBody", {"body", 1, "1", VESPER_READ}},
      {"touchCount", {"body", 1, "1", VESPER_READ_WRITE}},
      {"meshForm", {"body", 1, "1", VESPER_READ}},
      {"sceneryMeshForm", {"scenery", 1, "1", VESPER_READ}},
      {"meshRanges", {"meshForm", 10, "1", VESPER_READ}},
      {"meshPoints", {"meshPoint", 3, "m", VESPER_READ}},
      {"meshIndices", {"meshNumber", 1, "1", VESPER_READ}},
      {"joined", {"joint", 2, "1", VESPER_READ}},
      {"jointType", {"joint", 1, "1", VESPER_READ}},
      {"anchor", {"joint", 3, "m", VESPER_READ}},
      {"axis", {"joint", 3, "1", VESPER_READ}},
      {"angleLimits", {"joint", 2, "1", VESPER_READ}},
      {"travelLimits", {"joint", 2, "m", VESPER_READ}},
      {"motorSpeed", {"joint", 1, "rad/s", VESPER_READ}},
      {"motorTorque", {"joint", 1, "N*m", VESPER_READ}},
      {"driveSpeed", {"joint", 1, "m/s", VESPER_READ}},
      {"driveForce", {"joint", 1, "N", VESPER_READ}},
      {"breakingForce", {"joint", 1, "N", VESPER_READ}},
      {"otherAnchor", {"joint", 3, "m", VESPER_READ_WRITE}},
      {"otherTurn", {"joint", 4, "1", VESPER_READ_WRITE}},
      {"jointForce", {"joint", 3, "N", VESPER_READ_WRITE}},
      {"jointTorque", {"joint", 3, "N*m", VESPER_READ_WRITE}},
      {"jointAngle", {"joint", 1, "1", VESPER_READ_WRITE}},
      {"jointTravel", {"joint", 1, "m", VESPER_READ_WRITE}},
      {"broken", {"joint", 1, "1", VESPER_READ_WRITE}},
      {"angleDamping", {"joint", 1, "N*m*s", VESPER_READ}},
      {"travelDamping", {"joint", 1, "N*s/m", VESPER_READ}},
      {"angleFriction", {"joint", 1, "N*m", VESPER_READ}},
      {"travelFriction", {"joint", 1, "N", VESPER_READ}},
      {"angleStiffness", {"joint", 1, "N*m", VESPER_READ}},
      {"travelStiffness", {"joint", 1, "N/m", VESPER_READ}},
      {"restAngle", {"joint", 1, "1", VESPER_READ}},
      {"restTravel", {"joint", 1, "m", VESPER_READ}},
      {"rotorInertia", {"joint", 1, "kg*m^2", VESPER_READ}},
      {"rotorMass", {"joint", 1, "kg", VESPER_READ}},
      {"angleSpeed", {"joint", 1, "rad/s", VESPER_READ_WRITE}},
      {"travelSpeed", {"joint", 1, "m/s", VESPER_READ_WRITE}},
      {"motorAngle", {"joint", 1, "1", VESPER_READ}},
      {"motorStiffness", {"joint", 1, "N*m", VESPER_READ}},
      {"motorDamping", {"joint", 1, "N*m*s", VESPER_READ}},
      {"driveTravel", {"joint", 1, "m", VESPER_READ}},
      {"driveStiffness", {"joint", 1, "N/m", VESPER_READ}},
      {"driveDamping", {"joint", 1, "N*s/m", VESPER_READ}},
      {"specificForce", {"body", 3, "m/s^2", VESPER_READ}},
      {"angularRate", {"body", 3, "rad/s", VESPER_READ}},
      {"contactForce", {"body", 3, "N", kSum}},
      {"reactionForce", {"body", 3, "N", VESPER_READ_WRITE}},
      {"substance", {"body", 1, "1", VESPER_READ}},
      {"substances", {"substancePair", 2, "1", VESPER_READ}},
      {"pairFriction", {"substancePair", 1, "1", VESPER_READ}},
      {"pairRestitution", {"substancePair", 1, "1", VESPER_READ}},
      {"ropeLength", {"joint", 1, "m", VESPER_READ}},
      {"geared", {"gear", 2, "1", VESPER_READ}},
      {"gearRatio", {"gear", 1, "1", VESPER_READ}},
      {"offsetAngle", {"gear", 1, "1", VESPER_READ}},
      {"offsetTravel", {"gear", 1, "m", VESPER_READ}},
      {"gearTorque", {"gear", 1, "N*m", VESPER_READ_WRITE}},
      {"gearForce", {"gear", 1, "N", VESPER_READ_WRITE}},
      {"gearPlaces", {"gear", 2, "1", VESPER_READ_WRITE}},
      {"asleep", {"body", 1, "1", VESPER_READ_WRITE}},
      {"spinFriction", {"body", 1, "m", VESPER_READ}},
      {"pairRollingFriction", {"substancePair", 1, "m", VESPER_READ}},
      {"pairSpinFriction", {"substancePair", 1, "m", VESPER_READ}},
      {"offsetLeast", {"joint", 3, "m", VESPER_READ}},
      {"offsetGreatest", {"joint", 3, "m", VESPER_READ}},
      {"turnLeast", {"joint", 3, "1", VESPER_READ}},
      {"turnGreatest", {"joint", 3, "1", VESPER_READ}},
  };
  const vesper_prototype* prototype = vesper_prototype_standard("si-f64");
  ASSERT_EQ(prototype->property_count, expected.size());
  for (uint32_t i = 0; i < prototype->property_count; ++i) {
    const vesper_property_descriptor& property = prototype->properties[i];
    const auto row = expected.find(property.name);
    ASSERT_NE(row, expected.end()) << property.name;
    EXPECT_STREQ(property.kind, row->second.kind) << property.name;
    EXPECT_EQ(property.components, row->second.components) << property.name;
    EXPECT_STREQ(property.unit.symbol, row->second.unit) << property.name;
    EXPECT_EQ(property.law_access, row->second.access) << property.name;
  }
}

/// A small prototype that each test makes invalid in one place.
struct Draft {
  std::vector<vesper_property_descriptor> properties;
  vesper_prototype prototype;

  Draft() {
    const auto real = [](const char* name, vesper_access access, const char* initial) {
      return vesper_property_descriptor{sizeof(vesper_property_descriptor),
                                        VESPER_F64,
                                        name,
                                        "body",
                                        3,
                                        access,
                                        VESPER_UNIT_NEWTON,
                                        nullptr,
                                        initial,
                                        nullptr,
                                        0,
                                        0,
                                        0};
    };
    properties = {real("wind", VESPER_READ, nullptr),
                  real("sum", VESPER_READ | VESPER_ACCUMULATE, "wind"),
                  {sizeof(vesper_property_descriptor), VESPER_U32, "ends", "rope", 2, VESPER_READ,
                   VESPER_UNIT_ONE, "body", nullptr, nullptr, 0, 0, 0}};
    prototype = {sizeof prototype, VESPER_F64, "draft", VESPER_UNIT_SECOND, 0, 0, nullptr};
  }

  vesper_error Create() {
    prototype.property_count = static_cast<uint32_t>(properties.size());
    prototype.properties = properties.data();
    const vesper_engine_config config = TestConfig();
    vesper_engine* engine = nullptr;
    const vesper_error error =
        Try([&](vesper_error* e) { return vesper_engine_create(&config, &prototype, &engine, e); });
    EXPECT_EQ(engine != nullptr, error.status == VESPER_OK);
    vesper_engine_destroy(engine);
    return error;
  }
};

TEST(PrototypeTest, DraftIsAccepted) { EXPECT_OK(Draft().Create()); }

TEST(PrototypeTest, DuplicateNameIsRefused) {
  Draft draft;
  draft.properties.push_back(draft.properties[0]);
  EXPECT_REFUSED(ALREADY_EXISTS, "property wind: declared twice", draft.Create());
}

TEST(PrototypeTest, SpoiltDraftsAreRefusedByName) {
  struct Case {
    const char* message;
    std::function<void(Draft&)> spoil;
  };
  const vesper_unit nan_scale = VESPER_UNIT_INIT(0, 0, 0, 0, 0, 0, 0, NAN, "x");
  const std::vector<Case> cases = {
      {"prototype.name", [](Draft& d) { d.prototype.name = ""; }},
      {"real_type is u32", [](Draft& d) { d.prototype.real_type = VESPER_U32; }},
      {"time_unit is m", [](Draft& d) { d.prototype.time_unit = VESPER_UNIT_METRE; }},
      {"prototype.struct_size", [](Draft& d) { d.prototype.struct_size = 3; }},
      {"properties[1].name", [](Draft& d) { d.properties[1].name = "two words"; }},
      {"properties[0].name", [](Draft& d) { d.properties[0].name = nullptr; }},
      {"property wind: kind", [](Draft& d) { d.properties[0].kind = nullptr; }},
      {"property wind: unknown scalar_type", [](Draft& d) { d.properties[0].scalar_type = 9; }},
      {"property wind: components", [](Draft& d) { d.properties[0].components = 0; }},
      {"property wind: unit", [=](Draft& d) { d.properties[0].unit = nan_scale; }},
      {"property wind: law_access", [](Draft& d) { d.properties[0].law_access = 0; }},
      {"property sum: law_access", [](Draft& d) { d.properties[1].law_access = 7; }},
      {"property sum: only real", [](Draft& d) { d.properties[1].scalar_type = VESPER_I32; }},
      {"property wind: initial_from", [](Draft& d) { d.properties[0].initial_from = "sum"; }},
      {"property sum: initial_from", [](Draft& d) { d.properties[0].components = 2; }},
      {"property ends: a property with refers_to",
       [](Draft& d) { d.properties[2].law_access = VESPER_READ_WRITE; }},
      {"property wind: has_minimum", [](Draft& d) { d.properties[0].has_minimum = 2; }},
      {"property wind: a minimum",
       [](Draft& d) {
         d.properties[0].has_minimum = 1;
         d.properties[0].minimum = NAN;
       }},
      {"property sum: a minimum", [](Draft& d) { d.properties[1].has_minimum = 1; }},
      {"property ends: a minimum", [](Draft& d) { d.properties[2].has_minimum = 1; }},
      {"properties[1].struct_size", [](Draft& d) { d.properties[1].struct_size += 8; }},
  };
  for (const Case& spoilt : cases) {
    Draft draft;
    spoilt.spoil(draft);
    EXPECT_REFUSED(INVALID_ARGUMENT, spoilt.message, draft.Create());
  }
}

TEST(PrototypeTest, DanglingNamesAreRefused) {
  Draft draft;
  draft.properties[2].refers_to = "ship";
  EXPECT_REFUSED(NOT_FOUND, "refers_to names kind ship", draft.Create());
  draft = Draft();
  draft.properties[1].initial_from = "storm";
  EXPECT_REFUSED(NOT_FOUND, "initial_from names storm", draft.Create());
}

TEST(PrototypeTest, DescriptorsOfANewerClientAreWalkedWithTheirOwnSize) {
  struct Newer {
    vesper_property_descriptor known;
    uint64_t appended;
  };
  const Draft draft;
  std::vector<Newer> newer;
  for (vesper_property_descriptor property : draft.properties) {
    property.struct_size = sizeof(Newer);
    newer.push_back({property, 0});
  }
  vesper_prototype prototype = draft.prototype;
  prototype.property_count = static_cast<uint32_t>(newer.size());
  prototype.properties = &newer[0].known;
  const vesper_engine_config config = TestConfig();
  vesper_engine* engine = nullptr;
  EXPECT_OK(
      Try([&](vesper_error* e) { return vesper_engine_create(&config, &prototype, &engine, e); }));
  std::vector<uint32_t> ends(2);
  EXPECT_EQ(vesper_provider_add_physical_property(vesper_engine_property_provider(engine), "ends",
                                                  ends.data(), 1, nullptr, 1, nullptr),
            VESPER_OK);
  vesper_engine_destroy(engine);
  newer[1].appended = 1;
  EXPECT_REFUSED(
      ABI_MISMATCH, "prototype.properties uses a field that contract",
      Try([&](vesper_error* e) { return vesper_engine_create(&config, &prototype, &engine, e); }));
}

TEST(PrototypeTest, EngineKeepsItsOwnCopy) {
  std::string name = "wind";
  Draft draft;
  draft.properties[0].name = name.c_str();
  draft.properties[1].initial_from = nullptr;
  draft.prototype.property_count = 3;
  draft.prototype.properties = draft.properties.data();
  const vesper_engine_config config = TestConfig();
  vesper_engine* engine = nullptr;
  ASSERT_EQ(vesper_engine_create(&config, &draft.prototype, &engine, nullptr), VESPER_OK);
  name = "gone";
  draft.properties.clear();
  std::vector<double> values(3);
  EXPECT_EQ(vesper_provider_add_physical_property(vesper_engine_property_provider(engine), "wind",
                                                  values.data(), 1, nullptr, 1, nullptr),
            VESPER_OK);
  vesper_engine_destroy(engine);
}

}  // namespace
}  // namespace vesper::test
