// SPDX-License-Identifier: Apache-2.0
#include "laws_command.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <span>

#include "csv.hpp"
#include "exit_code.hpp"
#include "text_table.hpp"
#include "unit.hpp"
#include "vesper/kit/law_file.hpp"
#include "vesper/vesper.hpp"

namespace vesper::cli {
namespace {

using Json = nlohmann::ordered_json;

const char* PhaseName(vesper_phase phase) {
  constexpr const char* kNames[] = {"force", "integrate", "constrain", "observe"};
  return kNames[phase - VESPER_PHASE_FORCE];
}

const char* AccessName(vesper_access access) {
  switch (access) {
    case VESPER_READ:
      return "read";
    case VESPER_WRITE:
      return "write";
    case VESPER_READ_WRITE:
      return "read-write";
    case VESPER_ACCUMULATE:
      return "accumulate";
    case VESPER_SCRATCH:
      return "scratch";
  }
  return "other";
}

std::vector<std::string> ClaimNames(uint32_t claims) {
  constexpr std::pair<uint32_t, const char*> kClaims[] = {
      {VESPER_CLAIM_MOMENTUM, "momentum"},
      {VESPER_CLAIM_ANGULAR_MOMENTUM, "angular-momentum"},
      {VESPER_CLAIM_TRANSLATION, "translation"},
      {VESPER_CLAIM_ROTATION, "rotation"},
      {VESPER_CLAIM_ENERGY, "energy"}};
  std::vector<std::string> names;
  for (const auto& [claim, name] : kClaims) {
    if ((claims & claim) != 0) names.push_back(name);
  }
  return names;
}

/// Returns the type that both precisions of a law share, e.g. "real x 3" or "u32 x 2".
std::string TypeName(const vesper_property_use& use) {
  const std::string scalar = use.scalar_type <= VESPER_F64 ? "real" : ScalarName(use.scalar_type);
  return use.components == 1 ? scalar : scalar + " x " + std::to_string(use.components);
}

Json Describe(const vesper_law_desc& law) {
  Json properties = Json::array(), parameters = Json::array();
  for (const auto& use : std::span(law.uses, law.use_count)) {
    properties.push_back({{"name", use.name},
                          {"kind", use.kind},
                          {"type", TypeName(use)},
                          {"unit", use.unit.symbol},
                          {"access", AccessName(use.access)},
                          {"optional", (use.flags & VESPER_USE_OPTIONAL) != 0}});
  }
  for (const auto& parameter : std::span(law.parameters, law.parameter_count)) {
    parameters.push_back({{"name", parameter.name},
                          {"unit", parameter.unit.symbol},
                          {"default", parameter.default_value},
                          {"minimum", parameter.minimum},
                          {"maximum", parameter.maximum},
                          {"doc", parameter.doc}});
  }
  return {{"law", law.name},
          {"version", law.version},
          {"doc", law.doc},
          {"phase", PhaseName(law.phase)},
          {"stages", law.stages},
          {"claims", ClaimNames(law.claims)},
          {"potentialEnergy", law.potential_energy != nullptr},
          {"properties", properties},
          {"parameters", parameters}};
}

/// Returns each law of a library once: in double precision, or in single precision if the library
/// contains it in single precision only.
std::vector<const vesper_law_desc*> DistinctLaws(const LawFile& library) {
  std::vector<const vesper_law_desc*> laws = library.Laws(VESPER_F64);
  for (const vesper_law_desc* law : library.Laws(VESPER_F32)) {
    const bool known = std::ranges::any_of(
        laws, [&](const auto* other) { return std::string(other->name) == law->name; });
    if (!known) laws.push_back(law);
  }
  return laws;
}

/// Describes one library: its laws, or the reason why it cannot be loaded.
Json Describe(const std::string& file) {
  Json library{{"file", file}};
  try {
    library["library"] = PreparedLibrary(EngineConfig{}, file).name();
    const LawFile opened(file);
    library["abi"] = std::to_string(opened.table().abi_version >> 16) + "." +
                     std::to_string(opened.table().abi_version & 0xffff);
    library["laws"] = Json::array();
    for (const vesper_law_desc* law : DistinctLaws(opened)) {
      library["laws"].push_back(Describe(*law));
    }
  } catch (const std::exception& error) {
    library["error"] = error.what();
  }
  return library;
}

std::vector<std::string> LibrariesIn(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::filesystem::path& path = entry.path();
    // A compiled law takes precedence over a text of the same name.
    const auto compiled = path.parent_path() / ("libvesper_law_" + path.stem().string() + ".so");
    if (path.extension() == ".so" ||
        (path.extension() == ".law" && !std::filesystem::exists(compiled)))
      files.push_back(entry.path().lexically_normal());
  }
  std::ranges::sort(files);
  for (std::string& file : files) {
    if (file.find('/') == std::string::npos) file.insert(0, "./");
  }
  return files;
}

std::string Number(const Json& number) { return FormatNumber(number.get<double>(), VESPER_F64); }

void PrintLaw(const Json& law) {
  std::string head = law["law"].get<std::string>() + " " + law["version"].get<std::string>() +
                     "  " + law["phase"].get<std::string>();
  if (law["stages"] > 0) head += ", stages: " + std::to_string(law["stages"].get<int>());
  std::cout << "  " << head << "\n    " << law["doc"].get<std::string>() << "\n";
  TextTable table;
  for (const Json& property : law["properties"]) {
    const std::string kind = property["kind"], name = property["name"];
    table.push_back({kind + "." + name, property["type"],
                     "[" + property["unit"].get<std::string>() + "]",
                     property["access"].get<std::string>() +
                         (property["optional"].get<bool>() ? ", optional" : "")});
  }
  Print(std::cout, table, "    ");
  table.clear();
  for (const Json& parameter : law["parameters"]) {
    table.push_back({parameter["name"].get<std::string>() + " = " + Number(parameter["default"]),
                     "[" + parameter["unit"].get<std::string>() + "]",
                     Number(parameter["minimum"]) + " to " + Number(parameter["maximum"]),
                     parameter["doc"]});
  }
  Print(std::cout, table, "    ");
  std::string claims;
  for (const Json& claim : law["claims"]) claims += " " + claim.get<std::string>();
  if (!claims.empty()) std::cout << "    claims:" << claims << "\n";
}

void PrintLibrary(const Json& library) {
  std::cout << library["file"].get<std::string>() << "\n";
  if (library.contains("error")) {
    std::cout << "  cannot be loaded: " << library["error"].get<std::string>() << "\n";
    return;
  }
  for (const Json& law : library["laws"]) PrintLaw(law);
}

}  // namespace

void DescribeLibrary(const std::string& file) {
  const Json library = Describe(file.find('/') == std::string::npos ? "./" + file : file);
  for (const Json& law : library["laws"]) PrintLaw(law);
}

int ListLaws(const LawsOptions& options) {
  Json libraries = Json::array();
  for (const std::string& folder : options.folders) {
    if (!std::filesystem::is_directory(folder)) {
      std::cerr << "vesper: " << folder << ": no such folder\n";
      return kFailed;
    }
    for (const std::string& file : LibrariesIn(folder)) libraries.push_back(Describe(file));
  }
  if (options.json) {
    std::cout << libraries.dump() << "\n";
  } else {
    for (const Json& library : libraries) PrintLibrary(library);
    if (libraries.empty()) std::cerr << "vesper: no law libraries there\n";
  }
  const auto failed = [](const Json& library) { return library.contains("error"); };
  const bool all_loaded = std::ranges::none_of(libraries, failed);
  return all_loaded ? kDone : kNotLoaded;
}

}  // namespace vesper::cli
