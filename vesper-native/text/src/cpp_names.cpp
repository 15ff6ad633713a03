// SPDX-License-Identifier: Apache-2.0
#include "cpp_names.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>

namespace vesper::text {
namespace {

constexpr std::string_view kReserved[] = {
    // Words of C++.
    "alignas", "alignof", "and", "and_eq", "asm", "auto", "bitand", "bitor", "bool", "break",
    "case", "catch", "char", "char8_t", "char16_t", "char32_t", "class", "compl", "concept",
    "const", "consteval", "constexpr", "constinit", "const_cast", "continue", "co_await",
    "co_return", "co_yield", "decltype", "default", "delete", "do", "double", "dynamic_cast",
    "else", "enum", "explicit", "export", "extern", "false", "float", "for", "friend", "goto", "if",
    "inline", "int", "long", "mutable", "namespace", "new", "noexcept", "not", "not_eq", "nullptr",
    "operator", "or", "or_eq", "private", "protected", "public", "register", "reinterpret_cast",
    "requires", "return", "short", "signed", "sizeof", "static", "static_assert", "static_cast",
    "struct", "switch", "template", "this", "thread_local", "throw", "true", "try", "typedef",
    "typeid", "typename", "union", "unsigned", "using", "virtual", "void", "volatile", "wchar_t",
    "while", "xor", "xor_eq",
    // Names of the generated code and of macros.
    "std", "vesper", "units", "step", "begin", "end", "linux", "unix", "errno", "assert", "NAN",
    "INFINITY", "EOF", "NULL"};

struct StandardUnit {
  Dimension dimension;
  std::string_view name;
};

constexpr StandardUnit kStandardUnits[] = {
    {kNumber, "one"},
    {kLength, "metre"},
    {Metres(0, 1, 0), "kilogram"},
    {kTime, "second"},
    {Metres(0, 0, 0, 0, 1), "kelvin"},
    {Metres(0, 0, 1, 1), "coulomb"},
    {Metres(1, 0, -1), "metre_per_second"},
    {Metres(1, 0, -2), "metre_per_second_squared"},
    {Metres(0, 0, -1), "radian_per_second"},
    {kForce, "newton"},
    {Metres(0, 1, -2), "newton_per_metre"},
    {Metres(2, 1, 0), "kilogram_metre_squared"},
    {Metres(-1, 1, 0), "kilogram_per_metre"},
    {Metres(0, 1, -1), "kilogram_per_second"},
    {Metres(1, 1, -3, -1), "volt_per_metre"},
    {Metres(0, 1, -2, -1), "tesla"},
    {Metres(3, -1, -2), "gravitational_constant"},
    {Metres(3, 1, -4, -2), "coulomb_constant"},
};

bool IsLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool IsUpper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
char Lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }
char Upper(char c) { return static_cast<char>(std::toupper(static_cast<unsigned char>(c))); }

}  // namespace

std::string CppNames::Take(const std::string& name) {
  const bool reserved = std::ranges::find(kReserved, name) != std::end(kReserved);
  std::string unique = reserved ? name + "_value" : name;
  for (int number = 2; !taken_.insert(unique).second; ++number) {
    unique = name + std::to_string(number);
  }
  return unique;
}

std::string SnakeCase(std::string_view name) {
  std::string result;
  for (size_t i = 0; i < name.size(); ++i) {
    const bool starts_word =
        i > 0 && IsUpper(name[i]) && name[i - 1] != '_' &&
        !(IsUpper(name[i - 1]) && (i + 1 == name.size() || IsUpper(name[i + 1])));
    if (starts_word) result += '_';
    result += IsLetter(name[i]) || IsDigit(name[i]) ? Lower(name[i]) : '_';
  }
  // Successive underscores become one, because names with two successive underscores are reserved
  // for the compiler.
  result.erase(std::unique(result.begin(), result.end(),
                           [](char a, char b) { return a == '_' && b == '_'; }),
               result.end());
  if (result.starts_with('_')) result.erase(0, 1);
  return result.empty() || IsDigit(result[0]) ? "value" + result : result;
}

std::string PascalCase(std::string_view name) {
  std::string result;
  bool starts_word = true;
  for (const char c : name) {
    if (!IsLetter(c) && !IsDigit(c)) {
      starts_word = true;
      continue;
    }
    result += starts_word ? Upper(c) : c;
    starts_word = false;
  }
  return result.empty() || IsDigit(result[0]) ? "Law" + result : result;
}

std::string CppString(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c == '\n' || c == '\r' || c == '\t' ? ' ' : c;
  }
  return result + '"';
}

std::string CppDouble(double value) {
  if (std::isnan(value)) return "std::numeric_limits<double>::quiet_NaN()";
  if (std::isinf(value)) {
    return std::string(value < 0 ? "-" : "") + "std::numeric_limits<double>::infinity()";
  }
  char digits[40];
  const auto end = std::to_chars(std::begin(digits), std::end(digits), value).ptr;
  return std::string(digits, end);
}

std::string CppLine(size_t indent, const std::string& line) {
  constexpr size_t kLineLength = 100;
  std::string lines, rest = std::string(indent, ' ') + line;
  size_t margin = indent;
  while (rest.size() > kLineLength) {
    size_t at = rest.rfind(' ', kLineLength);
    if (at == std::string::npos || at <= margin) at = rest.find(' ', kLineLength);
    if (at == std::string::npos) break;
    lines += rest.substr(0, at) + "\n";
    margin = indent + 4;
    rest = std::string(margin, ' ') + rest.substr(at + 1);
  }
  return lines + rest + "\n";
}

std::string_view NamedUnit(const Dimension& dimension) {
  for (const StandardUnit& unit : kStandardUnits) {
    if (unit.dimension == dimension) return unit.name;
  }
  return {};
}

std::string UnitConstant(const Dimension& dimension) {
  std::string result = "k";
  bool starts_word = true;
  for (const char c : UnitName(dimension)) {
    if (c == '/') result += "Per";
    if (!IsLetter(c) && !IsDigit(c)) {
      starts_word = true;
      continue;
    }
    result += starts_word ? Upper(c) : c;
    starts_word = false;
  }
  return result;
}

std::string CppUnits::Of(const Dimension& dimension) {
  if (const std::string_view known = NamedUnit(dimension); !known.empty()) {
    return "units::" + std::string(known);
  }
  const auto found = std::ranges::find(units_, dimension, &Unit::dimension);
  if (found != units_.end()) return found->name;
  units_.push_back({dimension, names_.Take(UnitConstant(dimension))});
  return units_.back().name;
}

std::string CppUnits::Declarations() const {
  std::string text;
  for (const Unit& each : units_) {
    const vesper_unit unit = ToUnit(each.dimension);
    text += "constexpr vesper_unit " + each.name + " = VESPER_UNIT_INIT(";
    for (const int8_t exponent : unit.exponent) text += std::to_string(exponent) + ", ";
    text += "1.0, " + CppString(unit.symbol) + ");\n";
  }
  return text;
}

}  // namespace vesper::text
