// SPDX-License-Identifier: Apache-2.0
#include "evaluator.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <type_traits>

#include "problem.hpp"

namespace vesper::text {
namespace {

constexpr uint64_t kGrain = 4096;  // minimum number of rows in a chunk of a thread

template <class Body>
void ParallelFor(const vesper_host& host, uint64_t count, uint64_t grain, Body& body) {
  host.parallel_for(
      host.context, count, grain,
      [](void* user, uint64_t begin, uint64_t end) { (*static_cast<Body*>(user))(begin, end); },
      &body);
}

}  // namespace

template <class Real>
Evaluator<Real>::Evaluator(const LawCode& law, std::string_view source, std::string_view text,
                           const vesper_host& host, const double* parameters,
                           const Kernels<Real>& kernels, bool machine_code)
    : law_(law),
      source_(source),
      text_(text),
      host_(host),
      kernels_(kernels),
      parameters_(parameters, parameters + law.parameters.size()),
      columns_(law.properties.size()),
      copies_(law.properties.size()),
      places_(kPlaces) {
  size_t constants = 0;
  for (const PassCode& code : law.passes) {
    Pass& pass =
        passes_.emplace_back(Pass{&code, Make(code, false, machine_code), std::nullopt, {}, {}});
    FindCopied(pass);
    if (code.energy != kNoNode) pass.energy = Make(code, true, machine_code);
    for (const Program* program : {&pass.program, pass.energy ? &*pass.energy : nullptr}) {
      if (program == nullptr) continue;
      constants = std::max(constants, program->uniforms());
    }
  }
  constants_.resize(constants);
  size_t registers = 0;
  for (const Pass& pass : passes_) {
    registers = std::max<size_t>(registers, pass.program.registers);
    if (pass.energy) registers = std::max<size_t>(registers, pass.energy->registers);
  }
  for (Place& place : places_) {
    place.memory.assign(registers * (kBlock + kPadding) + kPadding, Real(0));
    place.registers.resize(registers);
    place.uniforms.resize(constants);
    for (auto& rows : place.rows) rows.resize(kBlock);
  }
}

template <class Real>
typename Evaluator<Real>::Executable Evaluator<Real>::Make(const PassCode& code, bool energy,
                                                           bool machine_code) const {
  Executable program{Compile(law_, code, energy), {}, {}, {}};
  if (machine_code) {
    program.machine = Generate(law_, code, program, kernels_);
  } else {
    program.machine.reason = WhyNoMachineCode();
  }
  program.load_data.resize(program.loads.size());
  program.result_data.resize(program.results.size());
  return program;
}

template <class Real>
void Evaluator<Real>::BindColumns(Executable& program) const {
  program.complete = true;
  for (size_t g = 0; g < program.loads.size(); ++g) {
    program.load_data[g] = columns_[program.loads[g].property].data;
    program.complete = program.complete && program.load_data[g] != nullptr;
  }
  for (size_t g = 0; g < program.results.size(); ++g) {
    program.result_data[g] = columns_[program.results[g].property].data;
    program.complete = program.complete && program.result_data[g] != nullptr;
  }
}

template <class Real>
void Evaluator<Real>::Execute(const Executable& program, const Place& place, size_t count) const {
  if (program.machine.run != nullptr) {
    program.machine.run(place.registers.data(), place.uniforms.data(), count);
  } else {
    kernels_.run(program.code, place.registers.data(), place.uniforms.data(), count);
  }
}

/// Executes a program on a block of rows that refer to other rows, or of pairs.
template <class Real>
void Evaluator<Real>::ExecuteOnParticipants(const Executable& program, size_t count,
                                            Place& place) const {
  if (program.machine.gather == nullptr || !program.complete) {
    LoadParticipants(program, count, place);
    Execute(program, place, count);
    return;
  }
  std::array<const uint32_t*, kMostParticipants> rows;
  for (size_t k = 0; k < rows.size(); ++k) {
    rows[k] = place.rows[k].data();
    // The remaining elements get a valid row, because machine code also loads rows after the end of
    // the block.
    std::fill(place.rows[k].begin() + static_cast<ptrdiff_t>(count), place.rows[k].end(),
              place.rows[k][0]);
  }
  const GatheredBlock<Real> block{place.registers.data(), place.uniforms.data(), count,
                                  program.load_data.data(), rows.data()};
  program.machine.gather(&block);
}

template <class Real>
const std::string& Evaluator<Real>::WhyEvaluated() const {
  for (const Pass& pass : passes_) {
    if (pass.program.machine.run == nullptr) return pass.program.machine.reason;
  }
  static const std::string nothing;
  return nothing;
}

template <class Real>
void Evaluator<Real>::Bind(const vesper_property* properties) {
  for (size_t use = 0; use < law_.table_order.size(); ++use) {
    const uint32_t i = law_.table_order[use];
    const vesper_property& property = properties[use];
    Column& column = columns_[i];
    column = {};
    column.count = property.row_count;
    column.components = law_.properties[i].components;
    if (law_.properties[i].is_reference) {
      column.rows = static_cast<const uint32_t*>(property.data);
    } else if (law_.properties[i].is_field) {
      copies_[i].field = static_cast<const vesper_field*>(property.data);
    } else if (IsCopied(static_cast<uint16_t>(i))) {
      copies_[i].source = property.data;
    } else {
      column.data = static_cast<Real*>(property.data);
    }
  }
  for (uint16_t i = 0; i < columns_.size(); ++i) {
    const PropertyCode& property = law_.properties[i];
    if (!IsCopied(i)) continue;
    Column& column = columns_[i];
    if (property.is_field) {
      copies_[i].field = copies_[property.first_of_field].field;
      column.count = columns_[property.positions].count;
      column.components = property.components;
    }
    copies_[i].values.assign(column.count * column.components + kPadding, Real(0));
    const bool absent = !property.is_field && copies_[i].source == nullptr;
    column.data = absent ? nullptr : copies_[i].values.data();
  }
  for (Pass& pass : passes_) {
    BindColumns(pass.program);
    if (pass.energy) BindColumns(*pass.energy);
  }
  uint64_t paired = 0;
  size_t split = 0, sums = 0;
  shares_ = 0;
  for (const Pass& pass : passes_) {
    if (pass.code->kind != BlockKind::kPairs) continue;
    const uint64_t rows = RowsOf(pass.code->rows);
    if (pass.code->within != kNoNode) {
      neighbours_.Reserve(rows);
      continue;
    }
    paired = std::max(paired, rows);
    for (const Program* program : {&pass.program, pass.energy ? &*pass.energy : nullptr}) {
      if (program == nullptr) continue;
      split = std::max(split, program->loads.size() * 4);
      sums = std::max(sums, program->results.size() * 4);
    }
  }
  if (paired == 0) return;
  shares_ = std::clamp<uint64_t>(paired / 1024, 1, kPlaces);
  split_.assign(split, LineVector<Real>(paired + kBlock + kPadding));
  sums_.assign(shares_ * sums, LineVector<Real>(paired + kBlock + kPadding));
  split_data_.clear();
  for (const auto& column : split_) split_data_.push_back(column.data());
  sums_data_.clear();
  for (auto& column : sums_) sums_data_.push_back(column.data());
}

template <class Real>
uint64_t Evaluator<Real>::RowsOf(const std::string& kind) const {
  for (size_t i = 0; i < columns_.size(); ++i) {
    const bool present = columns_[i].data != nullptr || columns_[i].rows != nullptr;
    if (law_.properties[i].kind == kind && present) return columns_[i].count;
  }
  return 0;
}

/// Points the registers to the memory of the workspace, and fills the registers that have the same
/// value for all rows.
template <class Real>
void Evaluator<Real>::Prepare(Place& place, const Program& program) const {
  for (size_t i = 0; i < place.registers.size(); ++i) {
    place.registers[i] = place.memory.data() + i * (kBlock + kPadding);
  }
  for (const Fill& fill : program.fills) {
    std::fill_n(place.registers[fill.to], kBlock + kPadding, place.uniforms[fill.from]);
  }
}

template <class Real>
void Evaluator<Real>::ComputeConstants(const Program& program, const vesper_step& step) {
  const Graph& graph = law_.graph;
  std::vector<double>& constants = constants_;
  const auto value_of = [&](NodeId id) {
    if (id == kNoNode) return 0.0;
    const auto at = std::lower_bound(program.constants.begin(), program.constants.end(), id);
    return constants[static_cast<size_t>(at - program.constants.begin())];
  };
  for (size_t i = 0; i < program.constants.size(); ++i) {
    const Node& node = graph[program.constants[i]];
    switch (node.operation) {
      case Operation::kConstant:
        constants[i] = node.value;
        break;
      case Operation::kParameter:
        constants[i] = parameters_[node.index];
        break;
      case Operation::kTime:
        constants[i] = step.time;
        break;
      case Operation::kStep:
        constants[i] = step.dt;
        break;
      case Operation::kStage:
        constants[i] = step.stage;
        break;
      case Operation::kLoad: {
        const Column& column = columns_[node.load.property];
        constants[i] = column.data == nullptr || column.count == 0
                           ? 0
                           : static_cast<double>(column.data[node.load.component]);
        break;
      }
      default:
        constants[i] =
            ComputeIn<double>(node.operation, value_of(node.a), value_of(node.b), value_of(node.c));
        break;
    }
  }
}

template <class Real>
bool Evaluator<Real>::IsCopied(uint16_t property) const {
  const PropertyCode& use = law_.properties[property];
  const vesper_scalar_type other = std::is_same_v<Other, double> ? VESPER_F64 : VESPER_F32;
  return use.is_field || use.other_type == other;
}

template <class Real>
void Evaluator<Real>::FindCopied(Pass& pass) const {
  const auto note = [&](std::vector<uint16_t>& list, uint16_t property) {
    if (IsCopied(property) && std::ranges::find(list, property) == list.end()) {
      list.push_back(property);
    }
  };
  const auto note_loads = [&](NodeId root) {
    if (root == kNoNode) return;
    for (const Load& load : law_.graph.LoadsOf(root)) {
      if (law_.properties[load.property].is_field) {
        note(pass.copied, law_.properties[load.property].positions);
      }
      note(pass.copied, load.property);
    }
  };
  const PassCode& code = *pass.code;
  for (const Output& output : code.outputs) {
    note_loads(output.value);
    note(pass.copied, output.to.property);
    note(pass.written, output.to.property);
  }
  note_loads(code.energy);
  note_loads(code.within);
  if (code.within != kNoNode) note(pass.copied, code.position);
}

template <class Real>
void Evaluator<Real>::FillCopies(const Pass& pass) {
  for (const uint16_t property : pass.copied) {
    if (law_.properties[property].is_field) {
      EvaluateField(property);
      continue;
    }
    const auto* from = static_cast<const Other*>(copies_[property].source);
    if (from == nullptr) continue;
    const Column& column = columns_[property];
    auto body = [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) column.data[i] = static_cast<Real>(from[i]);
    };
    ParallelFor(host_, column.count * column.components, kGrain, body);
  }
}

