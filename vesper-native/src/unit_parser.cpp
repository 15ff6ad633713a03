// SPDX-License-Identifier: Apache-2.0
#include "unit_parser.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "failure.hpp"
#include "nearest_name.hpp"
#include "unit.hpp"

namespace vesper {
namespace {

constexpr size_t kMaxText = 255;
constexpr int kMaxDepth = 16;
constexpr int kMaxExponent = 127;

/// A unit in the making. The scale is a fraction so that exact ones stay exact: g/ms is kg/s.
struct Quantity {
  std::array<int, 7> exponent{};
  double numerator = 1;
  double denominator = 1;
};

struct NamedUnit {
  const char* symbol;
  bool takes_prefix;
  Quantity quantity;
};

constexpr Quantity Si(int m, int kg, int s, int a = 0, int k = 0, int mol = 0, int cd = 0) {
  return {{m, kg, s, a, k, mol, cd}, 1, 1};
}

constexpr Quantity Scaled(Quantity quantity, double numerator, double denominator = 1) {
  return {quantity.exponent, numerator, denominator};
}

constexpr NamedUnit kUnits[] = {
    {"m", true, Si(1, 0, 0)},
    {"g", true, Scaled(Si(0, 1, 0), 1, 1000)},
    {"s", true, Si(0, 0, 1)},
    {"A", true, Si(0, 0, 0, 1)},
    {"K", true, Si(0, 0, 0, 0, 1)},
    {"mol", true, Si(0, 0, 0, 0, 0, 1)},
    {"cd", true, Si(0, 0, 0, 0, 0, 0, 1)},
    {"rad", true, Si(0, 0, 0)},
    {"sr", false, Si(0, 0, 0)},
    {"deg", false, Scaled(Si(0, 0, 0), std::numbers::pi, 180)},
    {"Hz", true, Si(0, 0, -1)},
    {"N", true, Si(1, 1, -2)},
    {"Pa", true, Si(-1, 1, -2)},
    {"J", true, Si(2, 1, -2)},
    {"W", true, Si(2, 1, -3)},
    {"C", true, Si(0, 0, 1, 1)},
    {"V", true, Si(2, 1, -3, -1)},
    {"F", true, Si(-2, -1, 4, 2)},
    {"Ohm", true, Si(2, 1, -3, -2)},
    {"S", true, Si(-2, -1, 3, 2)},
    {"Wb", true, Si(2, 1, -2, -1)},
    {"T", true, Si(0, 1, -2, -1)},
    {"H", true, Si(2, 1, -2, -2)},
    {"lm", true, Si(0, 0, 0, 0, 0, 0, 1)},
    {"lx", true, Si(-2, 0, 0, 0, 0, 0, 1)},
    {"min", false, Scaled(Si(0, 0, 1), 60)},
    {"h", false, Scaled(Si(0, 0, 1), 3600)},
    {"d", false, Scaled(Si(0, 0, 1), 86400)},
    {"L", true, Scaled(Si(3, 0, 0), 1, 1000)},
    {"t", false, Scaled(Si(0, 1, 0), 1000)},
    {"bar", true, Scaled(Si(-1, 1, -2), 1e5)},
    {"eV", true, Scaled(Si(2, 1, -2), 1.602176634e-19)},
};

struct Prefix {
  const char* symbol;
  double numerator;
  double denominator;
};

constexpr Prefix kPrefixes[] = {
    {"f", 1, 1e15}, {"p", 1, 1e12}, {"n", 1, 1e9},  {"u", 1, 1e6}, {"m", 1, 1e3},
    {"c", 1, 100},  {"d", 1, 10},   {"h", 100, 1},  {"k", 1e3, 1}, {"M", 1e6, 1},
    {"G", 1e9, 1},  {"T", 1e12, 1}, {"P", 1e15, 1},
};

bool IsLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }

const NamedUnit* FindUnit(std::string_view symbol) {
  for (const NamedUnit& unit : kUnits) {
    if (symbol == unit.symbol) return &unit;
  }
  return nullptr;
}

/// Recursive descent over
///   product = power { ("*" | "/") power };  power = atom [ "^" integer ];
///   atom = symbol | number | "(" product ")"
class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Quantity Parse() {
    if (text_.size() > kMaxText) Fail(kMaxText, "a unit is at most 255 bytes long");
    const Quantity quantity = Product(0);
    if (at_ != text_.size()) Fail(at_, Found() + ", expected '*', '/', '^' or the end");
    return quantity;
  }

 private:
  [[noreturn]] static void Fail(size_t offset, std::string message) {
    throw UnitError{offset, std::move(message)};
  }

