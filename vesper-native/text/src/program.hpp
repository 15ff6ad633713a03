// SPDX-License-Identifier: Apache-2.0
// A pass of a law, compiled to instructions on registers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels.hpp"
#include "law_code.hpp"

namespace vesper::text {

inline constexpr uint16_t kNothing = 0xffff;

/// Components of one property of one participant, read at the beginning of a block.
struct LoadGroup {
  uint16_t participant;
  uint16_t property;
  std::array<uint16_t, 4> to{kNothing, kNothing, kNothing, kNothing};  // registers of the
                                                                       // components
  bool written = false;  // the pass also writes the property, so registers need a copy
};

/// Components of one property of one participant, written at the end of a block.
struct ResultGroup {
  uint16_t participant;
  uint16_t property;
  bool add;
  std::array<uint16_t, 4> from{kNothing, kNothing, kNothing, kNothing};  // registers of the
                                                                         // components
};

/// A register that contains the same number in every row.
struct Fill {
  uint16_t to;
  uint16_t from;  // index of its uniform value
};

struct Program {
  std::vector<NodeId> constants;  // uniform values that are computed once per call of the law,
                                  // operands first
  std::vector<NodeId> of_first;   // all pairs: uniform values of the first row of a pair, behind
                                  // the constants
  std::vector<LoadGroup> loads;
  std::vector<LoadGroup> loads_of_first;  // all pairs: loads of the first row; `to` are indices of
                                          // uniform values
  std::vector<Fill> fills;
  std::vector<Instruction> code;
  std::vector<ResultGroup> results;
  uint16_t energy = kNothing;  // register of the energy
  uint16_t within = kNothing;  // index of the uniform value of the distance
  uint16_t registers = 0;

  size_t uniforms() const { return constants.size() + of_first.size(); }
};

/// Compiles the outputs of a pass, or its energy alone.
Program Compile(const LawCode& law, const PassCode& pass, bool energy);

}  // namespace vesper::text
