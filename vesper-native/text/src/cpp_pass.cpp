// SPDX-License-Identifier: Apache-2.0
#include "cpp_pass.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vesper::text {
namespace {

constexpr uint32_t kLongest = 12;  // maximum number of operations in one expression

}  // namespace

PassWriter::PassWriter(const LawCode& law, const PassCode& pass, const CppMembers& members,
                       CppNames names, bool energy, CppNeeds& needs)
    : law_(law),
      pass_(pass),
      members_(members),
      names_(std::move(names)),
      energy_(energy),
      needs_(needs),
      terms_(law, pass) {}

std::string PassWriter::Write(int indent) {
  indent_ = indent;
  NameRows();
  MakeRoots();
  Analyse();
  NameLocals();
  WriteUniforms();
  WriteLoop();
  return std::move(lines_);
}

std::string PassWriter::WriteField(const FieldCode& field, int indent) {
  indent_ = indent;
  of_field_ = true;
  for (uint32_t k = 0; k < field.components; ++k) {
    roots_.push_back({nullptr, false, terms_.OfNumber(field.values[k]), {}});
  }
  Analyse();
  NameLocals();
  WriteUniforms();
  for (uint32_t k = 0; k < field.components; ++k) {
    const std::string to =
        field.components == 1 ? "i" : "3 * i" + (k == 0 ? "" : " + " + std::to_string(k));
    Line("out[" + to + "] = " + Uniform(roots_[k].term, 0) + ";");
  }
  return std::move(lines_);
}

// --- analysis ---------------------------------------------------------------------------------

void PassWriter::NameRows() {
  row_ = names_.Take("i");
  for (const std::string& name : pass_.participant_names) {
    participants_.push_back(names_.Take(SnakeCase(name)));
  }
}

void PassWriter::MakeRoots() {
  if (energy_) {
    roots_.push_back({nullptr, false, terms_.OfNumber(pass_.energy), {}});
    return;
  }
  const std::vector<Output>& outputs = pass_.outputs;
  for (size_t i = 0; i < outputs.size(); ++i) {
    const Load& to = outputs[i].to;
    const auto belongs = [&](uint16_t k) {
      return i + k < outputs.size() && outputs[i + k].add == outputs[i].add &&
             outputs[i + k].to == Load{to.participant, to.property, k};
    };
    if (law_.properties[to.property].components == 3 && belongs(0) && belongs(1) && belongs(2)) {
      const std::array<NodeId, 3> nodes{outputs[i].value, outputs[i + 1].value,
                                        outputs[i + 2].value};
      roots_.push_back({&outputs[i], true, terms_.OfVector(nodes), {}});
      i += 2;
    } else {
      roots_.push_back({&outputs[i], false, terms_.OfNumber(outputs[i].value), {}});
    }
  }
}

void PassWriter::Analyse() {
  TermId within = 0;
  if (pass_.within != kNoNode) within = terms_.OfNumber(pass_.within);
  const size_t count = terms_.size();
  uses_.assign(count, 0);
  used_in_rows_.assign(count, false);
  sizes_.assign(count, 1);
  locals_.assign(count, {});
  for (const Root& root : roots_) {
    ++uses_[root.term];
    used_in_rows_[root.term] = true;
  }
  if (pass_.within != kNoNode) ++uses_[within];
  // The loop runs backwards, because parts have smaller numbers than the terms that use them.
  for (TermId id = static_cast<TermId>(count); id-- > 0;) {
    if (uses_[id] == 0) continue;
    for (const TermId part : terms_[id].parts) {
      ++uses_[part];
      if (!terms_[id].uniform || terms_[id].vector) used_in_rows_[part] = true;
    }
  }
}

/// Returns true if a term is computed once, before the loop.
bool PassWriter::IsUniformLocal(TermId id) const {
  const Term& term = terms_[id];
  if (!term.uniform || term.kind == TermKind::kConstant) return false;
  if (term.vector || term.kind == TermKind::kLoad) return !IsZeroVector(term);
  if (term.kind == TermKind::kParameter) return false;
  return used_in_rows_[id] || (!term.IsLeaf() && (uses_[id] > 1 || !term.name.empty()));
}

