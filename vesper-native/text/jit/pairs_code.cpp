// SPDX-License-Identifier: Apache-2.0
#include "pairs_code.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "machine_code.hpp"

namespace vesper::text {
namespace {

using namespace asmjit;

constexpr uint32_t kGroup = kPadding;  // rows of a group; equals the number of partial sums

/// A table of masks for 16 rows. Rows before a border have one value, and rows behind it the other;
/// the masks keep results or set them to 0.
struct Border {
  alignas(64) std::array<uint8_t, 256> bytes;
  explicit Border(uint8_t before, uint8_t behind) {
    std::memset(bytes.data(), before, 128);
    std::memset(bytes.data() + 128, behind, 128);
  }
  uint64_t address() const { return reinterpret_cast<uint64_t>(bytes.data()) + 128; }
};

class PairsCode {
 public:
  PairsCode(VectorAssembler& vectors, const Program& program, const Graph& graph)
      : vectors_(vectors), code_(vectors.code()), program_(program), graph_(graph) {
    columns_.resize(program.registers, kNothing);
    for (size_t g = 0; g < program.loads.size(); ++g) {
      for (size_t k = 0; k < 4; ++k) {
        const uint16_t to = program.loads[g].to[k];
        if (to != kNothing) columns_[to] = static_cast<uint16_t>(4 * g + k);
      }
    }
    for (size_t g = 0; g < program.results.size(); ++g) {
      for (size_t k = 0; k < 4; ++k) {
        const uint16_t from = program.results[g].from[k];
        if (from == kNothing) continue;
        const bool of_first = program.results[g].participant == kFirst;
        results_.push_back({from, static_cast<uint16_t>(4 * g + k), of_first, kNothing, false, {}});
      }
    }
  }

  Label Emit() {
    FuncNode* function = code_.addFunc(FuncSignatureT<uint64_t, void*>());
    const x86::Gp of = code_.newUIntPtr();
    vectors_.Begin(function, {of});
    second_ = Field(of, offsetof(PairsOfRow<double>, second));
    sums_ = Field(of, offsetof(PairsOfRow<double>, sums));
    first_ = Field(of, offsetof(PairsOfRow<double>, first));
    rows_ = Field(of, offsetof(PairsOfRow<double>, rows));
    ProgramEmitter emitter(vectors_, program_, Field(of, offsetof(PairsOfRow<double>, uniforms)));
    emitter.ComputeOfFirst(graph_);
    emitter.LoadUniforms();
    Prepare(emitter);
    // The operations of two vectors alternate, because each depends on the one before it.
    std::vector<ProgramEmitter> pair(2, emitter);
    const bool doubles = vectors_.lanes() == kGroup;  // a group is one vector only
    const Label block = code_.newLabel(), group = code_.newLabel(), edge = code_.newLabel();
    const Label one = code_.newLabel(), next = code_.newLabel(), whole = code_.newLabel(),
                end = code_.newLabel();
    code_.lea(at_, x86::ptr(first_, 1));
    code_.and_(at_, -static_cast<int32_t>(kGroup));
    code_.cmp(at_, rows_);
    code_.jae(end);
    const x86::Gp limit = code_.newUIntPtr();
    code_.bind(block);
    for (Result& result : results_) {
      for (const x86::Vec& sum : result.sums) code_.vxorps(sum, sum, sum);
    }
    code_.lea(limit, x86::ptr(at_, kBlock));
    code_.bind(group);
    code_.cmp(at_, first_);
    code_.jbe(edge);
    const x86::Gp behind = code_.newUIntPtr();
    if (doubles) {
      code_.lea(behind, x86::ptr(at_, 2 * kGroup));
      code_.cmp(behind, rows_);
      code_.ja(one);
      code_.cmp(behind, limit);
      code_.ja(one);
      EmitGroups(pair, 2, false);
      code_.add(at_, 2 * kGroup);
      code_.jmp(next);
      code_.bind(one);
    }
    code_.lea(behind, x86::ptr(at_, kGroup));
    code_.cmp(behind, rows_);
    code_.ja(edge);
    EmitGroups(pair, 1, false);
    code_.add(at_, kGroup);
    code_.jmp(next);
    code_.bind(edge);
    EmitGroups(pair, 1, true);
    code_.add(at_, kGroup);
    code_.bind(next);
    code_.cmp(at_, rows_);
    code_.jae(whole);
    code_.cmp(at_, limit);
    code_.jb(group);
    code_.bind(whole);
    for (Result& result : results_) {
      if (result.of_first) AddBlock(result);
    }
    code_.cmp(at_, rows_);
    code_.jb(block);
    code_.bind(end);
    ReturnWhetherFinite();
    code_.endFunc();
    return function->label();
  }

