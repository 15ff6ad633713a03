// SPDX-License-Identifier: Apache-2.0
// Names, numbers and units in generated C++.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "dimension.hpp"

namespace vesper::text {

/// The names of a scope.
class CppNames {
 public:
  /// Returns `name`, or a similar name that is neither a word of C++ nor in use, and takes it.
  std::string Take(const std::string& name);

 private:
  std::set<std::string> taken_;
};

/// Returns a name in snake_case: "dragCoefficient" becomes "drag_coefficient".
std::string SnakeCase(std::string_view name);
/// Returns a name in PascalCase: "newton_motion" becomes "NewtonMotion".
std::string PascalCase(std::string_view name);
/// Returns a string literal.
std::string CppString(std::string_view text);
/// Returns the shortest literal of a double with the same bits; negative numbers have a sign.
std::string CppDouble(double value);
/// Returns an indented line, broken at blanks if it has more than 100 characters, with "\n".
std::string CppLine(size_t indent, const std::string& line);
/// Returns the constant of vesper::units for a dimension, such as "newton"; empty if there is none.
std::string_view NamedUnit(const Dimension& dimension);
/// Returns a name for the unit of a dimension: "W/K" becomes "kWPerK".
std::string UnitConstant(const Dimension& dimension);

/// The units of a file that have no name in vesper::units, with their constants.
class CppUnits {
 public:
  std::string Of(const Dimension& dimension);
  std::string Declarations() const;

 private:
  struct Unit {
    Dimension dimension;
    std::string name;
  };
  CppNames names_;
  std::vector<Unit> units_;
};

}  // namespace vesper::text