void PassWriter::AnalyseTerm(TermId id) {
  const Term& term = terms_[id];
  for (const TermId part : term.parts) sizes_[id] += locals_[part].empty() ? sizes_[part] : 1;
  const auto take = [&](const std::string& usual) {
    locals_[id] = names_.Take(term.name.empty() ? usual : SnakeCase(term.name));
  };
  if (term.uniform) {
    if (!IsUniformLocal(id)) return;
    if (term.kind == TermKind::kStep) {
      take("dt");
    } else if (term.kind == TermKind::kTime) {
      take("time");
    } else if (term.kind == TermKind::kStage) {
      take("stage");
    } else if (term.kind == TermKind::kLoad) {
      // All components of a constant of the world share one variable.
      for (TermId other = 0; other < id && locals_[id].empty(); ++other) {
        if (terms_[other].kind == TermKind::kLoad && terms_[other].uniform &&
            terms_[other].load.property == term.load.property) {
          locals_[id] = locals_[other];
        }
      }
      if (!locals_[id].empty()) return;
      needs_.constants_of_world = true;
      locals_[id] = names_.Take("world_" + SnakeCase(law_.properties[term.load.property].name));
    } else if (term.kind == TermKind::kParameter) {
      const std::string& name = law_.parameters[term.index].name;
      locals_[id] = names_.Take(SnakeCase(name.substr(0, name.size() - 2)));
    } else {
      take(term.vector ? "constant_vector" : of_field_ ? "value" : "constant");
    }
    return;
  }
  const bool is_named = !term.name.empty();
  if (term.kind == TermKind::kComponent && !is_named) return;
  if (is_named || (!term.IsLeaf() && (uses_[id] > 1 || sizes_[id] > kLongest))) {
    take(term.condition ? "condition" : term.vector ? "vector" : "value");
  }
}

/// Names a variable for each field that the pass reads at a row.
void PassWriter::NameFields() {
  for (TermId id = 0; id < terms_.size(); ++id) {
    const Term& term = terms_[id];
    if (uses_[id] == 0 || term.kind != TermKind::kLoad) continue;
    const PropertyCode& use = law_.properties[term.load.property];
    const std::pair at{term.load.participant, term.load.property};
    if (!use.is_field || fields_.contains(at)) continue;
    const std::string where = at.first == kOwnRow ? "_here" : "_of_" + RowOf(at.first);
    fields_.emplace(at, names_.Take(SnakeCase(use.name) + where));
  }
}

void PassWriter::NameLocals() {
  NameFields();
  std::vector<bool> split(terms_.size());  // vectors of which a component is taken
  for (TermId id = 0; id < terms_.size(); ++id) {
    if (uses_[id] > 0 && terms_[id].kind == TermKind::kComponent) split[terms_[id].parts[0]] = true;
  }
  for (TermId id = 0; id < terms_.size(); ++id) {
    if (uses_[id] == 0) continue;
    AnalyseTerm(id);
    if (split[id] && locals_[id].empty() && !terms_[id].IsLeaf()) {
      locals_[id] = names_.Take("vector");
    }
  }
  // All results are computed before the first is stored if several results are stored, or one of
  // them is read in the same pass.
  const bool is_read = std::any_of(roots_.begin(), roots_.end(), [&](const Root& root) {
    return root.output != nullptr && Reads(root.output->to);
  });
  if (energy_ || roots_.size() == 1 || !is_read) return;
  for (Root& root : roots_) {
    const bool keeps = !locals_[root.term].empty() || terms_[root.term].kind == TermKind::kConstant;
    if (keeps) continue;
    const std::string& property = law_.properties[root.output->to.property].name;
    root.local = names_.Take("new_" + SnakeCase(property));
  }
}

/// Returns true if the pass reads a property that it also changes.
bool PassWriter::Reads(const Load& load) const {
  for (TermId id = 0; id < terms_.size(); ++id) {
    const Term& term = terms_[id];
    if (uses_[id] > 0 && term.kind == TermKind::kLoad && term.load.property == load.property) {
      return true;
    }
  }
  return false;
}

