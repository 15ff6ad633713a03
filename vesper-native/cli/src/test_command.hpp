// SPDX-License-Identifier: Apache-2.0
// vesper test: holds law libraries to what every law promises, and to what they claim.
#pragma once

#include <string>
#include <vector>

namespace vesper::cli {

struct TestOptions {
  std::vector<std::string> libraries;  // files
  bool json = false;
};

/// The exit code: 1 if a check failed.
int TestLaws(const TestOptions& options);

}  // namespace vesper::cli
