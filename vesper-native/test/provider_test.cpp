// SPDX-License-Identifier: Apache-2.0
// Tests arrays of the client: adding, moving, sharing, removing, editing.
#include <cmath>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

class ProviderTest : public BothModes {
 protected:
  vesper_error AddShared(TestEngine& engine, const char* name, std::vector<double>& values,
                         const std::vector<uint32_t>& indices) {
    return Try([&](vesper_error* error) {
      return vesper_provider_add_physical_property(engine.provider(), name, values.data(),
                                                   values.size(), indices.data(), indices.size(),
                                                   error);
    });
  }
  vesper_error AddEndpoints(TestEngine& engine, std::vector<uint32_t>& endpoints) {
    return Try([&](vesper_error* error) {
      return vesper_provider_add_physical_property(engine.provider(), "endpoints", endpoints.data(),
                                                   endpoints.size() / 2, nullptr,
                                                   endpoints.size() / 2, error);
    });
  }
  vesper_error Touch(TestEngine& engine, std::vector<const char*> names) {
    return Try([&](vesper_error* error) {
      return vesper_provider_touch(engine.provider(), names.data(),
                                   static_cast<uint32_t>(names.size()), error);
    });
  }
  vesper_error Remove(TestEngine& engine, const char* name) {
    return Try([&](vesper_error* error) {
      return vesper_provider_remove_physical_property(engine.provider(), name, error);
    });
  }
  vesper_property Find(TestEngine& engine, const char* name) {
    vesper_property property{};
    property.struct_size = sizeof property;
    EXPECT_OK(Try([&](vesper_error* error) {
      return vesper_provider_find_physical_property(engine.provider(), name, &property, error);
    }));
    return property;
  }
};
IN_BOTH_MODES(ProviderTest);

TEST_P(ProviderTest, FindGivesThePropertyAsBound) {
  TestEngine engine(Options());
  std::vector<double> position(12);
  EXPECT_OK(engine.Add("position", position, 3));
  const vesper_property found = Find(engine, "position");
  EXPECT_STREQ(found.name, "position");
  EXPECT_STREQ(found.kind, "body");
  EXPECT_EQ(found.scalar_type, VESPER_F64);
  EXPECT_EQ(found.components, 3u);
  EXPECT_EQ(found.access, VESPER_READ_WRITE);
  EXPECT_EQ(found.data, position.data());
  EXPECT_EQ(found.row_count, 4u);
  EXPECT_OK(Touch(engine, {"position"}));
  EXPECT_GT(Find(engine, "position").version, found.version);
}

