// SPDX-License-Identifier: Apache-2.0
#include "matching.hpp"

#include <cmath>
#include <span>
#include <string>
#include <string_view>

#include "failure.hpp"
#include "nearest_name.hpp"
#include "unit.hpp"
#include "versioned_struct.hpp"

namespace vesper {
namespace {

const char* AccessName(vesper_access access) {
  switch (access) {
    case VESPER_READ:
      return "READ";
    case VESPER_WRITE:
      return "WRITE";
    case VESPER_READ_WRITE:
      return "READ_WRITE";
    case VESPER_ACCUMULATE:
      return "ACCUMULATE";
    case VESPER_READ | VESPER_ACCUMULATE:
      return "READ or ACCUMULATE";
  }
  return "a set of several";
}

Failure Mismatch(vesper_status status, const vesper_law_desc& law, const vesper_property_use& use,
                 const char* what, const std::string& asked, const std::string& declared) {
  return Failure(status, "law %s: property %s: %s is %s, expected %s", law.name, use.name, what,
                 asked.c_str(), declared.c_str())
      .Property(use.name);
}

void CheckUse(const vesper_law_desc& law, const vesper_property_use& use, const PropertySpec& spec,
              const std::string& kind) {
  if (kind != use.kind) throw Mismatch(VESPER_TYPE_MISMATCH, law, use, "kind", use.kind, kind);
  if (spec.type != use.scalar_type || spec.components != use.components) {
    throw Mismatch(VESPER_TYPE_MISMATCH, law, use, "type",
                   DescribeType(use.scalar_type, use.components),
                   DescribeType(spec.type, spec.components));
  }
  const bool convertible =
      (IsReal(spec.type) || IsField(spec.type)) && SameDimension(spec.unit, use.unit);
  if (!convertible && !SameUnit(spec.unit, use.unit)) {
    throw Mismatch(VESPER_UNIT_MISMATCH, law, use, "unit", Describe(use.unit), Describe(spec.unit));
  }
  if ((use.access & ~spec.law_access) != 0) {
    throw Failure(VESPER_ACCESS_CONFLICT,
                  "law %s: property %s: asks for %s, but the prototype allows %s", law.name,
                  use.name, AccessName(use.access), AccessName(spec.law_access))
        .Property(use.name);
  }
  if (law.phase == VESPER_PHASE_FORCE && spec.IsAccumulator() && use.access == VESPER_READ) {
    throw Failure(VESPER_ACCESS_CONFLICT,
                  "law %s: property %s: cannot be READ in phase FORCE, where it is being summed",
                  law.name, use.name)
        .Property(use.name);
  }
}

/// Matches a SCRATCH use, which is memory of the law with one entry for each row of a kind, with a
/// kind of the prototype.
MatchedUse MatchScratch(const vesper_law_desc& law, const vesper_property_use& use,
                        const Prototype& prototype) {
  const uint32_t kind = prototype.FindKind(use.kind);
  if (kind == kNone) {
    throw Failure(VESPER_NOT_FOUND, "law %s: scratch %s: prototype %s has no kind %s", law.name,
                  use.name, prototype.name().c_str(), use.kind)
        .Property(use.name);
  }
  return {.property = kNone,
          .use = &use,
          .scratch_kind = kind,
          .scratch = ScratchColumn(use.components * ScalarSize(use.scalar_type))};
}

/// Throws an exception if the law may write the property, because several rows share its values.
void CheckShared(const vesper_law_desc& law, const vesper_property_use& use) {
  if (use.access == VESPER_READ) return;
  throw Failure(VESPER_ACCESS_CONFLICT,
                "law %s: property %s: asks for %s, but its values are shared through indices",
                law.name, use.name, AccessName(use.access))
      .Property(use.name);
}

/// Returns the property, or kNone if the use is optional and the prototype has no such property.
uint32_t FindProperty(const vesper_law_desc& law, const vesper_property_use& use,
                      const Prototype& prototype) {
  if ((use.flags & VESPER_USE_OPTIONAL) != 0) return prototype.Find(use.name);
  try {
    return prototype.Require(use.name);
  } catch (Failure& failure) {
    failure.Within(std::string("law ") + law.name);
    throw;
  }
}

struct ParameterName {
  std::string_view law;  // empty: of any law
  std::string_view parameter;

