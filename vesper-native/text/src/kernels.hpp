// SPDX-License-Identifier: Apache-2.0
// Loops of the evaluator over blocks of rows, compiled for several instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "graph.hpp"

namespace vesper::text {

/// Number of rows in a block. It is so small that all registers of a block fit into the first-level
/// cache.
inline constexpr size_t kBlock = 64;
/// Number of rows behind a block that loops may read and write.
inline constexpr size_t kPadding = 16;

/// One operation on registers. An operand below kUniform is a register; others are indices of
/// uniform values, which are the same for all rows of the block.
struct Instruction {
  Operation operation;
  uint16_t to;
  uint16_t a;
  uint16_t b;
  uint16_t c;
};
inline constexpr uint16_t kUniform = 0x8000;

enum class InstructionSet : uint8_t { kBaseline, kAvx2, kAvx512 };

/// The loops for one instruction set and one type. All sets give the same bits.
template <class Real>
struct Kernels {
  const char* name;
  InstructionSet set;
  /// Executes a program on `count` rows; registers are (kBlock + kPadding) long.
  void (*run)(std::span<const Instruction> program, Real* const* registers, const Real* uniforms,
              size_t count);
  /// Computes an operation for one vector of the instruction set. Machine code calls it for
  /// elementary functions.
  void (*function)(Operation operation, const Real* a, const Real* b, Real* to);
  /// Splits rows of three components into three arrays.
  void (*split3)(const Real* rows, size_t count, Real* x, Real* y, Real* z);
  /// Splits pairs of row numbers into two arrays.
  void (*split_rows)(const uint32_t* pairs, size_t count, uint32_t* first, uint32_t* second);
  /// Joins three arrays to rows of three components. Returns true if all values are finite.
  bool (*join3)(Real* rows, size_t count, const Real* x, const Real* y, const Real* z);
  /// Adds three arrays to rows of three components. Returns true if all results are finite.
  bool (*add3)(Real* rows, size_t count, const Real* x, const Real* y, const Real* z);
  bool (*add1)(Real* rows, size_t count, const Real* x);
  /// Adds three arrays of at most kBlock values to the rows of a column that `rows` names, in
  /// order.
  void (*add3_at)(Real* column, const uint32_t* rows, size_t count, const Real* x, const Real* y,
                  const Real* z);
  /// Returns the sum of values, in an order that is the same for all sets.
  Real (*sum)(Real* values, size_t count);
  /// Returns true if no value is NaN or infinite.
  bool (*finite)(const Real* values, size_t count);
};

/// Returns the loops for the instruction sets that this processor supports, the fastest first.
template <class Real>
const std::vector<Kernels<Real>>& AvailableKernels();

/// Computes one operation in the precision of `Real`, with the same bits as the loops.
template <class Real>
Real ComputeIn(Operation operation, Real a, Real b, Real c);

/// Computes an elementary function with the same bits as the loops.
double Elementary(Operation operation, double a, double b);

}  // namespace vesper::text