template <class Real>
void Evaluator<Real>::EvaluateField(uint16_t property) {
  const vesper_field& field = *copies_[property].field;
  const PropertyCode& use = law_.properties[property];
  const Column& column = columns_[property];
  const Real* positions = columns_[use.positions].data;
  // A function with slopes writes four numbers for each component: the value, and its derivatives.
  const uint32_t per_component = law_.properties[use.first_of_field].sloped ? 4 : 1;
  const uint32_t per_row = per_component * use.field_components;
  const uint32_t first = use.slope_of == 0 ? 0 : 4 * (use.slope_of - 1) + 1;
  const uint32_t stride = use.slope_of == 0 ? per_component : 1;
  auto body = [&](uint64_t begin, uint64_t end) {
    std::array<double, 3 * kBlock> at;
    std::array<double, 12 * kBlock> values;
    for (uint64_t row = begin; row < end;) {
      const uint64_t count = std::min<uint64_t>(kBlock, end - row);
      std::copy_n(positions + 3 * row, 3 * count, at.begin());
      field.evaluate(field.user, count, at.data(), values.data());
      for (uint64_t i = 0; i < count; ++i) {
        for (uint32_t c = 0; c < column.components; ++c) {
          column.data[(row + i) * column.components + c] =
              static_cast<Real>(values[i * per_row + first + c * stride]);
        }
      }
      row += count;
    }
  };
  ParallelFor(host_, column.count, kGrain, body);
}