  void SkipSpaces() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }
  char Peek() {
    SkipSpaces();
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  std::string Found() const {
    return at_ < text_.size() ? std::string("found '") + text_[at_] + "'" : "found the end";
  }

  Quantity Product(int depth) {
    Quantity product = Power(depth);
    for (char c = Peek(); c == '*' || c == '/'; c = Peek()) {
      const size_t begin = at_++;
      Multiply(product, Power(depth), c == '*' ? 1 : -1, begin);
    }
    return product;
  }

  Quantity Power(int depth) {
    Quantity base = Atom(depth);
    if (Peek() != '^') return base;
    ++at_;
    SkipSpaces();
    const size_t begin = at_;
    Quantity power;
    Multiply(power, base, Exponent(), begin);
    return power;
  }

  int Exponent() {
    int exponent = 0;
    const auto [end, error] = std::from_chars(Rest(), End(), exponent);
    if (error == std::errc::invalid_argument) {
      Fail(at_, Found() + ", expected a whole number as exponent");
    }
    if (error != std::errc() || std::abs(exponent) > kMaxExponent) {
      Fail(at_, "the exponent is not between -127 and 127");
    }
    at_ = static_cast<size_t>(end - text_.data());
    return exponent;
  }

  Quantity Atom(int depth) {
    const char c = Peek();
    if (c == '(') return Parenthesis(depth);
    if (IsDigit(c)) return Number();
    if (IsLetter(c)) return Symbol();
    Fail(at_, Found() + ", expected a unit such as m, a number or '('");
  }

  Quantity Parenthesis(int depth) {
    if (depth == kMaxDepth) Fail(at_, "parentheses are nested too deep");
    ++at_;
    const Quantity inner = Product(depth + 1);
    if (Peek() != ')') Fail(at_, Found() + ", expected '*', '/', '^' or ')'");
    ++at_;
    return inner;
  }

  Quantity Number() {
    double value = 0;
    const auto [end, error] = std::from_chars(Rest(), End(), value);
    if (error != std::errc() || !(value > 0)) Fail(at_, "a number must be above 0 and in range");
    at_ = static_cast<size_t>(end - text_.data());
    return {{}, value, 1};
  }

  Quantity Symbol() {
    const size_t begin = at_;
    while (at_ < text_.size() && IsLetter(text_[at_])) ++at_;
    const std::string_view symbol = text_.substr(begin, at_ - begin);
    if (const NamedUnit* unit = FindUnit(symbol)) return unit->quantity;
    for (const Prefix& prefix : kPrefixes) {
      if (symbol[0] != prefix.symbol[0]) continue;
      const NamedUnit* unit = FindUnit(symbol.substr(1));
      if (unit == nullptr || !unit->takes_prefix) continue;
      return {unit->quantity.exponent, unit->quantity.numerator * prefix.numerator,
              unit->quantity.denominator * prefix.denominator};
    }
    Fail(begin, "unknown unit '" + std::string(symbol) + "'" + Suggestion(symbol));
  }

  static std::string Suggestion(std::string_view symbol) {
    std::vector<std::string> symbols;
    for (const NamedUnit& unit : kUnits) symbols.emplace_back(unit.symbol);
    symbols.emplace_back("kg");
    const std::string* nearest = NearestName(symbol, symbols);
    if (nearest == nullptr) return ", expected SI units such as m, kg, s, N, with prefixes";
    return "; did you mean '" + *nearest + "'?";
  }

  /// product *= factor^power
  static void Multiply(Quantity& product, const Quantity& factor, int power, size_t offset) {
    for (size_t i = 0; i < product.exponent.size(); ++i) {
      product.exponent[i] += factor.exponent[i] * power;
      if (std::abs(product.exponent[i]) > kMaxExponent) {
        Fail(offset, "an exponent of the unit leaves -127 to 127");
      }
    }
    product.numerator *=
        std::pow(power > 0 ? factor.numerator : factor.denominator, std::abs(power));
    product.denominator *=
        std::pow(power > 0 ? factor.denominator : factor.numerator, std::abs(power));
  }

  const char* Rest() const { return text_.data() + at_; }
  const char* End() const { return text_.data() + text_.size(); }

  std::string_view text_;
  size_t at_ = 0;
};

}  // namespace

vesper_unit ParseUnitOrThrowWhere(std::string_view text) {
  const Quantity quantity = Parser(text).Parse();
  vesper_unit unit{};
  for (size_t i = 0; i < quantity.exponent.size(); ++i) {
    unit.exponent[i] = static_cast<int8_t>(quantity.exponent[i]);
  }
  unit.scale = quantity.numerator / quantity.denominator;
  if (!IsValidUnit(unit)) throw UnitError{0, "the scale of the unit is out of range"};
  if (text.size() < sizeof unit.symbol) text.copy(unit.symbol, text.size());
  return unit;
}

vesper_unit ParseUnit(std::string_view text) {
  try {
    return ParseUnitOrThrowWhere(text);
  } catch (const UnitError& error) {
    throw Failure(VESPER_INVALID_ARGUMENT, "unit '%.*s', column %zu: %s",
                  static_cast<int>(std::min<size_t>(text.size(), 64)), text.data(),
                  error.offset + 1, error.message.c_str());
  }
}

}  // namespace vesper
