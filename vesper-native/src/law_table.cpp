// SPDX-License-Identifier: Apache-2.0
#include "law_table.hpp"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <span>
#include <string>

#include "failure.hpp"
#include "unit.hpp"
#include "versioned_struct.hpp"

namespace vesper {
namespace {

constexpr uint32_t kMaxStages = 16;
constexpr const char* kBadUnit = "unit has no finite positive scale or no symbol end";
constexpr uint32_t kAllClaims = VESPER_CLAIM_MOMENTUM | VESPER_CLAIM_ANGULAR_MOMENTUM |
                                VESPER_CLAIM_TRANSLATION | VESPER_CLAIM_ROTATION |
                                VESPER_CLAIM_ENERGY;

[[noreturn]] void Reject(const std::string& where, const char* what) {
  throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: %s", where.c_str(), what);
}

void Require(bool condition, const std::string& where, const char* what) {
  if (!condition) Reject(where, what);
}

void CheckAbi(const vesper_law_library& library, const char* source) {
  const uint32_t major = library.abi_version >> 16;
  const uint32_t minor = library.abi_version & 0xffff;
  if (major == VESPER_ABI_MAJOR) return;
  throw Failure(VESPER_ABI_MISMATCH, "law library %s built for %u.%u, engine speaks %u.%u", source,
                major, minor, VESPER_ABI_MAJOR, VESPER_ABI_MINOR);
}

bool IsVersion(const char* text) {
  unsigned major, minor, patch;
  int length = 0;
  return text != nullptr && std::sscanf(text, "%u.%u.%u%n", &major, &minor, &patch, &length) == 3 &&
         text[length] == '\0';
}

/// Maximum number of components of SCRATCH in a row, as many as a contact law needs several times.
constexpr uint32_t kMaxScratchComponents = 4096;

void CheckScratch(const vesper_property_use& use, const std::string& name) {
  Require(use.flags == 0, name, "SCRATCH cannot be optional or deferred");
  if (use.components <= kMaxScratchComponents) return;
  throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: SCRATCH has %u components, expected %u or fewer",
                name.c_str(), use.components, kMaxScratchComponents);
}

void CheckUse(const vesper_property_use& use, const vesper_law_desc& law,
              const std::string& where) {
  Require(IsValidName(use.name), where, "a property use has no valid name");
  const std::string name = where + ", property " + use.name;
  Require(IsValidName(use.kind), name, "kind is no valid name");
  Require(IsKnownType(use.scalar_type), name, "unknown scalar_type");
  Require(use.components > 0, name, "components is 0");
  Require(IsValidUnit(use.unit), name, kBadUnit);
  constexpr uint32_t kFlags = VESPER_USE_OPTIONAL | VESPER_USE_DEFERRED | VESPER_USE_SLOPE;
  Require((use.flags & ~kFlags) == 0, name, "unknown flags");
  Require((use.flags & VESPER_USE_SLOPE) == 0 || IsField(use.scalar_type), name,
          "only a field has a SLOPE");
  Require((use.access >= VESPER_READ && use.access <= VESPER_ACCUMULATE) ||
              use.access == VESPER_SCRATCH,
          name, "access must be READ, WRITE, READ_WRITE, ACCUMULATE or SCRATCH");
  if (use.access == VESPER_SCRATCH) CheckScratch(use, name);
  if ((use.flags & VESPER_USE_DEFERRED) != 0) {
    Require(!IsField(use.scalar_type), name, "a field cannot be DEFERRED");
    Require(use.access == VESPER_READ || law.synchronize != nullptr, name,
            "is DEFERRED, but synchronize is null");
  }
  if (use.access == VESPER_ACCUMULATE) {
    Require(law.phase == VESPER_PHASE_FORCE, name, "ACCUMULATE is for laws of phase FORCE");
    Require(IsReal(use.scalar_type), name, "only real properties accumulate");
  }
}

void CheckUses(const vesper_law_desc& law, const std::string& where) {
  const std::span uses(law.uses, law.use_count);
  for (uint32_t i = 0; i < uses.size(); ++i) {
    CheckUse(uses[i], law, where);
    for (uint32_t j = 0; j < i; ++j) {
      Require(std::strcmp(uses[i].name, uses[j].name) != 0, where + ", property " + uses[i].name,
              "is used twice");
    }
  }
}

void CheckParameters(const vesper_law_desc& law, const std::string& where) {
  const std::span parameters(law.parameters, law.parameter_count);
  for (uint32_t i = 0; i < parameters.size(); ++i) {
    const vesper_parameter_desc& parameter = parameters[i];
    Require(IsValidName(parameter.name), where, "a parameter has no valid name");
    const std::string name = where + ", parameter " + parameter.name;
    Require(parameter.doc != nullptr, name, "doc is null");
    Require(IsValidUnit(parameter.unit), name, kBadUnit);
    Require(std::isfinite(parameter.default_value) &&
                parameter.default_value >= parameter.minimum &&
                parameter.default_value <= parameter.maximum,
            name, "default_value is not within minimum and maximum");
    for (uint32_t j = 0; j < i; ++j) {
      Require(std::strcmp(parameter.name, parameters[j].name) != 0, name, "is declared twice");
    }
  }
}

void CheckForceWeights(const vesper_law_desc& law, const std::string& where) {
  if (law.force_weights == nullptr) return;
  Require(law.phase == VESPER_PHASE_INTEGRATE, where,
          "force_weights is for laws of phase INTEGRATE");
  double sum = 0;
  for (uint32_t stage = 0; stage <= law.stages; ++stage) sum += law.force_weights[stage];
  Require(std::abs(sum - 1) < 1e-9, where, "the sum of force_weights is not 1");
}

void CheckLaw(const vesper_law_desc& law, const std::string& library) {
  Require(IsValidName(law.name), library, "a law has no valid name");
  const std::string where = library + ", law " + law.name;
  Require(law.real_type == 0 || IsReal(law.real_type), where, "real_type must be f32, f64 or 0");
  Require(IsVersion(law.version), where, "version is not of the form 1.2.3");
  Require(law.doc != nullptr, where, "doc is null");
  Require(law.phase >= VESPER_PHASE_FORCE && law.phase <= VESPER_PHASE_OBSERVE, where,
          "unknown phase");
  if (law.phase == VESPER_PHASE_INTEGRATE) {
    Require(law.stages >= 1 && law.stages <= kMaxStages, where, "stages must be 1 to 16");
    Require(law.first_stage <= 1, where, "first_stage must be 0 or 1");
  } else {
    Require(law.stages == 0, where, "stages is for laws of phase INTEGRATE");
    Require(law.first_stage == 0, where, "first_stage is for laws of phase INTEGRATE");
  }
  CheckForceWeights(law, where);
  Require((law.claims & ~kAllClaims) == 0, where, "unknown claims");
  Require((law.claims & VESPER_CLAIM_ENERGY) == 0 || law.potential_energy != nullptr, where,
          "claims to conserve energy, but computes no potential energy");
  Require(law.create != nullptr && law.bind != nullptr && law.advance != nullptr &&
              law.destroy != nullptr,
          where, "create, bind, advance and destroy are required");
  CheckUses(law, where);
  CheckParameters(law, where);
}

bool ServeOnePrototype(const vesper_law_desc& a, const vesper_law_desc& b) {
  return a.real_type == b.real_type || a.real_type == 0 || b.real_type == 0;
}

void CheckFields(const vesper_law_library& library, const std::string& where) {
  const std::span fields(library.fields, library.field_count);
  for (uint32_t i = 0; i < fields.size(); ++i) {
    Require(IsValidName(fields[i].name), where, "a field has no valid name");
    const std::string name = where + ", field " + fields[i].name;
    Require(fields[i].doc != nullptr, name, "doc is null");
    Require(fields[i].components > 0, name, "components is 0");
    Require(IsValidUnit(fields[i].unit), name, kBadUnit);
    Require(fields[i].evaluate != nullptr, name, "evaluate is null");
    for (uint32_t j = 0; j < i; ++j) {
      Require(std::strcmp(fields[i].name, fields[j].name) != 0, name, "is there twice");
    }
  }
}

void CheckLaws(const vesper_law_library& library, const std::string& where) {
  const std::span laws(library.laws, library.law_count);
  for (uint32_t i = 0; i < laws.size(); ++i) {
    CheckLaw(laws[i], where);
    for (uint32_t j = 0; j < i; ++j) {
      Require(std::strcmp(laws[i].name, laws[j].name) != 0 || !ServeOnePrototype(laws[i], laws[j]),
              where + ", law " + laws[i].name, "is there twice for one precision");
    }
  }
}

}  // namespace

