// SPDX-License-Identifier: Apache-2.0
// Executes one law of a text on the columns of an engine.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "aligned.hpp"
#include "kernels.hpp"
#include "law_code.hpp"
#include "machine_code.hpp"
#include "program.hpp"
#include "vesper/law.h"
#include "vesper/law_neighbours.hpp"

namespace vesper::text {

/// Maximum number of rows to which one row may refer.
inline constexpr size_t kMostParticipants = 8;

/// A value that is not finite, and the part of the formula that produced it.
struct Fault {
  std::string message;
  std::string property;
  uint64_t row;
};

/// A law in one precision. `advance` allocates no memory.
template <class Real>
class Evaluator {
 public:
  /// Creates the evaluator. `source` is the name of the text in messages, and `text` its content.
  /// All arguments must outlive the object. With `machine_code`, programs become machine code if
  /// possible.
  Evaluator(const LawCode& law, std::string_view source, std::string_view text,
            const vesper_host& host, const double* parameters,
            const Kernels<Real>& kernels = AvailableKernels<Real>().front(),
            bool machine_code = WhyNoMachineCode().empty());

  void Bind(const vesper_property* properties);
  /// Applies the law; returns the first value that is not finite although its operands are finite.
  std::optional<Fault> Advance(const vesper_step& step);
  double PotentialEnergy();
  /// Returns the reason why a pass has no machine code, or an empty text if all passes have it.
  const std::string& WhyEvaluated() const;

 private:
  struct Column {
    Real* data = nullptr;            // null: an absent property, which is zero everywhere
    const uint32_t* rows = nullptr;  // rows to which a reference points
    uint64_t count = 0;
    uint32_t components = 1;
  };

  /// Workspace of one thread: its registers and rows.
  struct Place {
    LineVector<Real> memory;
    std::vector<Real*> registers;
    std::array<std::vector<uint32_t>, kMostParticipants> rows;  // the rows of each participant in a
                                                                // block
    std::vector<Real> uniforms;
  };
  struct Executable : Program {
    MachineCode<Real> machine;
    std::vector<const Real*> load_data;  // columns of the groups of loads
    std::vector<Real*> result_data;      // columns of the groups of results
    bool complete = false;               // no column is absent
  };
  struct Pass {
    const PassCode* code;
    Executable program;
    std::optional<Executable> energy;
    std::vector<uint16_t> copied;   // properties that the pass uses in a copy; see Copy
    std::vector<uint16_t> written;  // those of them that the pass changes
  };
  /// A column of the law's own: the values of a field at the positions of all rows, or a copy of a
  /// property with another precision.
  struct Copy {
    const vesper_field* field = nullptr;
    void* source = nullptr;  // numbers of the other precision
    LineVector<Real> values;
  };
  /// The precision that `Real` is not.
  using Other = std::conditional_t<std::is_same_v<Real, double>, float, double>;

  Executable Make(const PassCode& code, bool energy, bool machine_code) const;
  void BindColumns(Executable& program) const;
  void Execute(const Executable& program, const Place& place, size_t count) const;
  void ExecuteOnParticipants(const Executable& program, size_t count, Place& place) const;

  void Prepare(Place& place, const Program& program) const;
  void FillUniforms(const Program& program, Place& place) const;
  /// Returns whether the law uses a property in a copy.
  bool IsCopied(uint16_t property) const;
  void FindCopied(Pass& pass) const;
  /// Evaluates the fields that a pass reads, and copies the properties with another precision.
  void FillCopies(const Pass& pass);
  void EvaluateField(uint16_t property);
  /// Writes changed values back to properties with another precision.
  void WriteBack(const Pass& pass);
  void ComputeConstants(const Program& program, const vesper_step& step);
  uint64_t RowsOf(const std::string& kind) const;
  void LoadRows(const Program& program, uint64_t begin, size_t count, Place& place) const;
  void LoadParticipants(const Program& program, size_t count, Place& place) const;
  /// Writes results to the rows of the block itself; returns true if all are finite.
  bool StoreRows(const Program& program, uint64_t begin, size_t count, Place& place) const;
  void AddToParticipants(const Program& program, size_t count, Place& place) const;
  bool ResultsAreFinite(const Program& program, size_t count, const Place& place) const;
  std::optional<Fault> Explain(const PassCode& pass, const Program& program, size_t count,
                               uint64_t begin, const Place& place) const;
  Fault MakeLimitFault(const Output& output, Real value, uint64_t row) const;
  Fault MakeFault(const PassCode& pass, NodeId node, const std::vector<Real>& values,
                  const Load& to, const std::vector<uint64_t>& rows) const;

  std::optional<Fault> RunRows(Pass& pass);
  std::optional<Fault> RunScattered(Pass& pass);
  std::optional<Fault> RunAllPairs(Pass& pass);
  void RunShare(Pass& pass, uint64_t share, uint64_t shares);
  std::optional<Fault> ExplainPairs(const Pass& pass, uint64_t first, uint64_t begin, size_t count,
                                    Place& place) const;
  /// Returns a fault if a pass over pairs within a distance has a position that is not finite. The
  /// grid would otherwise find no pairs for this row.
  std::optional<Fault> ExplainPositions(const PassCode& pass) const;
  void AddShares(const Pass& pass, uint64_t shares);
  /// Evaluates a program on all rows or pairs of a pass in a fixed order, on the calling thread.
  /// Calls `use(begin, count)` after each block.
  template <class Use>
  void ForEachBlock(const PassCode& pass, const Executable& program, Place& place, Use&& use);
  template <class Use>
  void ForEachRowOfSecond(const Executable& program, uint64_t first, uint64_t rows, Place& place,
                          Use&& use);
  void LoadReferences(const PassCode& pass, uint64_t begin, size_t count, Place& place) const;
  void LoadColumnsOfFirst(const Program& program, uint64_t row, Place& place) const;
  void LoadFirst(const Program& program, uint64_t row, Place& place) const;
  void SplitSecond(const Program& program, uint64_t rows);
  bool Begin(const Pass& pass, const Program& program, const vesper_step& step, Place& place);
  void NoteFault(std::optional<Fault> fault);

  const LawCode& law_;
  std::string_view source_;
  std::string_view text_;
  const vesper_host& host_;
  const Kernels<Real>& kernels_;
  std::vector<double> parameters_;
  std::vector<Column> columns_;
  std::vector<Copy> copies_;  // by property; empty for properties that are used in place
  std::vector<Pass> passes_;
  std::vector<double> constants_;
  vesper_step last_step_{};

  static constexpr size_t kPlaces = 16;
  std::vector<Place> places_;
  std::unique_ptr<std::atomic_flag[]> taken_ = std::make_unique<std::atomic_flag[]>(kPlaces);
  std::atomic_flag fault_taken_;
  std::optional<Fault> fault_;

  Neighbours<Real> neighbours_;
  // For passes over all pairs: the components of the second rows as columns, and the sums of each
  // share of the pairs.
  std::vector<LineVector<Real>> split_;
  std::vector<LineVector<Real>> sums_;
  std::vector<const Real*> split_data_;  // addresses of the vectors above
  std::vector<Real*> sums_data_;
  uint64_t shares_ = 0;
};

}  // namespace vesper::text
