// SPDX-License-Identifier: Apache-2.0
// A pass of a law as instructions on registers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels.hpp"
#include "law_code.hpp"

namespace vesper::text {

inline constexpr uint16_t kNothing = 0xffff;

/// Components of one property of one participant, read at the begin of a block.
struct LoadGroup {
  uint16_t participant;
  uint16_t property;
  std::array<uint16_t, 4> to{kNothing, kNothing, kNothing, kNothing};  // registers
  bool written = false;  // the pass writes the property too, so registers need a copy
};

/// Components of one property of one participant, written at the end of a block.
struct ResultGroup {
  uint16_t participant;
  uint16_t property;
  bool add;
  std::array<uint16_t, 4> from{kNothing, kNothing, kNothing, kNothing};  // registers
};

/// A register that contains the same number in every row.
struct Fill {
  uint16_t to;
  uint16_t from;  // index of the uniform value
};

struct Program {
  std::vector<NodeId> constants;  // uniform values of a call of the law, operands first
  std::vector<NodeId> of_first;   // all pairs: values of the first of a pair, after the constants
  std::vector<LoadGroup> loads;
  std::vector<LoadGroup> loads_of_first;  // all pairs: `to` are indices of uniform values
  std::vector<Fill> fills;
  std::vector<Instruction> code;
  std::vector<ResultGroup> results;
  uint16_t energy = kNothing;  // register
  uint16_t within = kNothing;  // index of the uniform value
  uint16_t registers = 0;

  size_t uniforms() const { return constants.size() + of_first.size(); }
};

/// Compiles the outputs of a pass, or its energy alone.
Program Compile(const LawCode& law, const PassCode& pass, bool energy);

}  // namespace vesper::text