template <class Real>
void Evaluator<Real>::WriteBack(const Pass& pass) {
  for (const uint16_t property : pass.written) {
    auto* to = static_cast<Other*>(copies_[property].source);
    if (to == nullptr) continue;
    const Column& column = columns_[property];
    auto body = [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        // A number that the pass did not change keeps all its bits.
        if (static_cast<Real>(to[i]) != column.data[i]) to[i] = static_cast<Other>(column.data[i]);
      }
    };
    ParallelFor(host_, column.count * column.components, kGrain, body);
  }
}

template <class Real>
void Evaluator<Real>::FillUniforms(const Program& program, Place& place) const {
  for (size_t i = 0; i < program.constants.size(); ++i) {
    place.uniforms[i] = static_cast<Real>(constants_[i]);
  }
}

template <class Real>
void Evaluator<Real>::LoadRows(const Program& program, uint64_t begin, size_t count,
                               Place& place) const {
  Real* const* registers = place.registers.data();
  for (const LoadGroup& group : program.loads) {
    if (group.participant != kOwnRow) continue;
    const Column& column = columns_[group.property];
    if (column.data == nullptr) {
      for (const uint16_t to : group.to) {
        if (to != kNothing) std::fill_n(registers[to], kBlock + kPadding, Real(0));
      }
      continue;
    }
    const Real* from = column.data + begin * column.components;
    if (column.components == 1) {
      if (count == kBlock && !group.written) {
        place.registers[group.to[0]] = const_cast<Real*>(from);  // no instruction writes to
                                                                 // registers of loads
      } else {
        place.registers[group.to[0]] = place.memory.data() + group.to[0] * (kBlock + kPadding);
        std::copy_n(from, count, place.registers[group.to[0]]);
      }
      continue;
    }
    if (column.components == 3 && group.to[0] != kNothing && group.to[1] != kNothing &&
        group.to[2] != kNothing) {
      kernels_.split3(from, count, registers[group.to[0]], registers[group.to[1]],
                      registers[group.to[2]]);
      continue;
    }
    for (uint32_t k = 0; k < column.components; ++k) {
      if (group.to[k] == kNothing) continue;
      for (size_t i = 0; i < count; ++i)
        registers[group.to[k]][i] = from[i * column.components + k];
    }
  }
}

