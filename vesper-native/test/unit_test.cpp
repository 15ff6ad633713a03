// SPDX-License-Identifier: Apache-2.0
// Tests the parser of units.
#include <array>
#include <cstring>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

vesper_error ParseUnit(const std::string& text, vesper_unit& out) {
  return Try([&](vesper_error* error) { return vesper_unit_parse(text.c_str(), &out, error); });
}

vesper_error Refusal(const std::string& text) {
  vesper_unit out{};
  return ParseUnit(text, out);
}

TEST(UnitTest, TextsOfTheStandardPrototypesParseToTheirUnits) {
  const vesper_prototype* prototype = vesper_prototype_standard("si-f64");
  for (uint32_t i = 0; i < prototype->property_count; ++i) {
    const vesper_unit& expected = prototype->properties[i].unit;
    vesper_unit parsed{};
    EXPECT_OK(ParseUnit(expected.symbol, parsed));
    EXPECT_EQ(std::memcmp(&parsed, &expected, sizeof parsed), 0) << expected.symbol;
  }
}

TEST(UnitTest, ExponentsAndScaleAreThoseOfTheBrochure) {
  struct Row {
    std::array<int, 7> exponent;
    double scale;
  };
  const std::map<std::string, Row> expected = {
      {"km/h", {{1, 0, -1}, 1000.0 / 3600}},
      {"kg*m^2/s^2", {{2, 1, -2}, 1}},
      {"g/ms", {{0, 1, -1}, 1}},
      {"g", {{0, 1}, 1e-3}},
      {"mm^2", {{2}, 1e-6}},
      {"m/s/s", {{1, 0, -2}, 1}},
      {"m/(s*s)", {{1, 0, -2}, 1}},
      {"1/s", {{0, 0, -1}, 1}},
      {"s^-1", {{0, 0, -1}, 1}},
      {"(km/h)^2", {{2, 0, -2}, 1e6 / 12960000}},
      {"9.80665*m/s^2", {{1, 0, -2}, 9.80665}},
      {"deg", {{}, std::numbers::pi / 180}},
      {"deg/min", {{0, 0, -1}, std::numbers::pi / 10800}},
      {"J/(kg*K)", {{2, 0, -2, 0, -1}, 1}},
      {"W/(m^2*K)", {{0, 1, -3, 0, -1}, 1}},
      {"V/m", {{1, 1, -3, -1}, 1}},
      {"uF", {{-2, -1, 4, 2}, 1e-6}},
      {"kOhm", {{2, 1, -3, -2}, 1e3}},
      {"mol/L", {{-3, 0, 0, 0, 0, 1}, 1e3}},
      {"lx", {{-2, 0, 0, 0, 0, 0, 1}, 1}},
      {"min", {{0, 0, 1}, 60}},
      {"cd", {{0, 0, 0, 0, 0, 0, 1}, 1}},
      {"hPa", {{-1, 1, -2}, 100}},
      {"Pa", {{-1, 1, -2}, 1}},
      {" N * m ", {{2, 1, -2}, 1}},
  };
  for (const auto& [text, row] : expected) {
    vesper_unit parsed{};
    EXPECT_OK(ParseUnit(text, parsed));
    for (size_t i = 0; i < 7; ++i) EXPECT_EQ(parsed.exponent[i], row.exponent[i]) << text;
    EXPECT_EQ(parsed.scale, row.scale) << text;
    EXPECT_EQ(parsed.symbol, text);
  }
}

TEST(UnitTest, TextsMeanWhatTheyMeanToTheWorldStore) {
  std::ifstream file(VESPER_TEST_UNITS "/vectors.csv");
  std::string line;
  std::getline(file, line);
  int count = 0;
  for (; std::getline(file, line); ++count) {
    std::istringstream row(line);
    std::string text, scale;
    std::getline(row, text, ',');
    std::getline(row, scale, ',');
    vesper_unit parsed{};
    if (scale == "refused") {
      EXPECT_EQ(ParseUnit(text, parsed).status, VESPER_INVALID_ARGUMENT) << text;
      continue;
    }
    EXPECT_OK(ParseUnit(text, parsed));
    EXPECT_EQ(parsed.scale, std::stod(scale)) << text;
    for (int8_t exponent : parsed.exponent) {
      std::string expected;
      std::getline(row, expected, ',');
      EXPECT_EQ(exponent, std::stoi(expected)) << text;
    }
  }
  EXPECT_GT(count, 150);
}

TEST(UnitTest, TextTooLongForASymbolLeavesItEmpty) {
  vesper_unit parsed{};
  EXPECT_OK(ParseUnit("kg*m^2/(s^3*A^2)", parsed));
  EXPECT_STREQ(parsed.symbol, "");
  EXPECT_OK(ParseUnit("kg*m^2/(s^3*A)", parsed));
  EXPECT_STREQ(parsed.symbol, "kg*m^2/(s^3*A)");
}

TEST(UnitTest, RefusalsNameTheColumnAndWhatWasExpected) {
  EXPECT_REFUSED(INVALID_ARGUMENT, "column 1: found the end, expected a unit", Refusal(""));
  EXPECT_REFUSED(INVALID_ARGUMENT, "unit 'N/', column 3: found the end", Refusal("N/"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "column 4: found 'm', expected '*', '/', '^'", Refusal("kg m"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "column 3: found 'x', expected a whole number", Refusal("m^x"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "column 4: found '.', expected", Refusal("m^1.5"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "column 5: found the end, expected '*', '/', '^' or ')'",
                 Refusal("1/(s"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "column 2: found ')'", Refusal("s)"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "column 3: unknown unit 'hz'; did you mean 'Hz'?",
                 Refusal("1/hz"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "unknown unit 'degC'; did you mean 'deg'?", Refusal("degC"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "unknown unit 'kmin'", Refusal("kmin"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "must be above 0", Refusal("0*m"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "not between -127 and 127", Refusal("m^128"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "leaves -127 to 127", Refusal("m^127*m"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "scale of the unit is out of range", Refusal("km^127"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "nested too deep", Refusal(std::string(17, '(')));
  EXPECT_REFUSED(INVALID_ARGUMENT, "at most 255 bytes", Refusal(std::string(256, 'm')));
}

TEST(UnitTest, RefusalLeavesOutUntouched) {
  vesper_unit out = VESPER_UNIT_NEWTON;
  EXPECT_EQ(vesper_unit_parse("nonsense", &out, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_unit_parse(nullptr, &out, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_EQ(vesper_unit_parse("m", nullptr, nullptr), VESPER_INVALID_ARGUMENT);
  EXPECT_STREQ(out.symbol, "N");
}

}  // namespace
}  // namespace vesper::test