// --- lines ------------------------------------------------------------------------------------

void PassWriter::Line(const std::string& line) {
  lines_ += CppLine(static_cast<size_t>(indent_), line);
}

void PassWriter::Open(const std::string& line) {
  Line(line);
  indent_ += 2;
}

void PassWriter::Close(const std::string& line) {
  indent_ -= 2;
  Line(line);
}

void PassWriter::WriteUniforms() {
  for (TermId id = 0; id < terms_.size(); ++id) {
    const Term& term = terms_[id];
    if (uses_[id] == 0 || !term.uniform || locals_[id].empty()) continue;
    const std::string name = locals_[id];
    if (term.kind == TermKind::kLoad) {
      const auto same = [&](TermId other) { return locals_[other] == name && uses_[other] > 0; };
      bool written = false;
      for (TermId other = 0; other < id; ++other) written = written || same(other);
      if (written) continue;
      const PropertyCode& use = law_.properties[term.load.property];
      const std::string first = "First(" + members_.properties[term.load.property] + ")";
      Line("const auto " + name + " = " + Converted(use, first, use.components == 3) + ";");
    } else if (term.vector) {
      std::string parts;
      for (uint32_t k = 0; k < 3; ++k) {
        std::string part;
        if (term.kind == TermKind::kParameter) {
          part = "Real(" + OfParameter(term.index + k) + ")";
        } else {
          part = Row(term.parts[k], 0);
        }
        parts += (k == 0 ? "" : ", ") + part;
      }
      Line("const Vec3<Real> " + name + "{" + parts + "};");
    } else {
      const std::string taken = std::exchange(locals_[id], {});  // its value, not its name
      const std::string value = Uniform(id, 0);
      locals_[id] = taken;
      Line(std::string(term.condition ? "const bool " : "const double ") + taken + " = " + value +
           ";");
    }
  }
}

void PassWriter::WriteFields() {
  for (const auto& [at, name] : fields_) {
    const PropertyCode& use = law_.properties[at.second];
    Line(std::string(use.components == 3 ? "const Vec3<Real> " : "const Real ") + name + " = " +
         members_.properties[at.second] + "(" + LoadOf({at.first, use.positions, 0}, true) + ");");
  }
}

void PassWriter::WriteLocals() {
  for (TermId id = 0; id < terms_.size(); ++id) {
    const Term& term = terms_[id];
    if (uses_[id] == 0 || term.uniform || locals_[id].empty()) continue;
    const std::string name = std::exchange(locals_[id], {});
    const std::string value = term.kind == TermKind::kVector ? RowVector(term, 0) : Typed(id);
    locals_[id] = name;
    if (term.kind == TermKind::kVector) {
      Line("const Vec3<Real> " + name + value.substr(value.find('{')) + ";");
    } else {
      Line("const " + TypeOf(term) + " " + name + " = " + value + ";");
    }
  }
  for (const Root& root : roots_) {
    if (root.local.empty()) continue;
    const std::string type = root.vector ? "Vec3<Real>" : "Real";
    Line("const " + type + " " + root.local + " = " + Typed(root.term) + ";");
  }
}

/// Stores a result in a property with another precision.
void PassWriter::StoreConverted(const Root& root) {
  needs_.precisions = true;
  const Load& to = root.output->to;
  const std::string value = root.local.empty() ? Typed(root.term) : root.local;
  const std::string sum = LoadOf(to, root.vector) + " + (" + value + ")";
  Line("Store(" + ElementOf(to, root.vector) + ", " + (root.output->add ? sum : value) + ");");
}

