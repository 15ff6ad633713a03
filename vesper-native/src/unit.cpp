// SPDX-License-Identifier: Apache-2.0
#include "unit.hpp"

#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>

namespace vesper {

bool SameUnit(const vesper_unit& a, const vesper_unit& b) {
  return SameDimension(a, b) && a.scale == b.scale;
}

bool SameDimension(const vesper_unit& a, const vesper_unit& b) {
  return std::memcmp(a.exponent, b.exponent, sizeof a.exponent) == 0;
}

bool IsValidUnit(const vesper_unit& unit) {
  return std::isfinite(unit.scale) && unit.scale > 0 && unit.reserved == 0 &&
         std::memchr(unit.symbol, '\0', sizeof unit.symbol) != nullptr;
}

std::string Describe(const vesper_unit& unit) {
  static constexpr const char* kBase[] = {"m", "kg", "s", "A", "K", "mol", "cd"};
  std::string si;
  if (unit.scale != 1) {
    char scale[32];
    std::snprintf(scale, sizeof scale, "%.17g", unit.scale);
    si = scale;
  }
  for (size_t i = 0; i < std::size(kBase); ++i) {
    const int exponent = unit.exponent[i];
    if (exponent == 0) continue;
    if (!si.empty()) si += '*';
    si += kBase[i];
    if (exponent != 1) si += '^' + std::to_string(exponent);
  }
  if (si.empty()) si = "1";
  const std::string symbol(unit.symbol, strnlen(unit.symbol, sizeof unit.symbol));
  return symbol.empty() || symbol == si ? si : symbol + " = " + si;
}

size_t ScalarSize(vesper_scalar_type type) {
  switch (type) {
    case VESPER_F32:
    case VESPER_I32:
    case VESPER_U32:
      return 4;
    case VESPER_F64:
      return 8;
  }
  return 0;
}

bool IsReal(vesper_scalar_type type) { return type == VESPER_F32 || type == VESPER_F64; }

bool IsField(vesper_scalar_type type) { return type == VESPER_FIELD; }

bool IsKnownType(vesper_scalar_type type) { return ScalarSize(type) != 0 || IsField(type); }

const char* ScalarName(vesper_scalar_type type) {
  switch (type) {
    case VESPER_F32:
      return "f32";
    case VESPER_F64:
      return "f64";
    case VESPER_I32:
      return "i32";
    case VESPER_U32:
      return "u32";
    case VESPER_FIELD:
      return "field";
  }
  return "unknown type";
}

std::string DescribeType(vesper_scalar_type type, uint32_t components) {
  return std::string(ScalarName(type)) + " x " + std::to_string(components);
}

bool IsValidName(const char* name) {
  if (name == nullptr) return false;
  const size_t length = strnlen(name, kMaxNameLength + 1);
  if (length == 0 || length > kMaxNameLength) return false;
  for (size_t i = 0; i < length; ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    if (c >= 0x80 || (std::isalnum(c) == 0 && c != '_' && c != '-')) return false;
  }
  return true;
}

}  // namespace vesper
