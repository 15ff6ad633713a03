// SPDX-License-Identifier: Apache-2.0
// How checks fail.
#pragma once

#include <stdexcept>
#include <string>

namespace vesper {

class CheckFailed : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The law has nothing that the check is about.
class CheckSkipped : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline void Expect(bool condition, const std::string& otherwise) {
  if (!condition) throw CheckFailed(otherwise);
}

}  // namespace vesper
