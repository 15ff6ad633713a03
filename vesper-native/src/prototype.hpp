// SPDX-License-Identifier: Apache-2.0
// The engine's copy of the client's prototype.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vesper/types.h"

namespace vesper {

inline constexpr uint32_t kNone = UINT32_MAX;

/// One declared property. References to other properties and to kinds are indices.
struct PropertySpec {
  std::string name;
  uint32_t kind;  // index into Prototype::kinds
  vesper_scalar_type type;
  uint32_t components;
  vesper_access law_access;
  vesper_unit unit;
  uint32_t refers_to;                  // kind, or kNone
  uint32_t initial_from;               // property, or kNone
  size_t row_size;                     // bytes
  std::optional<double> minimum = {};  // minimum of every component

  bool IsAccumulator() const { return (law_access & VESPER_ACCUMULATE) != 0; }
};

/// A validated prototype, immutable after construction.
class Prototype {
 public:
  explicit Prototype(const vesper_prototype& source);

  const std::string& name() const { return name_; }
  vesper_scalar_type real_type() const { return real_type_; }
  const vesper_unit& time_unit() const { return time_unit_; }
  const std::vector<PropertySpec>& properties() const { return properties_; }
  const std::vector<std::string>& kinds() const { return kinds_; }

  /// Returns the index of the property, or kNone.
  uint32_t Find(std::string_view name) const;
  /// Returns the index of the kind, or kNone.
  uint32_t FindKind(std::string_view name) const;
  /// Returns the index of the property. Throws NOT_FOUND with the nearest name as a suggestion.
  uint32_t Require(const char* name) const;

 private:
  void AddProperty(const vesper_property_descriptor& source);
  void ResolveReferences(const vesper_property_descriptor& source, PropertySpec& property);

  std::string name_;
  vesper_scalar_type real_type_;
  vesper_unit time_unit_;
  std::vector<PropertySpec> properties_;
  std::vector<std::string> kinds_;
};

}  // namespace vesper