TEST_P(ProviderTest, FindLeavesOutUntouchedOnFailure) {
  TestEngine engine(Options());
  vesper_property out{};
  out.struct_size = sizeof out;
  out.row_count = 42;
  EXPECT_EQ(vesper_provider_find_physical_property(engine.provider(), "mass", &out, nullptr),
            VESPER_NOT_FOUND);
  out.struct_size = 4;
  EXPECT_EQ(vesper_provider_find_physical_property(engine.provider(), "mass", &out, nullptr),
            VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(out.row_count, 42u);
}

TEST_P(ProviderTest, UnknownNameSuggestsTheNearest) {
  TestEngine engine(Options());
  std::vector<double> values(3);
  EXPECT_REFUSED(NOT_FOUND, "did you mean 'velocity'?", engine.Add("velocty", values, 3));
  const vesper_error error = engine.Add("xyzzyplugh", values, 3);
  EXPECT_EQ(error.status, VESPER_NOT_FOUND);
  EXPECT_EQ(std::string(error.message).find("did you mean"), std::string::npos);
  EXPECT_STREQ(error.property, "xyzzyplugh");
}

TEST_P(ProviderTest, AddRejectsDuplicateName) {
  TestEngine engine(Options());
  std::vector<double> mass(3);
  EXPECT_OK(engine.Add("mass", mass, 1));
  EXPECT_REFUSED(ALREADY_EXISTS, "property mass is bound already", engine.Add("mass", mass, 1));
}

TEST_P(ProviderTest, AddRejectsRowsThatDisagreeWithTheKind) {
  TestEngine engine(Options());
  std::vector<double> mass(3), position(12), length(5);
  EXPECT_OK(engine.Add("mass", mass, 1));
  EXPECT_REFUSED(COUNT_MISMATCH, "object_count 4, but mass of the same kind body has 3",
                 engine.Add("position", position, 3));
  EXPECT_OK(engine.Add("length", length, 1));
}

TEST_P(ProviderTest, AddRejectsImpossibleArrays) {
  TestEngine engine(Options());
  std::vector<double> values(4);
  const auto add = [&](void* data, uint64_t count, uint64_t rows) {
    return Try([&](vesper_error* error) {
      return vesper_provider_add_physical_property(engine.provider(), "mass", data, count, nullptr,
                                                   rows, error);
    });
  };
  EXPECT_REFUSED(INVALID_ARGUMENT, "data is null", add(nullptr, 4, 4));
  EXPECT_REFUSED(COUNT_MISMATCH, "value_count 3, expected object_count 4",
                 add(values.data(), 3, 4));
  EXPECT_REFUSED(INVALID_ARGUMENT, "not aligned",
                 add(reinterpret_cast<char*>(values.data()) + 4, 2, 2));
  EXPECT_REFUSED(INVALID_ARGUMENT, "does not fit memory", add(values.data(), ~0ull, ~0ull));
  EXPECT_OK(add(nullptr, 0, 0));
}

TEST_P(ProviderTest, RebindFollowsArraysThatGrew) {
  Bodies few(2), many(5);
  TestEngine engine(Options());
  engine.AddBodies(few);
  engine.Load("euler");
  engine.Load("push", {{"force", 4}});
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_OK(engine.Rebind("mass", many.mass, 1));
  EXPECT_REFUSED(COUNT_MISMATCH, "of the same kind body", engine.Advance(1, 1));
  EXPECT_OK(engine.Rebind("position", many.position, 3));
  EXPECT_OK(engine.Rebind("velocity", many.velocity, 3));
  EXPECT_OK(engine.Rebind("acceleration", many.acceleration, 3));
  EXPECT_OK(engine.Rebind("externalForce", many.force, 3));
  EXPECT_OK(engine.Rebind("orientation", many.orientation, 4));
  const Bodies before = few;
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(many.velocity[12], 1 + 4.0 / 5);
  EXPECT_EQ(few.velocity, before.velocity);
  EXPECT_EQ(vesper_engine_step_count(engine.get()), 2u);
}

TEST_P(ProviderTest, RebindNeedsABoundProperty) {
  TestEngine engine(Options());
  std::vector<double> mass(3);
  EXPECT_REFUSED(NOT_FOUND, "property mass is not bound", engine.Rebind("mass", mass, 1));
}

TEST_P(ProviderTest, RemoveIsRefusedWhileALawNeedsTheProperty) {
  Bodies bodies(2);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const vesper_library_id euler = engine.Load("euler");
  const vesper_error error = Remove(engine, "mass");
  EXPECT_REFUSED(ACCESS_CONFLICT, "property mass is needed by law euler", error);
  EXPECT_EQ(error.library_id, euler);
  EXPECT_OK(Remove(engine, "acceleration"));
  EXPECT_OK(engine.Unload(euler));
  EXPECT_OK(Remove(engine, "mass"));
  EXPECT_REFUSED(NOT_FOUND, "property mass is not bound", Remove(engine, "mass"));
}

TEST_P(ProviderTest, SharedValuesAreExpandedIntoRows) {
  Bodies bodies(4);
  std::vector<double> masses = {1, 10};
  std::vector<uint32_t> indices = {1, 0, 0, 1};
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  EXPECT_OK(Remove(engine, "mass"));
  EXPECT_OK(AddShared(engine, "mass", masses, indices));
  engine.Load("euler");
  engine.Load("push", {{"force", 20}});
  EXPECT_OK(engine.Advance(1, 1));
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(bodies.velocity[3 * i], 1 + 20 / masses[indices[i]]) << "row " << i;
  }
  // Laws use the edited values after a call of touch.
  masses[1] = 5;
  EXPECT_OK(Touch(engine, {"mass"}));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.velocity[0], 1 + 20.0 / 10 + 20.0 / 5);
}