template <class Real>
void Evaluator<Real>::LoadParticipants(const Program& program, size_t count, Place& place) const {
  for (const LoadGroup& group : program.loads) {
    if (group.participant == kOwnRow) continue;
    const Column& column = columns_[group.property];
    const uint32_t* rows = place.rows[group.participant - kFirst].data();
    const auto to = [&](size_t k) { return place.registers[group.to[k]]; };
    if (column.data == nullptr) {
      for (const uint16_t each : group.to) {
        if (each != kNothing) std::fill_n(place.registers[each], count, Real(0));
      }
    } else if (column.components == 3 && group.to[0] != kNothing && group.to[1] != kNothing &&
               group.to[2] != kNothing) {
      Real *x = to(0), *y = to(1), *z = to(2);
      for (size_t i = 0; i < count; ++i) {
        const Real* from = column.data + 3 * uint64_t{rows[i]};
        x[i] = from[0];
        y[i] = from[1];
        z[i] = from[2];
      }
    } else {
      for (uint32_t k = 0; k < column.components; ++k) {
        if (group.to[k] == kNothing) continue;
        for (size_t i = 0; i < count; ++i) {
          to(k)[i] = column.data[uint64_t{rows[i]} * column.components + k];
        }
      }
    }
  }
}

template <class Real>
bool Evaluator<Real>::StoreRows(const Program& program, uint64_t begin, size_t count,
                                Place& place) const {
  bool finite = true;
  for (const ResultGroup& group : program.results) {
    if (group.participant != kOwnRow) continue;
    const Column& column = columns_[group.property];
    if (column.data == nullptr) continue;
    Real* to = column.data + begin * column.components;
    const auto from = [&](size_t k) { return place.registers[group.from[k]]; };
    const bool whole =
        group.from[0] != kNothing && group.from[1] != kNothing && group.from[2] != kNothing;
    if (column.components == 3 && whole) {
      finite &= (group.add ? kernels_.add3 : kernels_.join3)(to, count, from(0), from(1), from(2));
      continue;
    }
    if (column.components == 1 && group.add) {
      finite &= kernels_.add1(to, count, from(0));
      continue;
    }
    for (uint32_t k = 0; k < column.components; ++k) {
      if (group.from[k] == kNothing) continue;
      finite &= kernels_.finite(from(k), count);
      for (size_t i = 0; i < count; ++i) {
        Real& value = to[i * column.components + k];
        value = group.add ? value + from(k)[i] : from(k)[i];
      }
    }
  }
  return finite;
}