void PassWriter::WriteResult(const Root& root) {
  if (law_.properties[root.output->to.property].fixed_type != 0) {
    StoreConverted(root);
    return;
  }
  const std::string target = LoadOf(root.output->to, root.vector);
  if (!root.local.empty()) {
    Line(target + (root.output->add ? " += " : " = ") + root.local + ";");
    return;
  }
  const Term& term = terms_[root.term];
  const bool inlined = locals_[root.term].empty();
  if (root.output->add) {
    const bool negative =
        inlined && !term.uniform &&
        (term.kind == TermKind::kNegative ||
         (term.kind == TermKind::kOperation && term.operation == Operation::kNegate));
    Line(target + (negative ? " -= " + Typed(term.parts[0]) : " += " + Typed(root.term)) + ";");
    return;
  }
  const bool sum = inlined && !term.uniform &&
                   (term.kind == TermKind::kSum ||
                    (term.kind == TermKind::kOperation && term.operation == Operation::kAdd));
  for (size_t k = 0; sum && k < 2; ++k) {
    if (Typed(term.parts[k]) != target) continue;
    Line(target + " += " + Typed(term.parts[1 - k]) + ";");
    return;
  }
  Line(target + " = " + Typed(root.term) + ";");
}

void PassWriter::WriteResults() {
  if (energy_) {
    Line("energy += " + std::string(terms_[roots_[0].term].uniform ? "" : "double") + "(" +
         Typed(roots_[0].term) + ");");
    return;
  }
  for (const Root& root : roots_) WriteResult(root);
}

void PassWriter::WriteBody() {
  WriteFields();
  WriteLocals();
  WriteResults();
}

/// Returns an expression for the number of rows of the pass.
std::string PassWriter::RowsOfPass() {
  const std::string* optional = nullptr;
  for (size_t i = 0; i < law_.properties.size(); ++i) {
    const PropertyCode& property = law_.properties[i];
    if (property.kind != pass_.rows || property.is_field) continue;
    if (!property.optional) return members_.properties[i] + ".size()";
    optional = &members_.properties[i];
  }
  return optional == nullptr ? "0" : *optional + ".size()";
}

void PassWriter::WriteLoop() {
  const std::string rows = RowsOfPass();
  const std::string& i = row_;
  if (pass_.kind == BlockKind::kRows) {
    WriteLoopOverRows();
    return;
  }
  if (pass_.kind == BlockKind::kJoined) {
    Open("for (uint64_t " + i + " = 0; " + i + " < " + rows + "; ++" + i + ") {");
    for (size_t k = 0; k < participants_.size(); ++k) {
      const Load& reference = pass_.references[k];
      const bool single = law_.properties[reference.property].components == 1;
      Line("[[maybe_unused]] const uint32_t " + participants_[k] + " = " +
           members_.properties[reference.property] + "[" + i + "]" +
           (single ? "" : "[" + std::to_string(reference.component) + "]") + ";");
    }
    WriteBody();
    Close();
    return;
  }
  const std::string &a = participants_[0], &b = participants_[1];
  if (pass_.within != kNoNode) {
    const std::string& position = members_.properties[pass_.position];
    const std::string cutoff = names_.Take("cutoff");
    Line("const double " + cutoff + " = " + Uniform(terms_.OfNumber(pass_.within), 0) + ";");
    if (!energy_) {
      needs_.finite = true;
      Line("if (" + cutoff + " > 0) RequireFinite(" + position + ");");
    }
    Open(members_.neighbours + ".ForEachPair(" + position + ".data(), " + position + ".size(), " +
         cutoff + ", [&](uint32_t " + a + ", uint32_t " + b + ") {");
    WriteBody();
    Close("});");
    return;
  }
  Open("for (uint64_t " + a + " = 0; " + a + " < " + rows + "; ++" + a + ") {");
  Open("for (uint64_t " + b + " = " + a + " + 1; " + b + " < " + rows + "; ++" + b + ") {");
  WriteBody();
  Close();
  Close();
}

void PassWriter::WriteLoopOverRows() {
  const std::string rows = RowsOfPass();
  const std::string& i = row_;
  if (energy_) {
    Open("for (uint64_t " + i + " = 0; " + i + " < " + rows + "; ++" + i + ") {");
    WriteBody();
    Close();
    return;
  }
  needs_.grain = needs_.step = true;
  Open("step.ParallelFor(" + rows + ", kGrain, [&](uint64_t begin, uint64_t end) {");
  Open("for (uint64_t " + i + " = begin; " + i + " < end; ++" + i + ") {");
  WriteBody();
  Close();
  Close("});");
}

}  // namespace vesper::text
