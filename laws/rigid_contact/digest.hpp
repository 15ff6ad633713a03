// SPDX-License-Identifier: Apache-2.0
// A number that represents the values of columns.
#pragma once

#include <bit>
#include <cstdint>

#include "rigid/rotation.hpp"

namespace vesper::rigid {

/** A number that represents a sequence of values. Equal sequences have equal numbers, also in
 * another process. */
class Digest {
 public:
  Digest& Add(uint64_t word) {
    value_ = (value_ ^ word) * 0x9E3779B97F4A7C15u;
    value_ ^= value_ >> 29;
    return *this;
  }
  Digest& Add(double number) { return Add(std::bit_cast<uint64_t>(number + 0.0)); }  // -0 is 0
  Digest& Add(const Vector& v) { return Add(v.x).Add(v.y).Add(v.z); }
  Digest& Add(const Quaternion& q) { return Add(q.v).Add(q.w); }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0x2545F4914F6CDD1Du;
};

}  // namespace vesper::rigid