template <class Real>
void Evaluator<Real>::AddToParticipants(const Program& program, size_t count, Place& place) const {
  for (const ResultGroup& group : program.results) {
    if (group.participant == kOwnRow) continue;
    const Column& column = columns_[group.property];
    if (column.data == nullptr) continue;
    const uint32_t* rows = place.rows[group.participant - kFirst].data();
    const auto from = [&](size_t k) { return place.registers[group.from[k]]; };
    if (column.components == 3 && group.from[0] != kNothing && group.from[1] != kNothing &&
        group.from[2] != kNothing) {
      kernels_.add3_at(column.data, rows, count, from(0), from(1), from(2));
      continue;
    }
    for (uint32_t k = 0; k < column.components; ++k) {
      if (group.from[k] == kNothing) continue;
      for (size_t i = 0; i < count; ++i) {
        column.data[uint64_t{rows[i]} * column.components + k] += from(k)[i];
      }
    }
  }
}

template <class Real>
bool Evaluator<Real>::ResultsAreFinite(const Program& program, size_t count,
                                       const Place& place) const {
  for (const ResultGroup& group : program.results) {
    for (const uint16_t from : group.from) {
      if (from != kNothing && !kernels_.finite(place.registers[from], count)) return false;
    }
  }
  return true;
}

template <class Real>
void Evaluator<Real>::NoteFault(std::optional<Fault> fault) {
  if (!fault) return;
  while (fault_taken_.test_and_set(std::memory_order_acquire)) {
  }
  if (!fault_ || fault->row < fault_->row) fault_ = std::move(fault);
  fault_taken_.clear(std::memory_order_release);
}

/// Computes the values that are the same for all rows. Returns false if there are no rows to
/// process.
template <class Real>
bool Evaluator<Real>::Begin(const Pass& pass, const Program& program, const vesper_step& step,
                            Place& place) {
  if (RowsOf(pass.code->rows) == 0) return false;
  FillCopies(pass);
  ComputeConstants(program, step);
  FillUniforms(program, place);
  Prepare(place, program);
  return program.within == kNothing || constants_[program.within] > 0;
}

template <class Real>
std::optional<Fault> Evaluator<Real>::Advance(const vesper_step& step) {
  last_step_ = step;
  for (Pass& pass : passes_) {
    if (pass.code->stage && *pass.code->stage != step.stage) continue;
    if (!Begin(pass, pass.program, step, places_[0])) continue;
    fault_.reset();
    std::optional<Fault> fault;
    if (pass.code->kind == BlockKind::kRows) {
      fault = RunRows(pass);
    } else if (pass.code->kind == BlockKind::kPairs && pass.code->within == kNoNode) {
      fault = RunAllPairs(pass);
    } else {
      fault = RunScattered(pass);
    }
    if (fault) return fault;
    WriteBack(pass);
  }
  return std::nullopt;
}

template <class Real>
std::optional<Fault> Evaluator<Real>::RunRows(Pass& pass) {
  const Executable& program = pass.program;
  const uint64_t count = RowsOf(pass.code->rows);
  // Chooses the length of chunks so that there are at most as many chunks as workspaces.
  const uint64_t blocks = (count + kPlaces * kBlock - 1) / (kPlaces * kBlock);
  const uint64_t grain = std::max(kGrain, blocks * kBlock);
  auto body = [&](uint64_t begin, uint64_t end) {
    size_t at = 0;
    while (taken_[at].test_and_set(std::memory_order_acquire)) at = (at + 1) % kPlaces;
    Place& place = places_[at];
    FillUniforms(program, place);
    Prepare(place, program);
    for (uint64_t row = begin; row < end;) {
      if (program.machine.rows != nullptr && program.complete) {
        const RowsOfPass<Real> of{program.load_data.data(), program.result_data.data(),
                                  place.uniforms.data(), row, end};
        row = program.machine.rows(&of);
        if (row == end) break;
      }
      // Evaluates rows up to the end of a block, so that the evaluator finds the same faults as
      // without machine code.
      const uint64_t rest = kBlock - (row - begin) % kBlock;
      const auto rows = static_cast<size_t>(std::min<uint64_t>(rest, end - row));
      LoadRows(program, row, rows, place);
      Execute(program, place, rows);
      if (!StoreRows(program, row, rows, place)) {
        NoteFault(Explain(*pass.code, program, rows, row, place));
      }
      row += rows;
    }
    taken_[at].clear(std::memory_order_release);
  };
  ParallelFor(host_, count, grain, body);
  return std::move(fault_);
}

