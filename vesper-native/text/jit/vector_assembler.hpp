// SPDX-License-Identifier: Apache-2.0
// Vector instructions of one instruction set for one precision. asmjit assigns the registers.
#pragma once

#include <asmjit/x86.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>

#include "graph.hpp"

namespace vesper::text {

/// An operand of an operation: one number per row. A condition also exists as a mask.
struct VectorValue {
  std::optional<asmjit::x86::Vec> number;
  /// AVX-512: a mask register; AVX2: a vector whose bits are all 1 in rows that meet the condition.
  std::optional<asmjit::BaseReg> mask;
};

class VectorAssembler {
 public:
  using Vec = asmjit::x86::Vec;
  using Mem = asmjit::x86::Mem;
  using Gp = asmjit::x86::Gp;
  using Mask = asmjit::BaseReg;
  /// The names of an instruction: for f64 and for f32.
  struct Names {
    asmjit::InstId f64;
    asmjit::InstId f32;
  };

  /// `function`: address of Kernels::function.
  VectorAssembler(asmjit::x86::Compiler& code, bool is_avx512, bool is_f64, const void* function)
      : code_(code), is_avx512_(is_avx512), is_f64_(is_f64), function_(function) {}

  asmjit::x86::Compiler& code() { return code_; }
  uint32_t vector_bytes() const { return is_avx512_ ? 64 : 32; }
  uint32_t number_bytes() const { return is_f64_ ? 8 : 4; }
  uint32_t lanes() const { return vector_bytes() / number_bytes(); }
  uint32_t vector_registers() const { return is_avx512_ ? 32 : 16; }

  /// Begins a function with these arguments.
  void Begin(asmjit::FuncNode* function, std::initializer_list<Gp> arguments);

  Vec NewVector();
  Vec Load(const Mem& from);
  void Store(const Mem& to, const Vec& value);
  Vec Broadcast(const Mem& from);
  Vec Zero();
  /// Returns memory that contains the same number in all rows of a vector.
  Mem Same(double number);
  Vec Binary(Names names, const Vec& a, const asmjit::Operand_& b);
  Vec Add(const Vec& a, const asmjit::Operand_& b);
  Vec Subtract(const Vec& a, const asmjit::Operand_& b);
  void AddTo(const Vec& sum, const Vec& value);
  void SubtractFrom(const Vec& sum, const Vec& value);
  /// Adds the first number of a vector to a number in memory.
  void AddOneTo(const Mem& sum, const Vec& value);
  /// Sets `to` to 1 if all numbers of a vector of 0 and NaN are 0, or to 0.
  void SetIfZero(const Gp& to, const Vec& value);
  /// Jumps if a number of a vector is NaN.
  void JumpIfNan(const Vec& value, const asmjit::Label& to);
  /// Returns the sum of the two halves of a vector of `bytes`. Repeated for the halves, it gives
  /// the sum of all numbers.
  Vec AddHalves(const Vec& value, uint32_t bytes);
  /// Returns the vector with 0 in the rows in which a mask in memory has no bits.
  Vec KeepWhere(const Vec& value, const Mem& mask);

  /// Emits one operation, which gives the same bits as the evaluator.
  VectorValue Compute(Operation operation, VectorValue* a, VectorValue* b, VectorValue* c);
  /// Returns the operand as numbers.
  Vec Number(VectorValue& value);

 private:
  Vec Emit(Names names, const asmjit::Operand_& a, const asmjit::Operand_& b);
  Vec Sign(Operation operation, const Vec& a);
  Vec Floor(const Vec& a);
  VectorValue Compare(asmjit::x86::VCmpImm predicate, const Vec& a, const Vec& b);
  VectorValue Join(Operation operation, VectorValue& a, VectorValue& b);
  Vec Select(VectorValue& condition, VectorValue& a, VectorValue& b);
  Mask MaskOf(VectorValue& value);
  Vec Call(Operation operation, const Vec& a, const Vec* b);
  Mem Bits(uint64_t f64, uint32_t f32);

  asmjit::x86::Compiler& code_;
  const bool is_avx512_;
  const bool is_f64_;
  const void* const function_;
  std::optional<std::array<Mem, 3>> arguments_;  // memory on the stack for arguments of calls
};

}  // namespace vesper::text
