// SPDX-License-Identifier: Apache-2.0
// Machine code of the programs of laws as text. It computes the same bits as the evaluator, which
// executes programs without machine code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "code_memory.hpp"
#include "kernels.hpp"
#include "law_code.hpp"
#include "program.hpp"

namespace vesper::text {

/// The rows of a pass, and the columns of its groups of loads and results. No column is absent.
template <class Real>
struct RowsOfPass {
  const Real* const* loads;
  Real* const* results;
  const Real* uniforms;
  uint64_t begin;
  uint64_t end;
};

/// A block of rows that refer to other rows, or of pairs.
template <class Real>
struct GatheredBlock {
  Real* const* registers;
  const Real* uniforms;
  uint64_t count;
  const Real* const* columns;   // columns of the groups of loads; no column is absent
  const uint32_t* const* rows;  // kBlock rows of each participant
};

/// All pairs of one row and later rows.
template <class Real>
struct PairsOfRow {
  const Real* const* second;  // columns of the second rows: 4 for each group of loads
  Real* const* sums;          // sums of each row: 4 for each group of results
  const Real* uniforms;       // values of the first row are filled only for its loads
  uint64_t first;
  uint64_t rows;
};

/// The functions of one program.
template <class Real>
struct MachineCode {
  /// Executes the program like Kernels::run.
  void (*run)(Real* const* registers, const Real* uniforms, size_t count) = nullptr;
  /// Evaluates rows, and stores or adds their results. Returns the row before which it stops. It
  /// stops if the remaining rows do not fill a vector. It also stops if a row of the next vector
  /// may have a result that is NaN or infinite.
  uint64_t (*rows)(const RowsOfPass<Real>* of) = nullptr;
  /// Executes the program like `run`. This function itself loads the columns of other rows, so the
  /// caller does not fill their registers.
  void (*gather)(const GatheredBlock<Real>* of) = nullptr;
  /// Evaluates one row with all later rows, and adds the results to the sums. Returns 0 if a result
  /// may be NaN or infinite. Only for passes over all pairs.
  uint64_t (*pairs)(const PairsOfRow<Real>* of) = nullptr;
  CodeMemory memory;
  std::string reason;  // why there are no functions
};

/// Compiles a program for the instruction set of `kernels`.
template <class Real>
MachineCode<Real> Generate(const LawCode& law, const PassCode& pass, const Program& program,
                           const Kernels<Real>& kernels);

/// Returns the reason why laws as text have no machine code on this machine, or an empty text if
/// they have machine code. `wanted` is the value of the environment variable
/// VESPER_TEXT_MACHINE_CODE, or null; the value 0 selects the evaluator.
std::string FindWhyNoMachineCode(const char* wanted);

/// Returns the result of FindWhyNoMachineCode for the environment of this process.
const std::string& WhyNoMachineCode();

}  // namespace vesper::text