TEST_P(ProviderTest, SharedValuesCannotBeWritten) {
  Bodies bodies(2);
  std::vector<double> one = {1, 2, 3};
  const std::vector<uint32_t> indices = {0, 0};
  TestEngine engine(Options());
  EXPECT_OK(engine.Add("mass", bodies.mass, 1));
  const auto share = [&] {
    return Try([&](vesper_error* error) {
      return vesper_provider_add_physical_property(engine.provider(), "position", one.data(), 1,
                                                   indices.data(), 2, error);
    });
  };
  EXPECT_OK(share());
  EXPECT_REFUSED(ACCESS_CONFLICT, "position: asks for READ_WRITE, but its values are shared",
                 engine.TryLoad("euler"));
  EXPECT_OK(Remove(engine, "position"));
  engine.Load("euler");
  EXPECT_REFUSED(ACCESS_CONFLICT, "property position cannot share values", share());
}

TEST_P(ProviderTest, SumsCannotShareValues) {
  std::vector<double> one = {1, 2, 3};
  const std::vector<uint32_t> indices = {0, 0};
  TestEngine engine(Options());
  EXPECT_REFUSED(ACCESS_CONFLICT, "property externalForce: the engine writes its sums",
                 Try([&](vesper_error* error) {
                   return vesper_provider_add_physical_property(
                       engine.provider(), "externalForce", one.data(), 1, indices.data(), 2, error);
                 }));
}

TEST_P(ProviderTest, SharedIndicesAreRangeChecked) {
  std::vector<double> masses = {1, 10};
  const std::vector<uint32_t> indices = {0, 1, 2};
  TestEngine engine(Options());
  EXPECT_OK(AddShared(engine, "mass", masses, indices));
  const vesper_error error = engine.Advance(1, 1);
  EXPECT_REFUSED(INVALID_ARGUMENT, "indices[2] is 2, but there are 2 values", error);
  EXPECT_EQ(error.row, 2u);
  EXPECT_STREQ(error.property, "mass");
}

TEST_P(ProviderTest, ReferencesAreRangeCheckedBeforeALawSeesThem) {
  Bodies bodies(3);
  std::vector<uint32_t> endpoints = {0, 1, 1, 3};
  std::vector<double> hooke = {1, 2};
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  EXPECT_OK(AddEndpoints(engine, endpoints));
  EXPECT_OK(engine.Add("hookeConstant", hooke, 1));
  engine.Load("springs");
  const vesper_error error = engine.Advance(1, 1);
  EXPECT_REFUSED(INVALID_ARGUMENT, "row 1 refers to row 3 of kind body, which has 3 rows", error);
  EXPECT_STREQ(error.property, "endpoints");
  EXPECT_EQ(error.row, 1u);
  EXPECT_TRUE(engine.log().empty()) << "the law must not have been bound";
  // No step was started, so there is no fault to clear.
  endpoints[3] = 2;
  EXPECT_OK(Touch(engine, {"endpoints"}));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force, (std::vector<double>{1, 0, 0, 1, 0, 0, -2, 0, 0}));
}

TEST_P(ProviderTest, ReferencesAreCheckedAgainWhenTheirTargetShrinks) {
  Bodies bodies(3);
  std::vector<uint32_t> endpoints = {0, 2};
  TestEngine engine(Options());
  EXPECT_OK(engine.Add("mass", bodies.mass, 1));
  EXPECT_OK(AddEndpoints(engine, endpoints));
  EXPECT_OK(engine.Advance(1, 1));
  bodies.mass.resize(2);
  EXPECT_OK(engine.Rebind("mass", bodies.mass, 1));
  EXPECT_REFUSED(INVALID_ARGUMENT, "refers to row 2 of kind body", engine.Advance(1, 1));
}

