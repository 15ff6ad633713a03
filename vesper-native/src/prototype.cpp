// SPDX-License-Identifier: Apache-2.0
#include "prototype.hpp"

#include <algorithm>
#include <cmath>

#include "failure.hpp"
#include "nearest_name.hpp"
#include "unit.hpp"
#include "versioned_struct.hpp"

namespace vesper {
namespace {

constexpr uint32_t kMaxComponents = 256;
constexpr uint32_t kMaxProperties = 4096;
constexpr vesper_access kAllAccess = VESPER_READ_WRITE | VESPER_ACCUMULATE;

void CheckTimeUnit(const vesper_unit& unit) {
  constexpr int8_t kTime[7] = {0, 0, 1, 0, 0, 0, 0};
  if (!IsValidUnit(unit) || !std::equal(kTime, kTime + 7, unit.exponent)) {
    throw Failure(VESPER_INVALID_ARGUMENT, "prototype.time_unit is %s, expected a unit of time",
                  Describe(unit).c_str());
  }
}

void CheckDescriptor(const vesper_property_descriptor& property, uint32_t index) {
  if (!IsValidName(property.name)) {
    throw Failure(VESPER_INVALID_ARGUMENT,
                  "prototype.properties[%u].name: expected 1 to %zu letters, digits, '_' or '-'",
                  index, kMaxNameLength);
  }
  const auto fail = [&property](const char* what) {
    return Failure(VESPER_INVALID_ARGUMENT, "property %s: %s", property.name, what)
        .Property(property.name);
  };
  if (!IsValidName(property.kind)) throw fail("kind is no valid name");
  if (!IsKnownType(property.scalar_type)) throw fail("unknown scalar_type");
  if (IsField(property.scalar_type) && property.law_access != VESPER_READ) {
    throw fail("a field must be READ only");
  }
  if (property.components == 0 || property.components > kMaxComponents) {
    throw fail("components must be 1 to 256");
  }
  if (!IsValidUnit(property.unit)) throw fail("unit has no finite positive scale or no symbol end");
  if (property.law_access == 0 || (property.law_access & ~kAllAccess) != 0) {
    throw fail("law_access must be a set of READ, WRITE and ACCUMULATE");
  }
  if ((property.law_access & VESPER_ACCUMULATE) != 0) {
    if (!IsReal(property.scalar_type)) throw fail("only real properties accumulate");
    if ((property.law_access & VESPER_WRITE) != 0) {
      throw fail("law_access cannot hold both WRITE and ACCUMULATE");
    }
  } else if (property.initial_from != nullptr) {
    throw fail("initial_from is for accumulators only");
  }
  if (property.refers_to != nullptr &&
      (property.scalar_type != VESPER_U32 || property.law_access != VESPER_READ)) {
    throw fail("a property with refers_to must be u32 and READ only");
  }
  if (property.has_minimum > 1) throw fail("has_minimum must be 0 or 1");
  if (property.has_minimum == 1 &&
      (!IsReal(property.scalar_type) || (property.law_access & VESPER_ACCUMULATE) != 0 ||
       !std::isfinite(property.minimum))) {
    throw fail("a minimum is a finite number, of a real property that is no accumulator");
  }
}

}  // namespace

Prototype::Prototype(const vesper_prototype& given) {
  const vesper_prototype source = ReadStruct(given, "prototype");
  real_type_ = source.real_type;
  time_unit_ = source.time_unit;
  if (!IsValidName(source.name)) {
    throw Failure(VESPER_INVALID_ARGUMENT,
                  "prototype.name: expected 1 to %zu letters, digits, '_' or '-'", kMaxNameLength);
  }
  name_ = source.name;
  if (!IsReal(real_type_)) {
    throw Failure(VESPER_INVALID_ARGUMENT, "prototype %s: real_type is %s, expected f32 or f64",
                  source.name, ScalarName(real_type_));
  }
  CheckTimeUnit(source.time_unit);
  if (source.property_count > kMaxProperties) {
    throw Failure(VESPER_INVALID_ARGUMENT, "prototype %s: %u properties, at most %u are supported",
                  source.name, source.property_count, kMaxProperties);
  }
  const auto descriptors =
      ReadStructs(source.properties, source.property_count, "prototype.properties");
  for (uint32_t i = 0; i < descriptors.size(); ++i) {
    CheckDescriptor(descriptors[i], i);
    AddProperty(descriptors[i]);
  }
  for (uint32_t i = 0; i < descriptors.size(); ++i) {
    ResolveReferences(descriptors[i], properties_[i]);
  }
}

void Prototype::AddProperty(const vesper_property_descriptor& source) {
  if (Find(source.name) != kNone) {
    throw Failure(VESPER_ALREADY_EXISTS, "property %s: declared twice in prototype %s", source.name,
                  name_.c_str())
        .Property(source.name);
  }
  uint32_t kind = FindKind(source.kind);
  if (kind == kNone) {
    kind = static_cast<uint32_t>(kinds_.size());
    kinds_.emplace_back(source.kind);
  }
  properties_.push_back({.name = source.name,
                         .kind = kind,
                         .type = source.scalar_type,
                         .components = source.components,
                         .law_access = source.law_access,
                         .unit = source.unit,
                         .refers_to = kNone,
                         .initial_from = kNone,
                         .row_size = ScalarSize(source.scalar_type) * source.components});
  if (source.has_minimum == 1) properties_.back().minimum = source.minimum;
}

void Prototype::ResolveReferences(const vesper_property_descriptor& source,
                                  PropertySpec& property) {
  if (source.refers_to != nullptr) {
    property.refers_to = FindKind(source.refers_to);
    if (property.refers_to == kNone) {
      throw Failure(VESPER_NOT_FOUND, "property %s: refers_to names kind %s, which has no property",
                    source.name, source.refers_to)
          .Property(source.name);
    }
  }
  if (source.initial_from == nullptr) return;
  property.initial_from = Find(source.initial_from);
  if (property.initial_from == kNone) {
    throw Failure(VESPER_NOT_FOUND, "property %s: initial_from names %s, which is not declared",
                  source.name, source.initial_from)
        .Property(source.name);
  }
  const PropertySpec& initial = properties_[property.initial_from];
  if (initial.kind != property.kind || initial.type != property.type ||
      initial.components != property.components || !SameUnit(initial.unit, property.unit) ||
      initial.IsAccumulator()) {
    throw Failure(VESPER_INVALID_ARGUMENT,
                  "property %s: initial_from %s must be a plain property of the same kind, type "
                  "and unit",
                  source.name, source.initial_from)
        .Property(source.name);
  }
}

uint32_t Prototype::FindKind(std::string_view name) const {
  const auto found = std::find(kinds_.begin(), kinds_.end(), name);
  return found == kinds_.end() ? kNone : static_cast<uint32_t>(found - kinds_.begin());
}

uint32_t Prototype::Find(std::string_view name) const {
  const auto found = std::find_if(properties_.begin(), properties_.end(),
                                  [name](const PropertySpec& p) { return p.name == name; });
  return found == properties_.end() ? kNone : static_cast<uint32_t>(found - properties_.begin());
}

uint32_t Prototype::Require(const char* name) const {
  if (name == nullptr) throw Failure(VESPER_INVALID_ARGUMENT, "property name is null");
  const uint32_t index = Find(name);
  if (index != kNone) return index;
  std::vector<std::string> names;
  for (const PropertySpec& property : properties_) names.push_back(property.name);
  const std::string* nearest = NearestName(name, names);
  throw Failure(VESPER_NOT_FOUND, "prototype %s has no property '%.47s'%s%s%s", name_.c_str(), name,
                nearest ? "; did you mean '" : "", nearest ? nearest->c_str() : "",
                nearest ? "'?" : "")
      .Property(name);
}

}  // namespace vesper
