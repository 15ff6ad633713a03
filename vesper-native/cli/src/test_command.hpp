// SPDX-License-Identifier: Apache-2.0
// vesper test: checks law libraries against the rules for all laws, and against their claims.
#pragma once

#include <string>
#include <vector>

namespace vesper::cli {

struct TestOptions {
  std::vector<std::string> libraries;  // files
  bool json = false;
};

/// Returns the exit code: 1 if a check failed.
int TestLaws(const TestOptions& options);

}  // namespace vesper::cli
