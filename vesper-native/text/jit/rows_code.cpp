// SPDX-License-Identifier: Apache-2.0
#include "rows_code.hpp"

#include <array>
#include <cstddef>
#include <map>

#include "interleave.hpp"
#include "machine_code.hpp"

namespace vesper::text {
namespace {

using namespace asmjit;

class RowsCode {
 public:
  RowsCode(VectorAssembler& vectors, const LawCode& law, const Program& program)
      : vectors_(vectors), code_(vectors.code()), law_(law), program_(program) {}

  Label Emit() {
    FuncNode* function = code_.addFunc(FuncSignatureT<uint64_t, void*>());
    const x86::Gp of = code_.newUIntPtr();
    vectors_.Begin(function, {of});
    const auto field = [&](size_t offset) {
      const x86::Gp to = code_.newUIntPtr();
      code_.mov(to, x86::ptr(of, static_cast<int32_t>(offset)));
      return to;
    };
    loads_ = field(offsetof(RowsOfPass<double>, loads));
    results_ = field(offsetof(RowsOfPass<double>, results));
    const x86::Gp row = field(offsetof(RowsOfPass<double>, begin));
    const x86::Gp end = field(offsetof(RowsOfPass<double>, end));
    const x86::Gp behind = code_.newUIntPtr();
    ProgramEmitter emitter(vectors_, program_, field(offsetof(RowsOfPass<double>, uniforms)));
    emitter.LoadUniforms();
    at_ = code_.newUIntPtr();
    at3_ = code_.newUIntPtr();
    code_.imul(at_, row, vectors_.number_bytes());
    code_.lea(at3_, x86::ptr(at_, at_, 1));
    const Label again = code_.newLabel(), done = code_.newLabel();
    code_.bind(again);
    code_.lea(behind, x86::ptr(row, static_cast<int32_t>(vectors_.lanes())));
    code_.cmp(behind, end);
    code_.ja(done);
    split_.clear();
    emitter.Emit([&](uint16_t of_load) { return Load(of_load); }, [](uint16_t, const x86::Vec&) {});
    StoreResults(emitter, done);
    code_.mov(row, behind);
    code_.add(at_, vectors_.vector_bytes());
    code_.add(at3_, 3 * vectors_.vector_bytes());
    code_.jmp(again);
    code_.bind(done);
    code_.ret(row);
    code_.endFunc();
    return function->label();
  }

 private:
  uint32_t ComponentsOf(uint16_t property) const { return law_.properties[property].components; }

  /// Returns the memory of the current rows in a column of one or three components.
  x86::Mem Rows(const x86::Gp& table, size_t group, uint32_t components, uint32_t vector) {
    const x86::Gp base = code_.newUIntPtr();
    code_.mov(base, x86::ptr(table, static_cast<int32_t>(8 * group)));
    return x86::ptr(base, components == 1 ? at_ : at3_, 0,
                    static_cast<int32_t>(vector * vectors_.vector_bytes()));
  }

  VectorTriple LoadThree(const x86::Gp& table, size_t group) {
    VectorTriple memory;
    for (uint32_t i = 0; i < 3; ++i) memory[i] = vectors_.Load(Rows(table, group, 3, i));
    return memory;
  }

  x86::Vec Load(uint16_t to) {
    for (size_t g = 0; g < program_.loads.size(); ++g) {
      const LoadGroup& group = program_.loads[g];
      for (size_t k = 0; k < 4; ++k) {
        if (group.to[k] != to) continue;
        if (ComponentsOf(group.property) == 1) return vectors_.Load(Rows(loads_, g, 1, 0));
        const auto found = split_.find(g);
        if (found != split_.end()) return found->second[k];
        return (split_[g] = SplitRows(vectors_, LoadThree(loads_, g)))[k];
      }
    }
    throw NoMachineCode{"a register has no value"};
  }

  /// Stores the results of the current rows. If one of them is NaN or infinite, jumps to `stop`
  /// instead.
  void StoreResults(ProgramEmitter& emitter, const Label& stop) {
    struct Stored {
      x86::Mem to;
      x86::Vec value;
    };
    std::vector<Stored> all;
    for (size_t g = 0; g < program_.results.size(); ++g) {
      const ResultGroup& group = program_.results[g];
      if (ComponentsOf(group.property) == 1) {
        const x86::Mem to = Rows(results_, g, 1, 0);
        const x86::Vec value = emitter.Result(group.from[0]);
        all.push_back({to, group.add ? vectors_.Add(value, to) : value});
        continue;
      }
      const VectorTriple values = Three(emitter, group, g);
      for (uint32_t i = 0; i < 3; ++i) {
        const x86::Mem to = Rows(results_, g, 3, i);
        all.push_back({to, group.add ? vectors_.Add(values[i], to) : values[i]});
      }
    }
    const x86::Vec watch = vectors_.NewVector();
    for (size_t i = 0; i < all.size(); ++i) {
      const x86::Vec difference = vectors_.Subtract(all[i].value, all[i].value);
      if (i == 0) {
        code_.vmovaps(watch, difference);
      } else {
        vectors_.AddTo(watch, difference);
      }
    }
    vectors_.JumpIfNan(watch, stop);
    for (const Stored& each : all) vectors_.Store(each.to, each.value);
  }

  /// Returns the components of a result in the order of memory. Components without a result must
  /// keep their values. If the result is added, such a component is -0, which changes no number to
  /// which it is added. If the result is stored, it is the value of the column.
  VectorTriple Three(ProgramEmitter& emitter, const ResultGroup& group, size_t index) {
    const bool whole =
        group.from[0] != kNothing && group.from[1] != kNothing && group.from[2] != kNothing;
    VectorTriple values;
    if (!whole && !group.add) values = SplitRows(vectors_, LoadThree(results_, index));
    for (size_t k = 0; k < 3; ++k) {
      if (group.from[k] != kNothing) {
        values[k] = emitter.Result(group.from[k]);
      } else if (group.add) {
        values[k] = vectors_.Load(vectors_.Same(-0.0));
      }
    }
    return JoinRows(vectors_, values);
  }

  VectorAssembler& vectors_;
  x86::Compiler& code_;
  const LawCode& law_;
  const Program& program_;
  x86::Gp loads_, results_;  // tables of columns
  x86::Gp at_, at3_;         // bytes before the current rows, in columns of 1 and 3 components
  std::map<size_t, VectorTriple> split_;  // loaded columns of three components, by group
};

}  // namespace

bool HasRowsCode(const LawCode& law, const PassCode& pass, const Program& program) {
  if (pass.kind != BlockKind::kRows || program.results.empty()) return false;
  const auto fits = [&](uint16_t participant, uint16_t property) {
    const uint32_t components = law.properties[property].components;
    return participant == kOwnRow && (components == 1 || components == 3);
  };
  for (const LoadGroup& group : program.loads) {
    if (!fits(group.participant, group.property)) return false;
  }
  for (const ResultGroup& group : program.results) {
    if (!fits(group.participant, group.property)) return false;
    for (const ResultGroup& other : program.results) {
      if (&other != &group && other.property == group.property) return false;
    }
  }
  return true;
}

Label EmitRows(VectorAssembler& vectors, const LawCode& law, const Program& program) {
  return RowsCode(vectors, law, program).Emit();
}

}  // namespace vesper::text
