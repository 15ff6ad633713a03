// SPDX-License-Identifier: Apache-2.0
#include "test_command.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "exit_code.hpp"
#include "text_table.hpp"
#include "vesper/kit/check.hpp"
#include "vesper/kit/law_file.hpp"
#include "vesper/kit/test_prototype.hpp"
#include "vesper/vesper.hpp"
#include "visible.hpp"

namespace vesper::cli {
namespace {

using Json = nlohmann::ordered_json;

const char* NameOf(Verdict verdict) {
  constexpr const char* kNames[] = {"PASS", "FAIL", "skip"};
  return kNames[static_cast<int>(verdict)];
}

const char* PrecisionName(vesper_scalar_type real_type) {
  if (real_type == VESPER_F32) return "f32";
  return real_type == VESPER_F64 ? "f64" : "";
}

struct Result {
  const Check* check;
  vesper_scalar_type real_type;
  CheckOutcome outcome;
};

std::vector<Result> TestLibrary(const std::string& file, const std::vector<std::string>& only) {
  std::vector<Result> results;
  for (const Check& check : Checks()) {
    if (!only.empty() && std::ranges::find(only, check.name) == only.end()) continue;
    const std::vector<vesper_scalar_type> precisions =
        check.per_precision ? std::vector<vesper_scalar_type>{VESPER_F64, VESPER_F32}
                            : std::vector<vesper_scalar_type>{0};
    for (const vesper_scalar_type real_type : precisions) {
      results.push_back({&check, real_type, RunCheck(check, {file, real_type})});
    }
  }
  return results;
}

Json ToJson(const std::vector<Result>& results) {
  Json list = Json::array();
  for (const auto& [check, real_type, outcome] : results) {
    list.push_back({{"check", check->name},
                    {"promise", check->promise},
                    {"precision", PrecisionName(real_type)},
                    {"verdict", NameOf(outcome.verdict)},
                    {"note", outcome.note}});
  }
  return list;
}

void PrintResults(const std::vector<Result>& results) {
  TextTable table;
  for (const auto& [check, real_type, outcome] : results) {
    table.push_back({NameOf(outcome.verdict), check->name, PrecisionName(real_type),
                     outcome.note.empty() ? check->promise
                                          : std::string(check->promise) + ": " + outcome.note});
  }
  Print(std::cout, table, "  ");
}

/// Returns the reason why a library cannot be loaded, or an empty text. Loads it in a separate
/// process first.
std::string ReasonNotLoadable(const std::string& file) {
  if (LawFile::IsPython(file)) {
    const Check load{"load", "can be loaded", false, [](const Subject& subject) {
                       const LawFile opened(subject.file);
                       return std::string();
                     }};
    const CheckOutcome outcome = RunCheck(load, {file, 0});
    return outcome.verdict == Verdict::kPass ? "" : outcome.note;
  }
  try {
    PreparedLibrary(EngineConfig{}, file);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

}  // namespace

std::vector<std::string> CheckNames() {
  std::vector<std::string> names;
  for (const Check& check : Checks()) names.emplace_back(check.name);
  return names;
}

int TestLaws(const TestOptions& options) {
  if (!options.python.empty()) {
    const std::string folder = std::filesystem::absolute(options.python).lexically_normal();
    setenv("VESPER_PYTHON", folder.c_str(), 1);
  }
  if (!options.prototype.empty()) {
    try {
      UseTestPrototype(options.prototype);
    } catch (const std::exception& error) {
      return Fail(kInvalidScene, error.what());
    }
  }
  Json report = Json::array();
  int passed = 0, failed = 0, skipped = 0;
  for (const std::string& library : options.libraries) {
    const std::string file = std::filesystem::absolute(library).lexically_normal();
    if (const std::string reason = ReasonNotLoadable(file); !reason.empty()) {
      std::cerr << "vesper: " << Visible(reason) << "\n";
      return kNotLoaded;
    }
    const std::vector<Result> results = TestLibrary(file, options.only);
    for (const Result& result : results) {
      const Verdict verdict = result.outcome.verdict;
      ++(verdict == Verdict::kPass ? passed : verdict == Verdict::kFail ? failed : skipped);
    }
    report.push_back({{"file", file}, {"checks", ToJson(results)}});
    if (options.json) continue;
    std::cout << library << "\n";
    PrintResults(results);
  }
  if (options.json) {
    std::cout << report.dump() << "\n";
  } else {
    std::cout << passed << " passed, " << failed << " failed, " << skipped << " skipped\n";
  }
  return failed == 0 ? kDone : kFailed;
}

}  // namespace vesper::cli
