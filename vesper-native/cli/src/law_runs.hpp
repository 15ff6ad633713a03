// SPDX-License-Identifier: Apache-2.0
// vesper law run and vesper law plot: what a law does in a small scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vesper/vesper.hpp"

namespace vesper::cli {

struct LawRunOptions {
  std::string file;
  std::vector<std::string> parameters;  // NAME=VALUE
  std::vector<std::string> properties;  // NAME=VALUE or NAME=X,Y,Z
  double seconds = 5;
  double dt = 0.001;  // [s]
  uint64_t bodies = 27;
  uint64_t rows = 6;  // times at which energy and momentum are reported
  bool json = false;
};

/// Runs a scene with the law, prints how energy and momentum change, and returns the exit code.
int RunLaw(const LawRunOptions& options);

struct LawPlotOptions {
  std::string file;
  std::vector<std::string> parameters;  // NAME=VALUE
  std::vector<std::string> properties;  // NAME=VALUE or NAME=X,Y,Z
  std::string over;                // distance, speed or place; empty: what the force depends on
  std::optional<double> from, to;  // [m] or [m/s]
  uint32_t points = 201;
  bool json = false;
};

/// Prints force and energy of a law over a distance, a speed or a place, and returns the exit code.
int PlotLaw(const LawPlotOptions& options);

}  // namespace vesper::cli