TEST_P(ProviderTest, ValuesBelowTheirMinimumAreNamedBeforeALawSeesThem) {
  for (const char* law : {"euler", "push"}) {
    Bodies bodies(3);
    bodies.mass = {0, -0.0, -1e-300};
    TestEngine engine(Options());
    engine.AddBodies(bodies);
    engine.Load(law);
    const vesper_error error = engine.Advance(1, 1);
    EXPECT_REFUSED(INVALID_ARGUMENT, "property mass, row 2: is -1e-300, expected 0 or more [kg]",
                   error);
    EXPECT_STREQ(error.property, "mass");
    EXPECT_EQ(error.row, 2u);
    EXPECT_EQ(error.library_id, VESPER_NO_LIBRARY);
    // No step was started, so there is no fault to clear.
    bodies.mass[2] = 1;
    EXPECT_OK(Touch(engine, {"mass"}));
    EXPECT_OK(engine.Advance(1, 1));
    bodies.mass[1] = -INFINITY;
    EXPECT_OK(Touch(engine, {"position"}));
    EXPECT_OK(Touch(engine, {"mass"}));
    EXPECT_REFUSED(INVALID_ARGUMENT, "property mass, row 1: is -inf", engine.Advance(1, 1));
  }
}

TEST_P(ProviderTest, SharedValuesAreHeldToTheirMinimumByRow) {
  std::vector<double> radii = {0.5, -0.5};
  const std::vector<uint32_t> rows = {0, 0, 0, 1};
  TestEngine engine(Options());
  EXPECT_OK(AddShared(engine, "radius", radii, rows));
  EXPECT_REFUSED(INVALID_ARGUMENT, "property radius, row 3: is -0.5", engine.Advance(1, 1));
}

TEST_P(ProviderTest, LawsAreBoundAgainOnlyWhenTheirArraysChange) {
  Bodies bodies(3);
  std::vector<uint32_t> endpoints = {0, 1};
  std::vector<double> hooke = {1};
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  EXPECT_OK(AddEndpoints(engine, endpoints));
  EXPECT_OK(engine.Add("hookeConstant", hooke, 1));
  engine.Load("springs");
  for (int i = 0; i < 3; ++i) EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(engine.log().size(), 1u);
  EXPECT_OK(Touch(engine, {"mass"}));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(engine.log().size(), 1u);
  EXPECT_OK(Touch(engine, {"endpoints"}));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(engine.log().size(), 2u);
  EXPECT_EQ(engine.log().back(), "springs: bind 1 springs");
}

TEST_P(ProviderTest, TouchWithoutNamesTouchesAll) {
  Bodies bodies(3);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const uint64_t before = Find(engine, "orientation").version;
  EXPECT_EQ(vesper_provider_touch(engine.provider(), nullptr, 0, nullptr), VESPER_OK);
  EXPECT_EQ(Find(engine, "orientation").version, before + 1);
}

TEST_P(ProviderTest, TouchTouchesNothingIfOneNameIsUnbound) {
  Bodies bodies(3);
  TestEngine engine(Options());
  engine.AddBodies(bodies);
  const uint64_t before = Find(engine, "mass").version;
  EXPECT_REFUSED(NOT_FOUND, "property charge is not bound", Touch(engine, {"mass", "charge"}));
  EXPECT_EQ(Find(engine, "mass").version, before);
}

TEST(ProviderTest, MemoryThatLawsMayWriteIsSharedByNobody) {
  Bodies bodies(4);
  TestEngine engine;
  std::vector<double> both(13);
  const auto add = [&](const char* name, double* data) {
    EXPECT_OK(Try([&](vesper_error* error) {
      return vesper_provider_add_physical_property(engine.provider(), name, data, 4, nullptr, 4,
                                                   error);
    }));
  };
  add("position", both.data());  // 12 values
  add("mass", both.data() + 9);
  const vesper_error error = engine.Advance(1, 1);
  EXPECT_REFUSED(ACCESS_CONFLICT, "properties position and mass share memory that laws may write",
                 error);
  EXPECT_STREQ(error.property, "mass");
  EXPECT_OK(engine.Rebind("mass", bodies.mass, 1));
  EXPECT_OK(engine.Advance(1, 1));
}

TEST(ProviderTest, MemoryThatLawsOnlyReadMayStandForSeveralProperties) {
  std::vector<double> ones(4, 1);
  TestEngine engine;
  EXPECT_OK(engine.Add("mass", ones, 1));
  EXPECT_OK(engine.Add("radius", ones, 1));
  EXPECT_OK(engine.Advance(1, 1));
}

}  // namespace
}  // namespace vesper::test
