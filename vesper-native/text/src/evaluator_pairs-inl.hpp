// SPDX-License-Identifier: Apache-2.0
// All pairs of rows, and the search for the origin of values that are not finite. Part of
// evaluator.cpp.
#pragma once

namespace vesper::text {

// --- all pairs --------------------------------------------------------------------------------

/// Splits the properties of the second row of a pair into columns of one component each.
template <class Real>
void Evaluator<Real>::SplitSecond(const Program& program, uint64_t rows) {
  for (size_t g = 0; g < program.loads.size(); ++g) {
    const LoadGroup& group = program.loads[g];
    const Column& column = columns_[group.property];
    for (uint32_t k = 0; k < column.components; ++k) {
      if (group.to[k] == kNothing) continue;
      LineVector<Real>& to = split_[4 * g + k];
      if (column.data == nullptr) {
        std::fill(to.begin(), to.end(), Real(0));
        continue;
      }
      for (uint64_t i = 0; i < rows; ++i) to[i] = column.data[i * column.components + k];
    }
  }
}

template <class Real>
void Evaluator<Real>::LoadColumnsOfFirst(const Program& program, uint64_t row, Place& place) const {
  for (const LoadGroup& group : program.loads_of_first) {
    const Column& column = columns_[group.property];
    for (uint32_t k = 0; k < column.components; ++k) {
      if (group.to[k] == kNothing) continue;
      place.uniforms[group.to[k]] =
          column.data == nullptr ? Real(0) : column.data[row * column.components + k];
    }
  }
}

/// Computes the values that depend only on the first row of a pair.
template <class Real>
void Evaluator<Real>::LoadFirst(const Program& program, uint64_t row, Place& place) const {
  LoadColumnsOfFirst(program, row, place);
  const auto value_of = [&](NodeId id) {
    if (id == kNoNode) return Real(0);
    const auto find = [&](const std::vector<NodeId>& list, size_t offset) -> const Real* {
      const auto at = std::lower_bound(list.begin(), list.end(), id);
      if (at == list.end() || *at != id) return nullptr;
      return &place.uniforms[offset + static_cast<size_t>(at - list.begin())];
    };
    if (const Real* constant = find(program.constants, 0)) return *constant;
    return *find(program.of_first, program.constants.size());
  };
  for (size_t i = 0; i < program.of_first.size(); ++i) {
    const Node& node = law_.graph[program.of_first[i]];
    if (node.operation == Operation::kLoad) continue;
    place.uniforms[program.constants.size() + i] =
        ComputeIn<Real>(node.operation, value_of(node.a), value_of(node.b), value_of(node.c));
  }
  for (const Fill& fill : program.fills) {
    std::fill_n(place.registers[fill.to], kBlock + kPadding, place.uniforms[fill.from]);
  }
}

/// Evaluates the pairs of one row with all later rows.
template <class Real>
template <class Use>
void Evaluator<Real>::ForEachRowOfSecond(const Executable& program, uint64_t first, uint64_t rows,
                                         Place& place, Use&& use) {
  LoadFirst(program, first, place);
  const auto clear = [&](uint16_t result, size_t count) {
    if (result != kNothing) std::fill_n(place.registers[result], count, Real(0));
  };
  // Blocks begin at cache lines, so the first block may contain rows up to `first`. The results of
  // these rows are cleared.
  for (uint64_t begin = (first + 1) / kPadding * kPadding; begin < rows; begin += kBlock) {
    const auto count = static_cast<size_t>(std::min<uint64_t>(kBlock, rows - begin));
    for (size_t g = 0; g < program.loads.size(); ++g) {
      for (size_t k = 0; k < 4; ++k) {
        const uint16_t to = program.loads[g].to[k];
        if (to != kNothing) place.registers[to] = split_[4 * g + k].data() + begin;
      }
    }
    Execute(program, place, count);
    if (begin <= first) {
      const auto before = static_cast<size_t>(first + 1 - begin);
      for (const ResultGroup& group : program.results) {
        for (const uint16_t result : group.from) clear(result, before);
      }
      clear(program.energy, before);
    }
    use(begin, count);
  }
}

template <class Real>
void Evaluator<Real>::RunShare(Pass& pass, uint64_t share, uint64_t shares) {
  const Executable& program = pass.program;
  const uint64_t rows = RowsOf(pass.code->rows);
  // Divides the rows so that all shares have about the same number of pairs.
  const auto begin_of = [&](uint64_t s) {
    const double part = 1 - std::sqrt(1 - static_cast<double>(s) / static_cast<double>(shares));
    return s == shares ? rows : static_cast<uint64_t>(part * static_cast<double>(rows));
  };
  Place& place = places_[share];
  FillUniforms(program, place);
  Prepare(place, program);
  LineVector<Real>* sums = sums_.data() + share * program.results.size() * 4;
  for (size_t i = 0; i < program.results.size() * 4; ++i) {
    if (program.results[i / 4].from[i % 4] != kNothing) std::fill_n(sums[i].begin(), rows, Real(0));
  }
  Real* const* sums_data = sums_data_.data() + share * program.results.size() * 4;
  for (uint64_t first = begin_of(share); first < begin_of(share + 1); ++first) {
    if (program.machine.pairs != nullptr) {
      LoadColumnsOfFirst(program, first, place);
      const PairsOfRow<Real> pairs{split_data_.data(), sums_data, place.uniforms.data(), first,
                                   rows};
      if (program.machine.pairs(&pairs) != 0) continue;
      ForEachRowOfSecond(program, first, rows, place, [&](uint64_t begin, size_t count) {
        NoteFault(ExplainPairs(pass, first, begin, count, place));
      });
      continue;
    }
    ForEachRowOfSecond(program, first, rows, place, [&](uint64_t begin, size_t count) {
      NoteFault(ExplainPairs(pass, first, begin, count, place));
      for (size_t g = 0; g < program.results.size(); ++g) {
        const ResultGroup& group = program.results[g];
        for (size_t k = 0; k < 4; ++k) {
          if (group.from[k] == kNothing) continue;
          Real* values = place.registers[group.from[k]];
          LineVector<Real>& sum = sums[4 * g + k];
          if (group.participant == kFirst) {
            sum[first] += kernels_.sum(values, count);
          } else {
            kernels_.add1(sum.data() + begin, count, values);
          }
        }
      }
    });
  }
}

/// Explains results of a block of pairs that are not finite, if there are any.
template <class Real>
std::optional<Fault> Evaluator<Real>::ExplainPairs(const Pass& pass, uint64_t first, uint64_t begin,
                                                   size_t count, Place& place) const {
  if (ResultsAreFinite(pass.program, count, place)) return std::nullopt;
  for (size_t i = 0; i < count; ++i) {
    place.rows[0][i] = static_cast<uint32_t>(first);
    place.rows[1][i] = static_cast<uint32_t>(begin + i);
  }
  return Explain(*pass.code, pass.program, count, begin, place);
}

template <class Real>
std::optional<Fault> Evaluator<Real>::ExplainPositions(const PassCode& pass) const {
  if (pass.kind != BlockKind::kPairs || pass.within == kNoNode) return std::nullopt;
  const Column& column = columns_[pass.position];
  const std::span values(column.data, 3 * RowsOf(pass.rows));
  const auto lost = std::ranges::find_if(values, [](Real value) { return !std::isfinite(value); });
  if (lost == values.end()) return std::nullopt;
  const auto row = static_cast<uint64_t>(lost - values.begin()) / 3;
  const text::Place where = PlaceOf(text_, pass.span.begin);
  return Fault{std::string(source_) + ":" + std::to_string(where.line) + ":" +
                   std::to_string(where.column) + ": the position of row " + std::to_string(row) +
                   " of " + pass.rows + " is not finite, so it has no distance to other rows",
               law_.properties[pass.position].name, row};
}

template <class Real>
void Evaluator<Real>::AddShares(const Pass& pass, uint64_t shares) {
  const Program& program = pass.program;
  auto body = [&](uint64_t begin, uint64_t end) {
    for (size_t g = 0; g < program.results.size(); ++g) {
      const ResultGroup& group = program.results[g];
      const Column& column = columns_[group.property];
      for (size_t k = 0; k < 4; ++k) {
        if (group.from[k] == kNothing || column.data == nullptr) continue;
        for (uint64_t share = 0; share < shares; ++share) {
          const LineVector<Real>& sum = sums_[(share * program.results.size() + g) * 4 + k];
          for (uint64_t i = begin; i < end; ++i) column.data[i * column.components + k] += sum[i];
        }
      }
    }
  };
  ParallelFor(host_, RowsOf(pass.code->rows), kGrain, body);
}

template <class Real>
std::optional<Fault> Evaluator<Real>::RunAllPairs(Pass& pass) {
  const uint64_t rows = RowsOf(pass.code->rows);
  SplitSecond(pass.program, rows);
  const uint64_t shares = std::clamp<uint64_t>(rows / 1024, 1, shares_);
  auto body = [&](uint64_t begin, uint64_t end) {
    for (uint64_t share = begin; share < end; ++share) RunShare(pass, share, shares);
  };
  ParallelFor(host_, shares, 1, body);
  AddShares(pass, shares);
  return std::move(fault_);
}

// --- faults -----------------------------------------------------------------------------------

/// Finds the part of a formula that produced a value that is not finite, for the first row with
/// such a result. Returns nothing if the value came from a column.
template <class Real>
std::optional<Fault> Evaluator<Real>::Explain(const PassCode& pass, const Program& program,
                                              size_t count, uint64_t begin,
                                              const Place& place) const {
  // Search for the first row with such a result, and for the result.
  size_t at = count;
  Load to{};
  for (const ResultGroup& group : program.results) {
    for (uint16_t k = 0; k < 4; ++k) {
      if (group.from[k] == kNothing) continue;
      for (size_t i = 0; i < at; ++i) {
        if (std::isfinite(place.registers[group.from[k]][i])) continue;
        at = i;
        to = {group.participant, group.property, k};
      }
    }
  }
  const auto output = std::find_if(pass.outputs.begin(), pass.outputs.end(),
                                   [&](const Output& each) { return each.to == to; });
  if (at == count || output == pass.outputs.end()) return std::nullopt;
  // Computes all values of that row again, one by one.
  const Graph& graph = law_.graph;
  std::vector<Real> values(graph.size());
  for (size_t i = 0; i < program.constants.size(); ++i)
    values[program.constants[i]] = place.uniforms[i];
  for (size_t i = 0; i < program.of_first.size(); ++i) {
    values[program.of_first[i]] = place.uniforms[program.constants.size() + i];
  }
  const auto is_there = [&](NodeId id) {
    return std::binary_search(program.constants.begin(), program.constants.end(), id) ||
           std::binary_search(program.of_first.begin(), program.of_first.end(), id);
  };
  for (NodeId id = 0; id <= output->value; ++id) {
    const Node& node = graph[id];
    if (is_there(id)) continue;
    if (node.operation == Operation::kLoad) {
      for (const LoadGroup& group : program.loads) {
        if (group.participant != node.load.participant || group.property != node.load.property)
          continue;
        const uint16_t from = group.to[node.load.component];
        if (from != kNothing) values[id] = place.registers[from][at];
      }
    } else if (node.a != kNoNode) {
      values[id] = ComputeIn<Real>(node.operation, values[node.a],
                                   node.b == kNoNode ? Real(0) : values[node.b],
                                   node.c == kNoNode ? Real(0) : values[node.c]);
    }
  }
  NodeId made = output->value;
  while (true) {
    const Node& node = graph[made];
    const bool choice = node.operation == Operation::kSelect;
    NodeId cause = kNoNode;
    for (const NodeId operand : {node.a, node.b, node.c}) {
      if (operand == kNoNode || std::isfinite(values[operand])) continue;
      if (choice && operand != (values[node.a] != 0 ? node.b : node.c)) continue;
      cause = operand;
      break;
    }
    if (cause == kNoNode) break;
    made = cause;
  }
  if (pass.checks_limits && graph[made].operation == Operation::kConstant) {
    return MakeLimitFault(*output, values[graph[output->value].b], begin + at);
  }
  if (graph[made].a == kNoNode) return std::nullopt;  // the value came from a column or a parameter
  std::vector<uint64_t> rows;
  if (pass.kind != BlockKind::kPairs) rows.push_back(begin + at);
  for (size_t k = 0; k < pass.participant_names.size(); ++k) rows.push_back(place.rows[k][at]);
  return MakeFault(pass, made, values, to, rows);
}

template <class Real>
Fault Evaluator<Real>::MakeLimitFault(const Output& output, Real value, uint64_t row) const {
  const text::Place where = PlaceOf(text_, output.span.begin);
  const PropertyCode& use = law_.properties[output.to.property];
  char number[32];
  std::snprintf(number, sizeof number, "%.6g", static_cast<double>(value));
  const std::string unit = use.dimension.IsOne() ? "" : " " + UnitName(use.dimension);
  const std::string limits(text_.substr(output.span.begin, output.span.end - output.span.begin));
  return {std::string(source_) + ":" + std::to_string(where.line) + ":" +
              std::to_string(where.column) + ": '" + use.name + "' is " + number + unit +
              " for row " + std::to_string(row) + " of " + use.kind + ", expected a value " +
              limits,
          use.name, row};
}

template <class Real>
Fault Evaluator<Real>::MakeFault(const PassCode& pass, NodeId made, const std::vector<Real>& values,
                                 const Load& to, const std::vector<uint64_t>& rows) const {
  const Node& node = law_.graph[made];
  std::string message = Located(source_, text_, node.span) + QuotedPart(text_, node.span) + " ";
  if (node.operation == Operation::kDivide && values[node.b] == 0) {
    message += "divides by zero";
  } else {
    message += std::isnan(values[made]) ? "has no value" : "is too large";
  }
  const bool pair = pass.kind == BlockKind::kPairs;
  message += pair ? " for rows " + std::to_string(rows[0]) + " and " + std::to_string(rows[1])
                  : " for row " + std::to_string(rows[0]);
  message += " of " + pass.rows;
  const size_t first = pair ? 1 : 0;
  const uint64_t row = rows[std::min<size_t>(
      to.participant - std::min<size_t>(first, to.participant), rows.size() - 1)];
  return {message, law_.properties[to.property].name, row};
}

}  // namespace vesper::text
