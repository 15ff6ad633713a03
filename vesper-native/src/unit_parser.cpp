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

/// An intermediate result. Its scale is a fraction, so that exact scales stay exact. For example,
/// g/ms gives exactly kg/s.
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

constexpr bool k_yes = true;
constexpr bool k_no = false;

// The table is generated from units/units.csv. The units of the world store in Java are generated
// from the same file.
constexpr NamedUnit kUnits[] = {
#include "units.inc"
};

struct Prefix {
  const char* symbol;
  double numerator;
  double denominator;
};

constexpr Prefix kPrefixes[] = {
#include "prefixes.inc"
};

/// Multiplication signs, longest first.
constexpr std::string_view kTimes[] = {"\u22c5", "\u00b7", "*"};

/// Superscript digits. The index of an element is its digit.
constexpr std::string_view kRaised[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                        "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
constexpr std::string_view kRaisedMinus = "\u207b";

bool IsAscii(char c) { return (static_cast<unsigned char>(c) & 0x80) == 0; }
/// Returns true for a character of a symbol: a letter, a percent sign, or a byte beyond ASCII.
bool IsSymbolic(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '%' || !IsAscii(c);
}
bool IsDigit(char c) { return c >= '0' && c <= '9'; }

const NamedUnit* FindUnit(std::string_view symbol) {
  for (const NamedUnit& unit : kUnits) {
    if (symbol == unit.symbol) return &unit;
  }
  return nullptr;
}

/// A recursive-descent parser of this grammar:
///   product = power { ("*" | "·" | "/") power };  power = atom [ "^" integer | raised digits ];
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
    if (at_ >= text_.size()) return "found the end";
    size_t end = at_ + 1;
    while (end < text_.size() && !IsAscii(text_[at_]) && (text_[end] & 0xc0) == 0x80) ++end;
    return "found '" + std::string(text_.substr(at_, end - at_)) + "'";
  }
  bool IsNext(std::string_view token) const { return text_.substr(at_).starts_with(token); }
  bool Take(std::string_view token) {
    if (!IsNext(token)) return false;
    at_ += token.size();
    return true;
  }
  bool TakeTimes() {
    return std::any_of(std::begin(kTimes), std::end(kTimes), [&](auto sign) { return Take(sign); });
  }

  Quantity Product(int depth) {
    Quantity product = Power(depth);
    while (true) {
      SkipSpaces();
      const size_t begin = at_;
      const bool times = TakeTimes();
      if (!times && !Take("/")) return product;
      if (!times && ends_with_exponent_ && IsDigit(Peek())) {
        Fail(
            at_,
            "the number behind an exponent is ambiguous; exponents are whole, and a half of m^2 is "
            "(m^2)/2");
      }
      Multiply(product, Power(depth), times ? 1 : -1, begin);
    }
  }

  Quantity Power(int depth) {
    Quantity base = Atom(depth);
    SkipSpaces();
    size_t begin = at_;
    int exponent = 0;
    ends_with_exponent_ = Take("^");
    if (ends_with_exponent_) {
      SkipSpaces();
      begin = at_;
      exponent = Exponent();
    } else if (!TakeRaised(exponent)) {
      return base;
    }
    Quantity power;
    Multiply(power, base, exponent, begin);
    return power;
  }

  bool IsRaisedNext() const {
    return IsNext(kRaisedMinus) || std::any_of(std::begin(kRaised), std::end(kRaised),
                                               [&](auto digit) { return IsNext(digit); });
  }

  bool TakeRaised(int& exponent) {
    if (!IsRaisedNext()) return false;
    const size_t begin = at_;
    const int sign = Take(kRaisedMinus) ? -1 : 1;
    if (!IsRaisedNext() || IsNext(kRaisedMinus)) {
      Fail(at_, Found() + ", expected a raised digit");
    }
    while (IsRaisedNext() && !IsNext(kRaisedMinus)) {
      for (int digit = 0; digit < 10; ++digit) {
        if (Take(kRaised[digit])) {
          exponent = 10 * exponent + digit;
          break;
        }
      }
      if (exponent > kMaxExponent) Fail(begin, "the exponent is not between -127 and 127");
    }
    exponent *= sign;
    return true;
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
    if (IsSymbolic(c) && !IsOperatorNext()) return Symbol();
    Fail(at_, Found() + ", expected a unit such as m, a number or '('");
  }

  bool IsOperatorNext() const { return IsNext(kTimes[0]) || IsNext(kTimes[1]) || IsRaisedNext(); }

  Quantity Parenthesis(int depth) {
    if (depth == kMaxDepth) Fail(at_, "parentheses are nested too deep");
    ++at_;
    const Quantity inner = Product(depth + 1);
    if (Peek() != ')') Fail(at_, Found() + ", expected '*', '/', '^' or ')'");
    ++at_;
    ends_with_exponent_ = false;
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
    while (at_ < text_.size() && IsSymbolic(text_[at_]) && !IsOperatorNext()) ++at_;
    const std::string_view symbol = text_.substr(begin, at_ - begin);
    if (const NamedUnit* unit = FindUnit(symbol)) return unit->quantity;
    for (const Prefix& prefix : kPrefixes) {
      if (!symbol.starts_with(prefix.symbol)) continue;
      const NamedUnit* unit = FindUnit(symbol.substr(std::strlen(prefix.symbol)));
      if (unit == nullptr || !unit->takes_prefix) continue;
      return {unit->quantity.exponent, unit->quantity.numerator * prefix.numerator,
              unit->quantity.denominator * prefix.denominator};
    }
    Fail(begin, "unknown unit '" + std::string(symbol) + "'" + Suggestion(symbol));
  }

  static std::string Suggestion(std::string_view symbol) {
    std::vector<std::string> symbols;
    for (const NamedUnit& unit : kUnits) symbols.emplace_back(unit.symbol);
    const std::string* nearest = NearestName(symbol, symbols);
    if (nearest == nullptr) return ", expected SI units such as m, kg, s, N, with prefixes";
    return "; did you mean '" + *nearest + "'?";
  }

  /// Multiplies a product by a power of a factor: product *= factor^power.
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
  /// True if the last power was written with ^ and is the last token so far.
  bool ends_with_exponent_ = false;
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
