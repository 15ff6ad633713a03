// SPDX-License-Identifier: Apache-2.0
// Tests the binary interface of bindings and laws: symbols, layouts, names, defaults.
#include <cstdio>
#include <cstring>
#include <map>
#include <set>
#include <sstream>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

std::string Golden(const char* name) {
  const std::vector<char> bytes = ReadFile(std::string(VESPER_TEST_GOLDEN) + "/" + name);
  return {bytes.begin(), bytes.end()};
}

std::string ExportedSymbols(const std::string& library) {
  const std::string command = "nm -D --defined-only --format=posix '" + library + "'";
  FILE* pipe = popen(command.c_str(), "r");
  std::set<std::string> names;
  char line[512];
  while (std::fgets(line, sizeof line, pipe) != nullptr) {
    names.insert(std::string(line, std::string(line).find(' ')));
  }
  EXPECT_EQ(pclose(pipe), 0) << command;
  std::string text;
  for (const std::string& name : names) text += name + "\n";
  return text;
}

TEST(ContractTest, EngineExportsExactlyTheContract) {
  EXPECT_EQ(ExportedSymbols(VESPER_TEST_LIBRARY), Golden("exported_symbols.txt"));
}

TEST(ContractTest, LawExportsItsEntryOnly) {
  for (const char* law : {"euler", "throwing"}) {
    EXPECT_EQ(ExportedSymbols(TestLawPath(law)), "vesper_law_library_entry\n") << law;
  }
}

TEST(ContractTest, LayoutsAreFrozen) {
  uint32_t count = 0;
  const vesper_layout_entry* entries = vesper_abi_layout(&count);
  std::ostringstream text;
  for (uint32_t i = 0; i < count; ++i) {
    text << entries[i].struct_name;
    if (entries[i].field != nullptr) {
      text << '.' << entries[i].field << " at " << entries[i].offset;
    }
    text << " size " << entries[i].size << '\n';
  }
  EXPECT_EQ(text.str(), Golden("abi_layout.txt"));
}

TEST(ContractTest, FirstContractIsTheBeginningOfEveryStruct) {
  uint32_t count = 0;
  const vesper_layout_entry* entries = vesper_abi_layout(&count);
  std::istringstream first(Golden("abi_layout_1.0.txt"));
  std::map<std::string, uint32_t> sizes;
  std::set<std::string> fields;
  for (std::string line; std::getline(first, line);) {
    const std::string name = line.substr(0, line.find(' '));
    if (name.find('.') != std::string::npos) {
      fields.insert(line);
    } else {
      sizes[name] = static_cast<uint32_t>(std::stoul(line.substr(line.rfind(' '))));
    }
  }
  for (uint32_t i = 0; i < count; ++i) {
    const vesper_layout_entry& entry = entries[i];
    if (!sizes.contains(entry.struct_name)) continue;
    if (entry.field == nullptr) {
      EXPECT_GE(entry.size, sizes[entry.struct_name]) << entry.struct_name;
      continue;
    }
    std::ostringstream line;
    line << entry.struct_name << '.' << entry.field << " at " << entry.offset << " size "
         << entry.size;
    if (fields.erase(line.str()) == 1) continue;
    EXPECT_GE(entry.offset, sizes[entry.struct_name]) << line.str() << " is not appended";
  }
  EXPECT_TRUE(fields.empty()) << *fields.begin() << " is gone";
}

TEST(ContractTest, LayoutTableIsWithoutGaps) {
  // The fields of a struct are adjacent except for alignment. A missing field therefore appears as
  // a gap.
  uint32_t count = 0;
  const vesper_layout_entry* entries = vesper_abi_layout(&count);
  uint32_t end = 0;
  uint32_t size = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (entries[i].field == nullptr) {
      EXPECT_LT(size - end, 8u) << "before " << entries[i].struct_name;
      size = entries[i].size;
      end = 0;
      continue;
    }
    EXPECT_GE(entries[i].offset, end) << entries[i].struct_name << "." << entries[i].field;
    EXPECT_LT(entries[i].offset - end, 8u) << entries[i].struct_name << "." << entries[i].field;
    end = entries[i].offset + entries[i].size;
  }
  EXPECT_LT(size - end, 8u);
}

TEST(ContractTest, EveryStatusHasItsName) {
  EXPECT_STREQ(vesper_status_name(VESPER_OK), "OK");
  EXPECT_STREQ(vesper_status_name(VESPER_INTERNAL), "INTERNAL");
  std::set<std::string> names;
  for (vesper_status status = VESPER_OK; status <= VESPER_INTERNAL; ++status) {
    names.insert(vesper_status_name(status));
  }
  EXPECT_EQ(names.size(), 15u);
  EXPECT_EQ(names.count("UNKNOWN"), 0u);
  EXPECT_STREQ(vesper_status_name(-1), "UNKNOWN");
  EXPECT_STREQ(vesper_status_name(15), "UNKNOWN");
}

