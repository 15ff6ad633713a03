// SPDX-License-Identifier: Apache-2.0
// vesper laws: what is in folders of law libraries.
#pragma once

#include <string>
#include <vector>

namespace vesper::cli {

struct LawsOptions {
  std::vector<std::string> folders;
  bool json = false;
};

/// The exit code. A library that cannot be loaded is listed with the reason.
int ListLaws(const LawsOptions& options);

}  // namespace vesper::cli
