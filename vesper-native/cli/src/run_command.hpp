// SPDX-License-Identifier: Apache-2.0
// vesper run: applies the laws of a scene, frame by frame.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "picture.hpp"

namespace vesper::cli {

struct RunOptions {
  std::string scene;
  uint64_t frames = 60;
  uint64_t every = 1;                 // interval of written frames
  std::string csv;                    // path; empty: none
  std::optional<PicturePattern> png;  // none: no pictures
  std::vector<std::string> law_folders;
  uint32_t threads = 1;
  bool validate = false;
  bool ledger = false;
  bool trusted = false;  // whether the scene may name files by any path
  bool json = false;
};

/// Returns the exit code. Results go to standard output, messages to standard error.
int Run(const RunOptions& options);

}  // namespace vesper::cli
