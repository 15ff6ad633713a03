// SPDX-License-Identifier: Apache-2.0
#include "law_command.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

#include "exit_code.hpp"
#include "folders.hpp"
#include "laws_command.hpp"
#include "vesper/vesper.hpp"
#include "visible.hpp"

namespace vesper::cli {
namespace {

constexpr size_t kMaxReport = 1 << 16;

std::string ReportOn(const LawOptions& options, const std::string& text) {
  std::vector<char> report(kMaxReport);
  vesper_error error{};
  const vesper_status status =
      vesper_text_check(&StandardPrototype(options.prototype), options.file.c_str(), text.data(),
                        text.size(), report.data(), report.size(), &error);
  if (status != VESPER_OK) throw std::runtime_error(error.message);
  return report.data();
}

std::string CppOf(const LawOptions& options, const std::string& text) {
  const vesper_prototype& prototype = StandardPrototype(options.prototype);
  std::string cpp(size_t{1} << 16, '\0');
  uint64_t length = 0;
  vesper_error error{};
  const auto write = [&] {
    return vesper_text_to_cpp(&prototype, options.file.c_str(), text.data(), text.size(),
                              cpp.data(), cpp.size(), &length, &error);
  };
  vesper_status status = write();
  if (status == VESPER_INVALID_ARGUMENT && length >= cpp.size()) {
    cpp.resize(length + 1);
    status = write();
  }
  if (status != VESPER_OK) throw std::runtime_error(error.message);
  cpp.resize(length);
  return cpp;
}

void PrintProblems(const LawOptions& options, const std::string& report) {
  std::cerr << Visible(report) << "checked without a world, against the standard prototype "
            << options.prototype
            << "; if a world declares kinds or properties for this law, check the world: reve check"
               " WORLD\n";
}

}  // namespace

int CheckLaw(const LawOptions& options) {
  const std::string report = ReportOn(options, ReadFile(options.file));
  if (options.json) {
    std::cout << nlohmann::ordered_json{{"file", options.file}, {"problems", report}}.dump()
              << "\n";
  } else if (report.empty()) {
    std::cout << options.file << ": right\n";
    if (options.file.ends_with(".law")) DescribeLibrary(options.file);
  } else {
    PrintProblems(options, report);
  }
  return report.empty() ? kDone : kFailed;
}

int LawToCpp(const LawOptions& options) {
  const std::string text = ReadFile(options.file);
  if (const std::string report = ReportOn(options, text); !report.empty()) {
    PrintProblems(options, report);
    return kFailed;
  }
  const std::string cpp = CppOf(options, text);
  if (options.output.empty()) {
    std::cout << cpp;
    return kDone;
  }
  if (!MayReplace(options.output, "// Written by `vesper law to-cpp`")) {
    return Fail(kFailed, options.output + kNotReplaced);
  }
  std::ofstream file(options.output, std::ios::binary);
  file << cpp;
  file.close();
  if (file) return kDone;
  return Fail(kFailed, options.output + ": cannot be written: " + std::strerror(errno));
}

}  // namespace vesper::cli