 private:
  struct Result {
    uint16_t from;               // register of the result
    uint16_t column;             // index of its sums
    bool of_first;               // true: of the first row; false: of the second rows
    uint16_t positive;           // register of the result whose negative this is, or kNothing
    bool checked;                // true: a sum of the first row detects NaN and infinity
    std::vector<x86::Vec> sums;  // sums of the first row, in the order of Kernels::sum

    uint16_t source() const { return positive != kNothing ? positive : from; }
  };

  x86::Gp Field(const x86::Gp& of, size_t offset) {
    const x86::Gp to = code_.newUIntPtr();
    code_.mov(to, x86::ptr(of, static_cast<int32_t>(offset)));
    return to;
  }

  void Prepare(const ProgramEmitter& emitter) {
    at_ = code_.newUIntPtr();
    watch_ = vectors_.Zero();
    skipped_.resize(program_.registers);
    for (Result& result : results_) {
      for (uint32_t i = 0; result.of_first && i < kGroup; i += vectors_.lanes()) {
        result.sums.push_back(vectors_.NewVector());
      }
    }
    // A result that is the negative of another result is not computed but subtracted, because x +
    // (-y) and x - y have the same bits.
    for (Result& result : results_) {
      const uint16_t positive = emitter.NegativeOf(result.from);
      for (const Result& other : results_) {
        if (other.from == positive) result.positive = positive;
      }
      if (result.positive != kNothing) skipped_[result.from] = true;
    }
    // The result of a first row is not checked here. Its NaN or infinity is also in its sum, which
    // is checked at the end of a block.
    for (Result& result : results_) {
      for (const Result& other : results_) {
        result.checked |= other.of_first && other.source() == result.source();
      }
    }
    // Keeps the addresses of columns in registers, up to kMostPointers.
    for (const uint16_t column : columns_) {
      if (column != kNothing && pointers_.size() < kMostPointers) {
        pointers_.push_back({second_, column, Field(second_, column * 8)});
      }
    }
    for (const Result& result : results_) {
      if (!result.of_first && pointers_.size() < kMostPointers) {
        pointers_.push_back({sums_, result.column, Field(sums_, result.column * 8)});
      }
    }
  }

  /// Returns the memory of a vector of rows of a column, from the current row on.
  x86::Mem Rows(const x86::Gp& table, uint16_t column, uint32_t lane) {
    const uint32_t shift = vectors_.number_bytes() == 8 ? 3 : 2;
    const auto offset = static_cast<int32_t>(lane * vectors_.number_bytes());
    for (const Pointer& pointer : pointers_) {
      if (pointer.table == table && pointer.column == column) {
        return x86::ptr(pointer.base, at_, shift, offset);
      }
    }
    return x86::ptr(Field(table, column * 8), at_, shift, offset);
  }

  /// Emits `groups` groups of rows. Sets the results of rows outside of the range of second rows to
  /// 0 at an edge of this range.
  void EmitGroups(std::vector<ProgramEmitter>& emitters, uint32_t groups, bool edge) {
    x86::Gp from, to;
    if (edge) FindBorders(from, to);
    const std::vector<bool> none(program_.registers);
    const uint32_t lanes = vectors_.lanes();
    for (uint32_t first = 0; first < groups * kGroup; first += emitters.size() * lanes) {
      const size_t ways = std::min<size_t>(emitters.size(), (groups * kGroup - first) / lanes);
      for (uint32_t way = 0; way < ways; ++way) {
        emitters[way].Begin([this, lane = first + way * lanes](uint16_t of) {
          return vectors_.Load(Rows(second_, columns_[of], lane));
        });
      }
      for (size_t i = 0; i < program_.code.size(); ++i) {
        for (size_t way = 0; way < ways; ++way) {
          emitters[way].EmitOperation(i, edge ? none : skipped_);
        }
      }
      for (uint32_t way = 0; way < ways; ++way) {
        AddResults(emitters[way], first + way * lanes, edge, from, to);
      }
    }
  }

