// SPDX-License-Identifier: Apache-2.0
// Failures of checks.
#pragma once

#include <stdexcept>
#include <string>

namespace vesper {

class CheckFailed : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Thrown if the check does not apply to the law.
class CheckSkipped : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline void Expect(bool condition, const std::string& otherwise) {
  if (!condition) throw CheckFailed(otherwise);
}

}  // namespace vesper
