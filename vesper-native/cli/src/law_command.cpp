// SPDX-License-Identifier: Apache-2.0
#include "law_command.hpp"

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

#include "exit_code.hpp"
#include "folders.hpp"
#include "laws_command.hpp"
#include "vesper/vesper.hpp"

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
    std::cerr << report;
  }
  return report.empty() ? kDone : kFailed;
}

}  // namespace vesper::cli
