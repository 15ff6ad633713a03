// SPDX-License-Identifier: Apache-2.0
#include "block_code.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "interleave.hpp"
#include "machine_code.hpp"

namespace vesper::text {
namespace {

using namespace asmjit;

class BlockCode {
 public:
  BlockCode(VectorAssembler& vectors, const Program& program)
      : vectors_(vectors), code_(vectors.code()), program_(program) {}

  /// Emits the function and returns its label. `law` is null unless the function itself loads the
  /// columns of other rows.
  Label Emit(const LawCode* law) {
    FuncNode* function = nullptr;
    x86::Gp uniforms = code_.newUIntPtr();
    registers_ = code_.newUIntPtr();
    count_ = code_.newUIntPtr();
    if (law == nullptr) {
      function = code_.addFunc(FuncSignatureT<void, void*, void*, size_t>());
      vectors_.Begin(function, {registers_, uniforms, count_});
    } else {
      function = code_.addFunc(FuncSignatureT<void, void*>());
      const x86::Gp of = code_.newUIntPtr();
      vectors_.Begin(function, {of});
      Field(registers_, of, offsetof(GatheredBlock<double>, registers));
      Field(uniforms, of, offsetof(GatheredBlock<double>, uniforms));
      Field(count_, of, offsetof(GatheredBlock<double>, count));
      columns_ = code_.newUIntPtr();
      rows_ = code_.newUIntPtr();
      Field(columns_, of, offsetof(GatheredBlock<double>, columns));
      Field(rows_, of, offsetof(GatheredBlock<double>, rows));
    }
    ProgramEmitter emitter(vectors_, program_, uniforms);
    emitter.LoadUniforms();
    if (law != nullptr && GathersTriples(*law)) masks_ = MakePlaceMasks(vectors_);
    at_ = code_.newUIntPtr();
    code_.xor_(at_, at_);
    const Label again = code_.newLabel();
    code_.bind(again);
    gathered_.clear();
    emitter.Emit(
        [&](uint16_t of) { return law == nullptr ? vectors_.Load(Register(of)) : Load(*law, of); },
        [&](uint16_t of, const x86::Vec& value) { vectors_.Store(Register(of), value); });
    if (law != nullptr) StoreLoads(emitter);
    code_.add(at_, vectors_.lanes());
    code_.cmp(at_, count_);
    code_.jb(again);
    code_.endFunc();
    return function->label();
  }

 private:
  void Field(const x86::Gp& to, const x86::Gp& of, size_t offset) {
    code_.mov(to, x86::ptr(of, static_cast<int32_t>(offset)));
  }

  uint32_t Shift() const { return vectors_.number_bytes() == 8 ? 3 : 2; }

  /// Returns the memory of the current rows in a register (an array of numbers) of the program.
  x86::Mem Register(uint16_t of) {
    const x86::Gp base = code_.newUIntPtr();
    code_.mov(base, x86::ptr(registers_, of * 8));
    return x86::ptr(base, at_, Shift());
  }

  struct Source {
    size_t group;
    uint32_t component;
  };

  /// Returns the source from which the function itself loads a register. Returns nothing if the
  /// caller fills the register.
  std::optional<Source> SourceOf(uint16_t to) const {
    for (size_t g = 0; g < program_.loads.size(); ++g) {
      const LoadGroup& group = program_.loads[g];
      for (uint32_t k = 0; k < 4; ++k) {
        if (group.to[k] == to && group.participant != kOwnRow) return Source{g, k};
      }
    }
    return std::nullopt;
  }

  x86::Vec Load(const LawCode& law, uint16_t to) {
    const std::optional<Source> source = SourceOf(to);
    if (!source) return vectors_.Load(Register(to));
    const LoadGroup& group = program_.loads[source->group];
    return Gather(group, source->group, law.properties[group.property].components,
                  source->component);
  }

  /// Stores those results that are columns of other rows, because nothing has filled their
  /// registers. Does not store columns of the row itself, because their registers may be the
  /// columns of the world, which this function must not write.
  void StoreLoads(ProgramEmitter& emitter) {
    std::vector<uint16_t> results{program_.energy};
    for (const ResultGroup& group : program_.results) {
      results.insert(results.end(), group.from.begin(), group.from.end());
    }
    for (const uint16_t of : results) {
      if (of != kNothing && SourceOf(of)) vectors_.Store(Register(of), emitter.Result(of));
    }
  }

  bool GathersTriples(const LawCode& law) const {
    return std::ranges::any_of(program_.loads, [&](const LoadGroup& group) {
      return group.participant != kOwnRow && law.properties[group.property].components == 3;
    });
  }

  /// Loads a component of a column at the rows of a participant.
  x86::Vec Gather(const LoadGroup& group, size_t index, uint32_t components, uint32_t component) {
    const auto found = gathered_.find(index);
    if (found != gathered_.end()) return found->second[component];
    const x86::Gp base = code_.newUIntPtr(), rows = code_.newUIntPtr();
    code_.mov(base, x86::ptr(columns_, static_cast<int32_t>(8 * index)));
    code_.mov(rows, x86::ptr(rows_, 8 * (group.participant - kFirst)));
    const uint32_t first = components == 3 ? 0 : component;
    const auto address_of = [&](uint32_t i) {
      const x86::Gp row = code_.newUIntPtr();
      code_.mov(row.r32(), x86::ptr(rows, at_, 2, static_cast<int32_t>(4 * i)));
      if (components == 3) {
        code_.lea(row, x86::ptr(row, row, 1));
      } else if (components != 1) {
        code_.imul(row, row, components);
      }
      return x86::ptr(base, row, Shift(), static_cast<int32_t>(first * vectors_.number_bytes()));
    };
    if (components != 3) return GatherNumbers(vectors_, address_of);
    return (gathered_[index] = GatherRows(vectors_, masks_, address_of))[component];
  }

  VectorAssembler& vectors_;
  x86::Compiler& code_;
  const Program& program_;
  x86::Gp registers_, count_, at_, columns_, rows_;
  PlaceMasks masks_;
  std::map<size_t, VectorTriple> gathered_;  // columns of three components, by group
};

}  // namespace

Label EmitRun(VectorAssembler& vectors, const Program& program) {
  return BlockCode(vectors, program).Emit(nullptr);
}

Label EmitGather(VectorAssembler& vectors, const LawCode& law, const Program& program) {
  return BlockCode(vectors, program).Emit(&law);
}

}  // namespace vesper::text