  void AddResults(ProgramEmitter& emitter, uint32_t lane, bool edge, const x86::Gp& from,
                  const x86::Gp& to) {
    for (Result& result : results_) {
      const bool subtract = !edge && result.positive != kNothing;
      x86::Vec value = emitter.Result(subtract ? result.positive : result.from);
      if (edge) {
        const auto offset = static_cast<int32_t>(lane * vectors_.number_bytes());
        value = vectors_.KeepWhere(value, x86::ptr(from, offset));
        value = vectors_.KeepWhere(value, x86::ptr(to, offset));
      }
      if (!result.checked) vectors_.AddTo(watch_, vectors_.Subtract(value, value));
      if (result.of_first) {
        const x86::Vec& sum = result.sums[lane % kGroup / vectors_.lanes()];
        subtract ? vectors_.SubtractFrom(sum, value) : vectors_.AddTo(sum, value);
        continue;
      }
      const x86::Mem sum = Rows(sums_, result.column, lane);
      vectors_.Store(
          sum, subtract ? vectors_.Subtract(vectors_.Load(sum), value) : vectors_.Add(value, sum));
    }
  }

  /// Sets `from` and `to` to the addresses of two masks for the group. The mask `from` keeps the
  /// rows behind the first row of the pairs; the mask `to` keeps the rows that exist.
  void FindBorders(x86::Gp& from, x86::Gp& to) {
    static const Border kFrom(0, 0xff), kTo(0xff, 0);
    const uint32_t shift = vectors_.number_bytes() == 8 ? 3 : 2;
    const x86::Gp before = code_.newUIntPtr(), present = code_.newUIntPtr();
    const x86::Gp other = code_.newUIntPtr();
    code_.lea(before, x86::ptr(first_, 1));
    code_.sub(before, at_);
    code_.xor_(other, other);
    code_.cmp(before, other);
    code_.cmovl(before, other);
    code_.shl(before, shift);
    from = code_.newUIntPtr();
    code_.mov(from, imm(kFrom.address()));
    code_.sub(from, before);
    code_.mov(present, rows_);
    code_.sub(present, at_);
    code_.mov(other, kGroup);
    code_.cmp(present, other);
    code_.cmova(present, other);
    code_.shl(present, shift);
    to = code_.newUIntPtr();
    code_.mov(to, imm(kTo.address()));
    code_.sub(to, present);
  }

  /// Adds the sum of a block to the sum of the first row, in the order of Kernels::sum.
  void AddBlock(const Result& result) {
    std::vector<x86::Vec> sums = result.sums;
    while (sums.size() > 1) {
      const size_t half = sums.size() / 2;
      for (size_t i = 0; i < half; ++i) sums[i] = vectors_.Add(sums[i], sums[i + half]);
      sums.resize(half, sums[0]);
    }
    x86::Vec sum = sums[0];
    for (uint32_t bytes = vectors_.vector_bytes(); bytes > vectors_.number_bytes(); bytes /= 2) {
      sum = vectors_.AddHalves(sum, bytes);
    }
    vectors_.AddOneTo(
        x86::ptr(Field(sums_, result.column * 8), first_, vectors_.number_bytes() == 8 ? 3 : 2),
        sum);
    vectors_.AddTo(watch_, vectors_.Subtract(sum, sum));
  }

  void ReturnWhetherFinite() {
    const x86::Gp finite = code_.newUIntPtr();
    vectors_.SetIfZero(finite, watch_);
    code_.ret(finite);
  }

  struct Pointer {
    x86::Gp table;
    uint16_t column;
    x86::Gp base;
  };
  static constexpr size_t kMostPointers = 8;

  VectorAssembler& vectors_;
  x86::Compiler& code_;
  const Program& program_;
  const Graph& graph_;
  std::vector<uint16_t> columns_;  // index of the column of each register of a load
  std::vector<Result> results_;
  std::vector<bool> skipped_;
  std::vector<Pointer> pointers_;
  x86::Gp second_, sums_, first_, rows_, at_;
  x86::Vec watch_;  // 0 in all lanes, or NaN after a value that is not finite
};

}  // namespace

Label EmitPairs(VectorAssembler& vectors, const Program& program, const Graph& graph) {
  return PairsCode(vectors, program, graph).Emit();
}

}  // namespace vesper::text
