// SPDX-License-Identifier: Apache-2.0
// Tests tables of laws that differ from the contract or from the prototype in one place.
#include <cstring>
#include <functional>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

int calls = 0;  // of all functions of the law

vesper_status CreateLaw(const vesper_host*, vesper_suite*, const double*, vesper_law** out,
                        vesper_error*) {
  ++calls;
  *out = reinterpret_cast<vesper_law*>(&calls);
  return VESPER_OK;
}
vesper_status BindLaw(vesper_law*, const vesper_property*, vesper_error*) {
  ++calls;
  return VESPER_OK;
}
vesper_status AdvanceLaw(vesper_law*, const vesper_step*, vesper_error*) {
  ++calls;
  return VESPER_OK;
}
void DestroyLaw(vesper_law*) { ++calls; }

/// A table that the engine accepts, until a test changes it.
struct Table {
  Table() {
    position = {sizeof position, VESPER_F64,        "position", "body", 3,
                VESPER_READ,     VESPER_UNIT_METRE, 0,          0};
    endpoints = {sizeof endpoints, VESPER_U32,      "endpoints", "spring", 2,
                 VESPER_READ,      VESPER_UNIT_ONE, 0,           0};
    law.struct_size = sizeof law;
    law.real_type = VESPER_F64;
    law.name = "mismatched";
    law.version = "1.0.0";
    law.doc = "Does nothing.";
    law.phase = VESPER_PHASE_OBSERVE;
    law.use_count = 2;
    law.create = CreateLaw;
    law.bind = BindLaw;
    law.advance = AdvanceLaw;
    law.destroy = DestroyLaw;
    library.struct_size = sizeof library;
    library.abi_version = VESPER_ABI_VERSION;
    library.name = "mismatched";
    library.law_count = 1;
  }

  vesper_property_use position{}, endpoints{};
  vesper_law_desc law{};
  vesper_law_library library{};
};

using Change = std::function<void(Table&)>;

/// Returns changes after which the engine must refuse the table.
std::vector<Change> Mismatches() {
  std::vector<Change> changes;
  for (const uint32_t major : {0u, 2u, 3u, 99u, 0xffffu}) {
    changes.push_back([=](Table& table) { table.library.abi_version = major << 16; });
  }
  for (const uint32_t size : {0u, 8u}) {
    changes.push_back([=](Table& table) { table.library.struct_size = size; });
    changes.push_back([=](Table& table) { table.law.struct_size = size; });
    changes.push_back([=](Table& table) { table.position.struct_size = size; });
  }
  for (const vesper_scalar_type type : {VESPER_F32, VESPER_I32, VESPER_U32, VESPER_FIELD, 0u, 6u}) {
    changes.push_back([=](Table& table) { table.position.scalar_type = type; });
  }
  for (const vesper_scalar_type type : {VESPER_F32, VESPER_F64, VESPER_I32, VESPER_FIELD}) {
    changes.push_back([=](Table& table) { table.endpoints.scalar_type = type; });
  }
  changes.push_back([](Table& table) { table.law.real_type = VESPER_F32; });
  changes.push_back([](Table& table) { table.law.real_type = VESPER_U32; });
  for (const uint32_t components : {0u, 1u, 2u, 4u, 6u, 9u, 0xffffffffu}) {
    changes.push_back([=](Table& table) { table.position.components = components; });
  }
  for (const char* kind : {"spring", "world", "scenery", "bodies", ""}) {
    changes.push_back([=](Table& table) { table.position.kind = kind; });
  }
  for (const char* name : {"positon", "Position", "position ", "hookeConstants", ""}) {
    changes.push_back([=](Table& table) { table.position.name = name; });
  }
  for (size_t base = 0; base < std::size(vesper_unit{}.exponent); ++base) {
    changes.push_back([=](Table& table) { ++table.position.unit.exponent[base]; });
    changes.push_back([=](Table& table) { --table.position.unit.exponent[base]; });
  }
  for (const double scale : {0.0, -1.0}) {
    changes.push_back([=](Table& table) { table.position.unit.scale = scale; });
  }
  changes.push_back([](Table& table) { table.endpoints.unit.scale = 0.01; });
  changes.push_back([](Table& table) { table.endpoints.access = VESPER_READ_WRITE; });
  changes.push_back([](Table& table) { table.position.access = VESPER_ACCUMULATE; });
  changes.push_back([](Table& table) { table.position.access = 0; });
  return changes;
}

/// Prepares and loads the table.
vesper_error Load(const TestEngine& engine, Table& table) {
  const vesper_property_use uses[] = {table.position, table.endpoints};
  table.law.uses = uses;
  table.library.laws = &table.law;
  vesper_prepared_library* prepared = nullptr;
  vesper_error error = Try([&](vesper_error* e) {
    return vesper_library_prepare_table(&table.library, nullptr, nullptr, &prepared, e);
  });
  if (error.status != VESPER_OK) return error;
  vesper_library_id id = 0;
  error = Try([&](vesper_error* e) {
    return vesper_engine_load_prepared(engine.get(), prepared, nullptr, 0, &id, e);
  });
  if (error.status == VESPER_OK) {
    EXPECT_OK(Try(
        [&](vesper_error* e) { return vesper_engine_unload_physics_law(engine.get(), id, e); }));
  } else {
    vesper_library_discard(prepared);
  }
  return error;
}

TEST(MismatchedTablesTest, EachOfManyIsRefusedBeforeAFunctionOfTheLawIsCalled) {
  Bodies bodies(2);
  TestEngine engine;
  engine.AddBodies(bodies);
  Table good;
  EXPECT_OK(Load(engine, good));
  EXPECT_GT(calls, 0) << "without a change the law is created";
  calls = 0;
  const std::vector<Change> changes = Mismatches();
  EXPECT_GE(changes.size(), 50u);
  for (size_t i = 0; i < changes.size(); ++i) {
    Table table;
    changes[i](table);
    const vesper_error error = Load(engine, table);
    EXPECT_NE(error.status, VESPER_OK) << "mismatch " << i;
    EXPECT_STRNE(error.message, "") << "mismatch " << i;
    EXPECT_EQ(std::strchr(error.message, '\n'), nullptr) << error.message;
    EXPECT_OK(engine.Advance(1, 1));
  }
  EXPECT_EQ(calls, 0);
}

}  // namespace
}  // namespace vesper::test
