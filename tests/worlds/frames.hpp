// SPDX-License-Identifier: Apache-2.0
// What `vesper run --csv` wrote of a scene with the line `csv position velocity [mass]`.
#pragma once

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "vesper/law.hpp"

namespace vesper {

/// The bodies of one written frame, by row.
struct Frame {
  std::vector<Vec3<double>> position;  // [m]
  std::vector<Vec3<double>> velocity;  // [m/s]
  std::vector<double> mass;            // [kg]; empty if it was not written

  size_t size() const { return position.size(); }
};

/// Returns the frames of a CSV file, in order. Throws std::runtime_error that shows a line which is
/// no frame.
inline std::vector<Frame> ReadFrames(const std::string& csv) {
  std::vector<Frame> frames;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const bool has_mass = line.find("mass") != std::string::npos;
  while (std::getline(lines, line)) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream values(line);
    double frame = 0, time = 0, mass = 0;
    size_t row = 0;
    Vec3<double> x, v;
    values >> frame >> time >> row >> x.x >> x.y >> x.z >> v.x >> v.y >> v.z;
    if (has_mass) values >> mass;
    if (row == 0) frames.emplace_back();
    if (!values || frames.empty() || row != frames.back().size()) {
      throw std::runtime_error("unexpected line: " + line);
    }
    frames.back().position.push_back(x);
    frames.back().velocity.push_back(v);
    if (has_mass) frames.back().mass.push_back(mass);
  }
  return frames;
}

}  // namespace vesper
