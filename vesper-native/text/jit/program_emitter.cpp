// SPDX-License-Identifier: Apache-2.0
#include "program_emitter.hpp"

#include <algorithm>

namespace vesper::text {

ProgramEmitter::ProgramEmitter(VectorAssembler& vectors, const Program& program, const Gp& uniforms)
    : vectors_(vectors),
      program_(program),
      uniforms_(uniforms),
      before_(program.uniforms()),
      registers_(program.registers),
      last_(program.registers) {
  for (size_t i = 0; i < program.code.size(); ++i) last_[program.code[i].to] = i;
}

void ProgramEmitter::LoadUniforms() {
  std::vector<uint32_t> uses(before_.size());
  for (const Instruction& step : program_.code) {
    for (const uint16_t operand : {step.a, step.b, step.c}) {
      if (operand >= kUniform && operand != kNothing) ++uses[operand - kUniform];
    }
  }
  // Values are loaded into at most half of the vector registers, because asmjit would move further
  // values to the stack.
  size_t room = vectors_.vector_registers() / 2;
  for (size_t i = 0; i < uses.size() && room > 0; ++i) {
    if (uses[i] == 0 || before_[i].number) continue;
    before_[i].number = vectors_.Broadcast(
        asmjit::x86::ptr(uniforms_, static_cast<int32_t>(i * vectors_.number_bytes())));
    --room;
  }
}

void ProgramEmitter::ComputeOfFirst(const Graph& graph) {
  const size_t constants = program_.constants.size();
  const auto find = [&](const std::vector<NodeId>& list, size_t offset, NodeId id) -> VectorValue* {
    const auto at = std::lower_bound(list.begin(), list.end(), id);
    if (at == list.end() || *at != id) return nullptr;
    return &ValueOf(static_cast<uint16_t>(kUniform + offset + (at - list.begin())));
  };
  const auto value_of = [&](NodeId id) -> VectorValue* {
    if (id == kNoNode) return nullptr;
    VectorValue* constant = find(program_.constants, 0, id);
    return constant != nullptr ? constant : find(program_.of_first, constants, id);
  };
  uniform_ = before_;
  for (size_t i = 0; i < program_.of_first.size(); ++i) {
    const Node& node = graph[program_.of_first[i]];
    if (node.operation == Operation::kLoad) continue;
    VectorValue value =
        vectors_.Compute(node.operation, value_of(node.a), value_of(node.b), value_of(node.c));
    uniform_[constants + i].number = before_[constants + i].number = vectors_.Number(value);
  }
}

VectorValue& ProgramEmitter::ValueOf(uint16_t operand) {
  if (operand >= kUniform) {
    VectorValue& value = uniform_[operand - kUniform];
    if (!value.number) {
      value.number = vectors_.Broadcast(asmjit::x86::ptr(
          uniforms_, static_cast<int32_t>((operand - kUniform) * vectors_.number_bytes())));
    }
    return value;
  }
  VectorValue& value = registers_[operand];
  if (value.number || value.mask) return value;
  for (const Fill& fill : program_.fills) {
    if (fill.to == operand) return value = ValueOf(kUniform + fill.from);
  }
  value.number = load_(operand);
  return value;
}

void ProgramEmitter::Begin(const std::function<Vec(uint16_t)>& load) {
  load_ = load;
  uniform_ = before_;
  registers_.assign(registers_.size(), {});
}

void ProgramEmitter::EmitOperation(size_t index, const std::vector<bool>& skipped) {
  const Instruction& step = program_.code[index];
  if (skipped[step.to] && last_[step.to] == index) return;
  const auto operand = [&](uint16_t of) { return of == kNothing ? nullptr : &ValueOf(of); };
  VectorValue value =
      vectors_.Compute(step.operation, operand(step.a), operand(step.b), operand(step.c));
  registers_[step.to] = value;
}

void ProgramEmitter::Emit(const std::function<Vec(uint16_t)>& load,
                          const std::function<void(uint16_t, const Vec&)>& store) {
  Begin(load);
  std::vector<bool> kept(registers_.size());
  for (const ResultGroup& group : program_.results) {
    for (const uint16_t from : group.from) {
      if (from != kNothing) kept[from] = true;
    }
  }
  if (program_.energy != kNothing) kept[program_.energy] = true;
  const std::vector<bool> none(registers_.size());
  for (size_t i = 0; i < program_.code.size(); ++i) {
    EmitOperation(i, none);
    const uint16_t to = program_.code[i].to;
    if (kept[to] && last_[to] == i) store(to, vectors_.Number(registers_[to]));
  }
}

ProgramEmitter::Vec ProgramEmitter::Result(uint16_t of) { return vectors_.Number(ValueOf(of)); }

uint16_t ProgramEmitter::NegativeOf(uint16_t of) const {
  for (size_t i = program_.code.size(); i-- > 0;) {
    const Instruction& step = program_.code[i];
    if (step.to == of) {
      const bool negates = step.operation == Operation::kNegate && last_[step.a] <= i;
      return negates ? step.a : kNothing;
    }
    if (step.a == of || step.b == of || step.c == of) return kNothing;
  }
  return kNothing;
}

}  // namespace vesper::text