/// Runs passes over rows that refer to other rows, and over pairs within a distance. They may add
/// several times to the same row, so they run in order, on one thread.
template <class Real>
std::optional<Fault> Evaluator<Real>::RunScattered(Pass& pass) {
  const Executable& program = pass.program;
  Place& place = places_[0];
  if (std::optional<Fault> fault = ExplainPositions(*pass.code)) return fault;
  ForEachBlock(*pass.code, program, place, [&](uint64_t begin, size_t count) {
    if (fault_) return;
    if (!ResultsAreFinite(program, count, place)) {
      LoadParticipants(program, count, place);
      NoteFault(Explain(*pass.code, program, count, begin, place));
    }
    if (pass.code->kind == BlockKind::kJoined) StoreRows(program, begin, count, place);
    AddToParticipants(program, count, place);
  });
  return std::move(fault_);
}

template <class Real>
void Evaluator<Real>::LoadReferences(const PassCode& pass, uint64_t begin, size_t count,
                                     Place& place) const {
  const std::vector<Load>& references = pass.references;
  if (references.size() == 2 && references[0] == Load{kOwnRow, references[0].property, 0} &&
      references[1] == Load{kOwnRow, references[0].property, 1} &&
      columns_[references[0].property].components == 2) {
    kernels_.split_rows(columns_[references[0].property].rows + 2 * begin, count,
                        place.rows[0].data(), place.rows[1].data());
    return;
  }
  for (size_t k = 0; k < references.size(); ++k) {
    const Load& reference = references[k];
    const Column& column = columns_[reference.property];
    const uint32_t components = column.components;
    const uint32_t* from = column.rows + begin * components + reference.component;
    uint32_t* to = place.rows[k].data();
    for (size_t i = 0; i < count; ++i) to[i] = from[i * components];
  }
}

template <class Real>
template <class Use>
void Evaluator<Real>::ForEachBlock(const PassCode& pass, const Executable& program, Place& place,
                                   Use&& use) {
  const uint64_t rows = RowsOf(pass.rows);
  const auto run = [&](uint64_t begin, size_t count) {
    ExecuteOnParticipants(program, count, place);
    use(begin, count);
  };
  if (pass.kind == BlockKind::kPairs && pass.within != kNoNode) {
    neighbours_.ForEach(columns_[pass.position].data, rows, constants_[program.within],
                        place.rows[0].data(), place.rows[1].data(), kBlock,
                        [&](size_t count) { run(0, count); });
  } else if (pass.kind == BlockKind::kPairs) {
    SplitSecond(program, rows);
    for (uint64_t first = 0; first < rows; ++first) {
      ForEachRowOfSecond(program, first, rows, place, use);
    }
  } else {
    for (uint64_t begin = 0; begin < rows; begin += kBlock) {
      const auto count = static_cast<size_t>(std::min<uint64_t>(kBlock, rows - begin));
      LoadReferences(pass, begin, count, place);
      LoadRows(program, begin, count, place);
      run(begin, count);
    }
  }
}

template <class Real>
double Evaluator<Real>::PotentialEnergy() {
  double energy = 0;
  for (Pass& pass : passes_) {
    if (!pass.energy) continue;
    Place& place = places_[0];
    if (!Begin(pass, *pass.energy, last_step_, place)) continue;
    ForEachBlock(*pass.code, *pass.energy, place, [&](uint64_t, size_t count) {
      const Real* values = place.registers[pass.energy->energy];
      for (size_t i = 0; i < count; ++i) energy += static_cast<double>(values[i]);
    });
  }
  return energy;
}

}  // namespace vesper::text

#include "evaluator_pairs-inl.hpp"

namespace vesper::text {

template class Evaluator<float>;
template class Evaluator<double>;

}  // namespace vesper::text
