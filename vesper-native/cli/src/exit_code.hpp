// SPDX-License-Identifier: Apache-2.0
// Exit codes of the commands; docs/command-line.md contains the same table.
#pragma once

#include <iostream>
#include <string>

#include "visible.hpp"

namespace vesper::cli {

inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;
inline constexpr int kInvalidScene = 3;
inline constexpr int kNotLoaded = 4;  // a law or the renderer could not be loaded

/// Writes an error message to standard error and returns the exit code of the command.
inline int Fail(int code, const std::string& message) {
  std::cerr << "vesper: " << Visible(message) << "\n";
  return code;
}

}  // namespace vesper::cli