  explicit ParameterName(std::string_view name) {
    const size_t dot = name.find('.');
    if (dot != std::string_view::npos) law = name.substr(0, dot);
    parameter = dot == std::string_view::npos ? name : name.substr(dot + 1);
  }
};

struct ParameterSlot {
  size_t law;
  size_t index;
  const vesper_parameter_desc* desc;
};

/// Lists all parameters of a library that a name may select, in the order of the laws.
std::vector<ParameterSlot> ListParameters(const std::vector<std::unique_ptr<LoadedLaw>>& laws) {
  std::vector<ParameterSlot> slots;
  for (size_t law = 0; law < laws.size(); ++law) {
    const vesper_law_desc& desc = laws[law]->law.desc();
    const std::span descs(desc.parameters, desc.parameter_count);
    for (uint32_t i = 0; i < descs.size(); ++i) slots.push_back({law, i, &descs[i]});
  }
  return slots;
}

size_t FindSlot(const std::vector<std::unique_ptr<LoadedLaw>>& laws,
                const std::vector<ParameterSlot>& slots, const char* name) {
  const ParameterName wanted(name);
  size_t found = slots.size();
  for (size_t i = 0; i < slots.size(); ++i) {
    const char* law = laws[slots[i].law]->law.desc().name;
    if (wanted.parameter != slots[i].desc->name) continue;
    if (!wanted.law.empty() && wanted.law != law) continue;
    if (found != slots.size()) {
      throw Failure(VESPER_INVALID_ARGUMENT, "parameter '%s' is ambiguous: write %s.%s or %s.%s",
                    name, laws[slots[found].law]->law.desc().name, slots[i].desc->name, law,
                    slots[i].desc->name);
    }
    found = i;
  }
  if (found != slots.size()) return found;
  std::vector<std::string> names;
  for (const ParameterSlot& slot : slots) names.emplace_back(slot.desc->name);
  const std::string* nearest = NearestName(wanted.parameter, names);
  throw Failure(VESPER_NOT_FOUND, "law %s has no parameter '%.47s'%s%s%s",
                laws.front()->law.desc().name, name, nearest ? "; did you mean '" : "",
                nearest ? nearest->c_str() : "", nearest ? "'?" : "");
}

void CheckValue(const char* law, const vesper_parameter_desc& desc, double value) {
  if (std::isfinite(value) && value >= desc.minimum && value <= desc.maximum) return;
  throw Failure(VESPER_INVALID_ARGUMENT, "law %s: parameter %s is %g, expected %g to %g [%s]", law,
                desc.name, value, desc.minimum, desc.maximum, desc.unit.symbol);
}

}  // namespace

std::vector<MatchedUse> MatchUses(const vesper_law_desc& law, const Prototype& prototype,
                                  const Columns& columns) {
  const std::span uses(law.uses, law.use_count);
  std::vector<MatchedUse> matched;
  for (uint32_t i = 0; i < uses.size(); ++i) {
    if (uses[i].access == VESPER_SCRATCH) {
      matched.push_back(MatchScratch(law, uses[i], prototype));
      continue;
    }
    matched.push_back({.property = FindProperty(law, uses[i], prototype), .use = &uses[i]});
    const uint32_t property = matched.back().property;
    if (property == kNone) continue;
    const PropertySpec& spec = prototype.properties()[property];
    CheckUse(law, uses[i], spec, prototype.kinds()[spec.kind]);
    matched.back().to_law = {spec.unit.scale, uses[i].unit.scale};
    if ((uses[i].access & VESPER_WRITE) != 0) matched.back().minimum = spec.minimum;
    if (columns[property].arrays.indices != nullptr) CheckShared(law, uses[i]);
  }
  return matched;
}

std::unique_ptr<LoadedField> MatchField(const char* library, const vesper_field_desc& field,
                                        const Prototype& prototype) {
  const std::string label = std::string("library ") + library;
  uint32_t property;
  try {
    property = prototype.Require(field.name);
  } catch (Failure& failure) {
    failure.Within(label);
    throw;
  }
  const PropertySpec& spec = prototype.properties()[property];
  const auto mismatch = [&](vesper_status status, const char* what, const std::string& found,
                            const std::string& expected) {
    return Failure(status, "%s: field %s: %s is %s, expected %s", label.c_str(), field.name, what,
                   found.c_str(), expected.c_str())
        .Property(field.name);
  };
  if (!IsField(spec.type) || spec.components != field.components) {
    throw mismatch(VESPER_TYPE_MISMATCH, "type", DescribeType(VESPER_FIELD, field.components),
                   DescribeType(spec.type, spec.components));
  }
  if (!SameDimension(field.unit, spec.unit)) {
    throw mismatch(VESPER_UNIT_MISMATCH, "unit", Describe(field.unit), Describe(spec.unit));
  }
  return std::make_unique<LoadedField>(
      LoadedField{property, &field, {field.unit.scale, spec.unit.scale}});
}

void CheckCompatible(const LoadedLaw& a, const LoadedLaw& b, const Prototype& prototype) {
  const vesper_law_desc& first = a.law.desc();
  const vesper_law_desc& second = b.law.desc();
  if (first.phase != second.phase) return;
  for (const MatchedUse& matched : a.uses) {
    if (matched.property == kNone) continue;
    if (!a.Writes(matched.property) || !b.Writes(matched.property)) continue;
    const std::string& property = prototype.properties()[matched.property].name;
    throw Failure(VESPER_ACCESS_CONFLICT, "laws %s and %s both %s property %s", first.name,
                  second.name, first.phase == VESPER_PHASE_INTEGRATE ? "integrate" : "write",
                  property.c_str())
        .Property(property);
  }
  if (first.phase == VESPER_PHASE_INTEGRATE && first.stages != second.stages) {
    throw Failure(VESPER_ACCESS_CONFLICT,
                  "integrator %s has %u stages, but %s has %u; all integrators of an engine need "
                  "the same number",
                  first.name, first.stages, second.name, second.stages);
  }
}

std::vector<std::vector<double>> ResolveParameters(
    const std::vector<std::unique_ptr<LoadedLaw>>& laws, const vesper_parameter* parameters,
    uint32_t count) {
  const std::vector<ParameterSlot> slots = ListParameters(laws);
  std::vector<std::vector<double>> values(laws.size());
  for (const ParameterSlot& slot : slots) values[slot.law].push_back(slot.desc->default_value);
  std::vector<bool> given(slots.size());
  const auto wanted = ReadStructs(parameters, count, "parameters");
  for (uint32_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i].name == nullptr) {
      throw Failure(VESPER_INVALID_ARGUMENT, "parameters[%u].name is null", i);
    }
    const size_t found = FindSlot(laws, slots, wanted[i].name);
    const ParameterSlot& slot = slots[found];
    if (given[found]) {
      throw Failure(VESPER_ALREADY_EXISTS, "parameter '%s' is given twice", wanted[i].name);
    }
    given[found] = true;
    CheckValue(laws[slot.law]->law.desc().name, *slot.desc, wanted[i].value);
    values[slot.law][slot.index] = wanted[i].value;
  }
  return values;
}

}  // namespace vesper