void LawTable::ReadLaws(const std::string& where) {
  laws_ = ReadStructs(library_.laws, library_.law_count, "laws");
  library_.laws = laws_.data();
  for (vesper_law_desc& law : laws_) {
    Require(law.use_count <= kMaxTableEntries, where, "use_count of a law is implausible");
    Require(law.parameter_count <= kMaxTableEntries, where,
            "parameter_count of a law is implausible");
    uses_.push_back(ReadStructs(law.uses, law.use_count, "uses"));
    law.uses = uses_.back().data();
    parameters_.push_back(ReadStructs(law.parameters, law.parameter_count, "parameters"));
    law.parameters = parameters_.back().data();
  }
}

LawTable::LawTable(const vesper_law_library* library, const char* source) {
  const std::string file(source);
  Require(library != nullptr, file, VESPER_LAW_LIBRARY_ENTRY " returned null");
  Require(reinterpret_cast<uintptr_t>(library) % alignof(vesper_law_library) == 0, file,
          VESPER_LAW_LIBRARY_ENTRY " returned a misaligned pointer");
  CheckAbi(*library, source);
  try {
    library_ = ReadStruct(*library, "vesper_law_library");
    Require(IsValidName(library_.name), file, "the library has no valid name");
    Require(library_.law_count >= 1 && library_.law_count <= kMaxTableEntries, file,
            "law_count must be 1 to 256");
    Require((library_.open == nullptr) == (library_.close == nullptr), file,
            "open and close go together");
    Require(library_.field_count <= kMaxTableEntries, file, "field_count is implausible");
    ReadLaws(file);
    fields_ = ReadStructs(library_.fields, library_.field_count, "fields");
    library_.fields = fields_.data();
    CheckLaws(library_, file);
    CheckFields(library_, file);
  } catch (Failure& failure) {
    if (failure.status() == VESPER_LIBRARY_LOAD_FAILED) throw;
    const vesper_status status =
        failure.status() == VESPER_ABI_MISMATCH ? VESPER_ABI_MISMATCH : VESPER_LIBRARY_LOAD_FAILED;
    throw Failure(status, "%s: %s", source, failure.error().message);
  }
}

}  // namespace vesper