TEST(ContractTest, BuildIsNamed) {
  EXPECT_EQ(vesper_abi_version(), VESPER_ABI_VERSION);
  EXPECT_NE(std::string(vesper_build_info()).find("Vesper 1.0.0"), std::string::npos);
}

TEST(ContractTest, ConfigStartsWithDefaults) {
  vesper_engine_config config;
  vesper_engine_config_init(&config);
  EXPECT_EQ(config.struct_size, sizeof config);
  EXPECT_EQ(config.threads, 1u);
  EXPECT_EQ(config.validate, 0u);
  EXPECT_EQ(config.deferred, 0u);
  EXPECT_EQ(config.probe_timeout_ms, 5000u);
  EXPECT_EQ(config.law_path, nullptr);
}

TEST(ContractTest, ConfigOfAClientBuiltFor1_0IsItsOwnBytesOnly) {
  constexpr size_t kSizeIn1_0 = 48;
  alignas(8) unsigned char memory[sizeof(vesper_engine_config)];
  std::memset(memory, 0xff, sizeof memory);
  auto* config = reinterpret_cast<vesper_engine_config*>(memory);
  (vesper_engine_config_init)(config);
  EXPECT_EQ(config->struct_size, kSizeIn1_0);
  EXPECT_EQ(config->threads, 1u);
  for (size_t i = kSizeIn1_0; i < sizeof memory; ++i) EXPECT_EQ(memory[i], 0xff) << i;
  vesper_engine* engine = nullptr;  // `deferred` would be 0xffffffff if the engine read it
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_create(config, vesper_prototype_standard("si-f64"), &engine, error);
  }));
  vesper_engine_destroy(engine);
}

vesper_error Create(const vesper_engine_config* config, const vesper_prototype* prototype,
                    vesper_engine** out) {
  return Try(
      [&](vesper_error* error) { return vesper_engine_create(config, prototype, out, error); });
}

TEST(ContractTest, BadConfigsAreRefusedAndOutIsUntouched) {
  const vesper_prototype* prototype = vesper_prototype_standard("si-f64");
  vesper_engine* const sentinel = reinterpret_cast<vesper_engine*>(0x10);
  vesper_engine* out = sentinel;
  vesper_engine_config good = TestConfig();
  EXPECT_REFUSED(INVALID_ARGUMENT, "config is null", Create(nullptr, prototype, &out));
  EXPECT_REFUSED(INVALID_ARGUMENT, "prototype is null", Create(&good, nullptr, &out));
  EXPECT_REFUSED(INVALID_ARGUMENT, "out is null", Create(&good, prototype, nullptr));
  vesper_engine_config bad = good;
  bad.threads = 0;
  EXPECT_REFUSED(INVALID_ARGUMENT, "config.threads is 0", Create(&bad, prototype, &out));
  bad = good;
  bad.validate = 2;
  EXPECT_REFUSED(INVALID_ARGUMENT, "config.validate is 2", Create(&bad, prototype, &out));
  bad = good;
  bad.deferred = 2;
  EXPECT_REFUSED(INVALID_ARGUMENT, "config.deferred is 2", Create(&bad, prototype, &out));
  bad = good;
  bad.struct_size = 8;
  EXPECT_REFUSED(INVALID_ARGUMENT, "config.struct_size is 8", Create(&bad, prototype, &out));
  EXPECT_EQ(out, sentinel);
}

TEST(ContractTest, NullHandlesAreRefused) {
  uint64_t hash = 1;
  vesper_library_id id = 1;
  vesper_property property{};
  EXPECT_EQ(vesper_engine_advance(nullptr, 1, 1, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_engine_clear_fault(nullptr, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_engine_synchronize(nullptr, nullptr, 0, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_engine_state_hash(nullptr, &hash, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_engine_load_physics_law(nullptr, "x", nullptr, 0, &id, nullptr),
            VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_engine_unload_physics_law(nullptr, 1, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_provider_find_physical_property(nullptr, "mass", &property, nullptr),
            VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_provider_touch(nullptr, nullptr, 0, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_engine_property_provider(nullptr), nullptr);
  EXPECT_EQ(vesper_engine_step_count(nullptr), 0u);
  EXPECT_EQ(vesper_library_name(nullptr), nullptr);
  vesper_engine_destroy(nullptr);
  vesper_library_discard(nullptr);
  EXPECT_EQ(hash, 1u);
  EXPECT_EQ(id, 1u);
}

TEST(ContractTest, ErrorIsUntouchedOnSuccess) {
  TestEngine engine;
  vesper_error error{};
  error.status = 77;
  EXPECT_EQ(vesper_engine_advance(engine.get(), 1, 1, &error), VESPER_OK);
  EXPECT_EQ(error.status, 77);
}

}  // namespace
}  // namespace vesper::test
