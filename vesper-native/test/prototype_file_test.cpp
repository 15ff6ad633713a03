// SPDX-License-Identifier: Apache-2.0
// Tests prototypes as data files.
#include <cstring>
#include <filesystem>
#include <memory>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

struct FreePrototype {
  void operator()(vesper_prototype* prototype) const { vesper_prototype_free(prototype); }
};
using PrototypePointer = std::unique_ptr<vesper_prototype, FreePrototype>;

vesper_error TryParse(const std::string& text, PrototypePointer* out = nullptr) {
  vesper_prototype* prototype = nullptr;
  const vesper_error error = Try([&](vesper_error* e) {
    return vesper_prototype_parse(text.c_str(), "heat.prototype", &prototype, e);
  });
  PrototypePointer owned(prototype);
  if (out != nullptr) *out = std::move(owned);
  return error;
}

PrototypePointer ParsePrototype(const std::string& text) {
  PrototypePointer prototype;
  EXPECT_OK(TryParse(text, &prototype));
  return prototype;
}

TEST(PrototypeFileTest, EveryPartOfALineReachesTheDescriptor) {
  const PrototypePointer prototype = ParsePrototype(
      "# what glows\n"
      "prototype heat\r\n"
      "real f32\n"
      "time [ms]\n"
      "\n"
      "body temperature: real x1 [K] read_write \"How hot # it is.\"  # shown in red\n"
      "body heater: real x1 [kW] read min -1.5e3 \"Above what cools.\"\n"
      "body heat-flow:real x1[kW]accumulate from heater\n"
      "wire ends: u32 x2 [1] read -> body \"Rows of two bodies.\"\n"
      "wire age: i32 x1 [d] write\n"
      "wire lengths: f64 x4 [mm] read");
  ASSERT_NE(prototype, nullptr);
  EXPECT_STREQ(prototype->name, "heat");
  EXPECT_EQ(prototype->real_type, VESPER_F32);
  EXPECT_EQ(prototype->time_unit.scale, 1e-3);
  ASSERT_EQ(prototype->property_count, 6u);
  const vesper_property_descriptor* p = prototype->properties;
  EXPECT_STREQ(p[0].kind, "body");
  EXPECT_STREQ(p[0].name, "temperature");
  EXPECT_EQ(p[0].scalar_type, VESPER_F32);
  EXPECT_EQ(p[0].components, 1u);
  EXPECT_STREQ(p[0].unit.symbol, "K");
  EXPECT_EQ(p[0].law_access, VESPER_READ_WRITE);
  EXPECT_STREQ(p[0].doc, "How hot # it is.");
  EXPECT_EQ(p[0].refers_to, nullptr);
  EXPECT_EQ(p[1].law_access, VESPER_READ);
  EXPECT_EQ(p[1].has_minimum, 1u);
  EXPECT_EQ(p[1].minimum, -1500);
  EXPECT_STREQ(p[1].doc, "Above what cools.");
  EXPECT_EQ(p[2].has_minimum, 0u);
  EXPECT_EQ(p[2].doc, nullptr);
  EXPECT_STREQ(p[2].name, "heat-flow");
  EXPECT_EQ(p[2].unit.scale, 1000);
  EXPECT_EQ(p[2].law_access, VESPER_READ | VESPER_ACCUMULATE);
  EXPECT_STREQ(p[2].initial_from, "heater");
  EXPECT_EQ(p[3].scalar_type, VESPER_U32);
  EXPECT_STREQ(p[3].refers_to, "body");
  EXPECT_EQ(p[4].scalar_type, VESPER_I32);
  EXPECT_EQ(p[4].law_access, VESPER_WRITE);
  EXPECT_EQ(p[5].scalar_type, VESPER_F64);
  EXPECT_EQ(p[5].components, 4u);
}

TEST(PrototypeFileTest, ExtendingKeepsTheBaseAndAddsToIt) {
  const vesper_prototype* base = vesper_prototype_standard("si-f32");
  const PrototypePointer heat =
      ParsePrototype("prototype heat extends si-f32\nbody temperature: real x1 [K] read_write\n");
  ASSERT_EQ(heat->property_count, base->property_count + 1);
  EXPECT_EQ(heat->real_type, VESPER_F32);
  for (uint32_t i = 0; i < base->property_count; ++i) {
    EXPECT_EQ(std::memcmp(&heat->properties[i], &base->properties[i], sizeof *base->properties), 0);
  }
  EXPECT_EQ(heat->properties[base->property_count].scalar_type, VESPER_F32);
}

