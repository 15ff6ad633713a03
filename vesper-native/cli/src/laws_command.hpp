// SPDX-License-Identifier: Apache-2.0
// vesper laws: lists the law libraries in folders.
#pragma once

#include <string>
#include <vector>

namespace vesper::cli {

struct LawsOptions {
  std::vector<std::string> folders;
  bool json = false;
};

/// Prints the laws of one library.
void DescribeLibrary(const std::string& file);

/// Returns the exit code. A library that cannot be loaded is listed with the reason.
int ListLaws(const LawsOptions& options);

}  // namespace vesper::cli
