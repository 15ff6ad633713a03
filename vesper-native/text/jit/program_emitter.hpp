// SPDX-License-Identifier: Apache-2.0
// Emits the instructions of a program for one vector of rows.
#pragma once

#include <functional>
#include <vector>

#include "program.hpp"
#include "vector_assembler.hpp"

namespace vesper::text {

class ProgramEmitter {
 public:
  using Vec = VectorAssembler::Vec;
  using Gp = VectorAssembler::Gp;

  /// Creates an emitter. `uniforms` is a register with the address of the uniform values, valid in
  /// the whole function.
  ProgramEmitter(VectorAssembler& vectors, const Program& program, const Gp& uniforms);

  /// Loads the uniform values that most operations use, before a loop.
  void LoadUniforms();
  /// Emits the values of the first row of a pair that depend on its columns, before a loop.
  void ComputeOfFirst(const Graph& graph);
  /// Emits all operations for one vector. `load` returns the value of a register of the program
  /// that no instruction computes. `store` receives each register of a result, with its value.
  void Emit(const std::function<Vec(uint16_t)>& load,
            const std::function<void(uint16_t, const Vec&)>& store);
  /// Begins one vector whose operations EmitOperation emits one by one. The operations of several
  /// emitters can alternate, so that the processor need not wait for one before the next.
  void Begin(const std::function<Vec(uint16_t)>& load);
  /// Emits the operation with an index of the program's code, without storing its result. The last
  /// value of registers in `skipped` is not computed.
  void EmitOperation(size_t index, const std::vector<bool>& skipped);
  /// Returns the numbers of a register after all operations are emitted.
  Vec Result(uint16_t of);
  /// Returns the register whose negative the register `of` contains at the end. Returns kNothing if
  /// there is no such register, or if another operation uses the negative.
  uint16_t NegativeOf(uint16_t of) const;

 private:
  VectorValue& ValueOf(uint16_t operand);

  VectorAssembler& vectors_;
  const Program& program_;
  const Gp uniforms_;
  std::vector<VectorValue> before_;   // uniform values that are loaded before the loop
  std::vector<VectorValue> uniform_;  // those of the vector that is being emitted
  std::vector<VectorValue> registers_;
  std::vector<size_t> last_;  // for each register, the last operation that computes it
  std::function<Vec(uint16_t)> load_;
};

}  // namespace vesper::text