TEST(PrototypeFileTest, LawsWorkOnPropertiesThatAFileDeclares) {
  PrototypePointer prototype =
      ParsePrototype("prototype moon extends si-f64\nbody albedo: real x1 [1] read\n");
  const vesper_engine_config config = TestConfig();
  vesper_engine* engine = nullptr;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_create(&config, prototype.get(), &engine, error);
  }));
  prototype.reset();  // the engine has a copy
  double albedo = 0.12;
  vesper_library_id id;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_provider_add_physical_property(vesper_engine_property_provider(engine), "albedo",
                                                 &albedo, 1, nullptr, 1, error);
  }));
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_load_physics_law(engine, "asking_unknown_optional", nullptr, 0, &id,
                                          error);
  }));
  EXPECT_REFUSED(LAW_FAILED, "law asking: the property is there", Try([&](vesper_error* error) {
                   return vesper_engine_advance(engine, 1, 1, error);
                 }));
  vesper_engine_destroy(engine);
}

TEST(PrototypeFileTest, RefusalsNameFileLineAndColumn) {
  const std::string head = "prototype heat extends si-f64\n";
  const auto refuse = [&](const std::string& line) { return TryParse(head + line); };
  EXPECT_REFUSED(INVALID_ARGUMENT, "heat.prototype:1:1: found the end of the file, expected",
                 TryParse(""));
  EXPECT_REFUSED(INVALID_ARGUMENT, "heat.prototype:2:1: found 'protype', expected 'prototype NAME'",
                 TryParse("\nprotype x"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "heat.prototype:1:24: found 'si-f16', expected the standard",
                 TryParse("prototype heat extends si-f16"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "heat.prototype:2:6: found 'f16', expected f64 or f32; did you",
                 TryParse("prototype heat\nreal f16"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":3:6: found [m], expected a unit of time",
                 TryParse("prototype heat\nreal f64\ntime [m]"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":3:1: found the end of the file, expected 'time [s]'",
                 TryParse("prototype heat\nreal f64"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:1: found '!', expected the kind", refuse("!"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:5: found the end of the line, expected the name",
                 refuse("body"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:17: found 'rael', expected a type: real",
                 refuse("body albedo   : rael x1 [1] read"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "did you mean 'real'?", refuse("body albedo: rael x1 [1] read"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:19: found '1', expected 'x' and the number of components",
                 refuse("body albedo: real 1 [1] read"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:20: found '[1]', expected the number",
                 refuse("body albedo: real x[1] read"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:25: unknown unit 'nn'; did you mean",
                 refuse("body albedo: real x1 [N/nn] read"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:22: '[' is never closed", refuse("body albedo: real x1 [1"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:26: found 'reed', expected read, write,",
                 refuse("body albedo: real x1 [1] reed"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "did you mean 'read'?", refuse("body a: real x1 [1] reed"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:35: found 'none', expected the least value, such as min 0",
                 refuse("body albedo: real x1 [1] read min none"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:31: the text is never closed",
                 refuse("body albedo: real x1 [1] read \"bright"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:31: found 'and', expected '\"'",
                 refuse("body albedo: real x1 [1] read and more"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:35: found '!', expected the end of the line",
                 refuse("body albedo: real x1 [1] read \"a\" !"));
}

TEST(PrototypeFileTest, ContradictionsAreFoundAtTheirLine) {
  const std::string head = "prototype heat extends si-f64\n";
  EXPECT_REFUSED(ALREADY_EXISTS, "heat.prototype:2:6: property mass: declared twice",
                 TryParse(head + "body mass: real x1 [kg] read"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":4:6: property glow is declared in line 2 already",
                 TryParse(head + "body glow: real x1 [W] read\n\nbody glow: real x1 [W] read"));
  EXPECT_REFUSED(NOT_FOUND, ":2:6: property ends: refers_to names kind boddy",
                 TryParse(head + "wire ends: u32 x2 [1] read -> boddy"));
  EXPECT_REFUSED(NOT_FOUND, ":2:6: property glow: initial_from names lamp",
                 TryParse(head + "body glow: real x1 [W] accumulate from lamp"));
  EXPECT_REFUSED(INVALID_ARGUMENT, ":2:6: property glow: components must be 1 to 256",
                 TryParse(head + "body glow: real x257 [W] read"));
}

TEST(PrototypeFileTest, FileIsNamedWithoutItsFolder) {
  const TemporaryFolder folder;
  const std::string path = folder / "glow.prototype";
  const std::string text = "prototype glow extends si-f64\nbody glow: real x1 [W] red\n";
  WriteFile(path, {text.begin(), text.end()});
  const auto load = [](const std::string& file) {
    return Try([&](vesper_error* error) {
      vesper_prototype* out = nullptr;
      return vesper_prototype_load(file.c_str(), &out, error);
    });
  };
  const vesper_error error = load(path);
  EXPECT_EQ(std::string(error.message).find("glow.prototype:2:24: found 'red'"), 0u)
      << error.message;
  EXPECT_REFUSED(NOT_FOUND, "cannot read prototype", load(folder / "absent"));
  EXPECT_REFUSED(NOT_FOUND, "cannot read prototype", load(folder / ""));
  std::filesystem::resize_file(path, (1 << 20) + 1);
  EXPECT_REFUSED(INVALID_ARGUMENT, "a prototype has at most 1 MiB", load(path));
}

/// Returns the fenced blocks of a language in a page of docs/.
std::vector<std::string> Examples(const std::string& page, const std::string& language) {
  const std::vector<char> bytes = ReadFile(std::string(VESPER_TEST_DOCS) + "/" + page);
  const std::string text(bytes.begin(), bytes.end());
  const std::string fence = "```" + language + "\n";
  std::vector<std::string> examples;
  for (size_t at = text.find(fence); at != std::string::npos; at = text.find(fence, at)) {
    at += fence.size();
    examples.push_back(text.substr(at, text.find("```", at) - at));
  }
  return examples;
}

TEST(PrototypeFileTest, ExamplesOfThePageParse) {
  const std::vector<std::string> examples = Examples("properties-and-units.md", "prototype");
  ASSERT_EQ(examples.size(), 2u);
  const PrototypePointer heat = ParsePrototype(examples[0]);
  ASSERT_NE(heat, nullptr);
  EXPECT_EQ(heat->property_count, vesper_prototype_standard("si-f64")->property_count + 6);
  const PrototypePointer traffic = ParsePrototype(examples[1]);
  ASSERT_NE(traffic, nullptr);
  EXPECT_EQ(traffic->property_count, 2u);
  std::string slip = examples[0];
  slip.replace(slip.find("read_write"), 10, "reed");
  EXPECT_REFUSED(INVALID_ARGUMENT,
                 "heat.prototype:3:40: found 'reed', expected read, write, "
                 "read_write or accumulate; did you mean 'read'?",
                 TryParse(slip));
}

TEST(PrototypeFileTest, UnitsOfThePageParse) {
  const std::vector<char> bytes =
      ReadFile(std::string(VESPER_TEST_DOCS) + "/properties-and-units.md");
  const std::string page(bytes.begin(), bytes.end());
  const size_t begin = page.find("| text | means |");
  const std::string table = page.substr(begin, page.find("\n\n", begin) - begin);
  size_t units = 0;
  for (size_t row = table.find("\n| `"); row != std::string::npos; row = table.find("\n| `", row)) {
    const size_t end = table.find(" | ", row + 3);
    for (size_t at = table.find('`', row); at < end; at = table.find('`', at + 1)) {
      const size_t close = table.find('`', at + 1);
      vesper_unit unit;
      EXPECT_EQ(vesper_unit_parse(table.substr(at + 1, close - at - 1).c_str(), &unit, nullptr),
                VESPER_OK)
          << table.substr(at, close - at + 1);
      at = close;
      ++units;
    }
    row = end;
  }
  EXPECT_EQ(units, 59u);
}

TEST(PrototypeFileTest, NullIsRefusedAndFreeTakesIt) {
  vesper_prototype* out = nullptr;
  EXPECT_EQ(vesper_prototype_load(nullptr, &out, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_prototype_load("x", nullptr, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_prototype_parse(nullptr, "x", &out, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_prototype_parse("x", nullptr, &out, nullptr), VESPER_INVALID_ARGUMENT);
  vesper_prototype_free(nullptr);
}

}  // namespace
}  // namespace vesper::test
