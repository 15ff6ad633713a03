// SPDX-License-Identifier: Apache-2.0
#include "checker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>

#include "nearest_name.hpp"
#include "unit.hpp"
#include "vesper/engine.h"

namespace vesper::text {
namespace {

constexpr size_t kMostDeclared = 200;  // properties, and also parameters, of a law

}  // namespace

vesper_access PropertyCode::Access() const {
  if (own) return VESPER_SCRATCH;
  if (added) return VESPER_ACCUMULATE;
  if (modified || (stored && read)) return VESPER_READ_WRITE;
  return stored ? VESPER_WRITE : VESPER_READ;
}

Checker::Checker(std::string_view text, const LawTree& tree, const Prototype& prototype,
                 Problems& problems)
    : text_(text),
      tree_(tree),
      prototype_(prototype),
      problems_(problems),
      world_kind_(prototype.FindKind("world")) {
  if (world_kind_ == kNone) world_kind_ = UINT32_MAX - 1;  // equals no property's kind
}

LawCode Checker::Run() {
  code_.name = tree_.name.word;
  code_.doc = tree_.doc.empty() ? "A law as text." : tree_.doc;
  code_.version = tree_.version;
  try {
    Declare();
    if (tree_.blocks.empty() && tree_.fields.empty() && problems_.empty()) {
      problems_.Add(tree_.name.span, "the law has no block, so it acts on nothing",
                    "add one, such as: each body:");
    }
    code_.passes.reserve(tree_.blocks.size() + tree_.owned.size());
    for (const Block& block : tree_.blocks) {
      if (problems_.full()) break;
      try {
        CheckBlock(block);
      } catch (const Abandon&) {
        block_ = nullptr;
        effects_ = nullptr;
      }
    }
    if (!problems_.empty()) return std::move(code_);
    CheckLimits();
    DerivePhase();
    FinishProperties();
    if (!problems_.empty()) return std::move(code_);
    code_.claims = DeriveClaims(code_, uses_axes_);
    std::vector<NodeId*> roots;
    for (PassCode& pass : code_.passes) {
      for (Output& output : pass.outputs) roots.push_back(&output.value);
      if (pass.energy != kNoNode) roots.push_back(&pass.energy);
      if (pass.within != kNoNode) roots.push_back(&pass.within);
    }
    const std::vector<NodeId> copies = graph_.ShareDivisions(roots);
    for (PassCode& pass : code_.passes) {
      for (NamedValue& named : pass.names) {
        for (NodeId& node : named.node) {
          if (node != kNoNode) node = copies[node];
        }
      }
    }
  } catch (const Abandon&) {
  } catch (const TooLarge&) {
    problems_.Add(tree_.name.span, "the law is too large: its formulas have more than 10000 parts");
  }
  return std::move(code_);
}

/// Requires that a value depends on the place of a field, the time, parameters and numbers only.
void Checker::RequireOfPlace(NodeId value, Span span) {
  for (const NodeId id : graph_.Ordered(value)) {
    const Node& node = graph_[id];
    std::string other;
    if (node.operation == Operation::kStep) other = "dt";
    if (node.operation == Operation::kStage) other = "stage";
    if (node.operation == Operation::kLoad) other = code_.properties[node.load.property].name;
    if (other.empty()) continue;
    problems_.Fail(span,
                   "a field depends on its place, on the time, on parameters and on numbers, but "
                   "this one depends on '" +
                       other + "'");
  }
}

void Checker::DeclareField(const FieldTree& tree) {
  const std::string name = "'" + tree.name.word + "'";
  const uint32_t found = FindField(tree.name.word);
  if (found == kNone) {
    problems_.Fail(tree.name.span, "this world declares no field " + name,
                   "declare it under `properties` of the world file: {name: " + tree.name.word +
                       ", kind: world, type: field, components: 3, unit: …}");
  }
  const PropertySpec& spec = prototype_.properties()[found];
  if (spec.components != 1 && spec.components != 3) {
    problems_.Fail(tree.name.span, name + " has " + std::to_string(spec.components) +
                                       " components; a law as text provides numbers and vectors");
  }
  for (const FieldCode& known : code_.fields) {
    if (known.name != tree.name.word) continue;
    problems_.Fail(tree.name.span, "the law provides " + name + " already");
  }
  RequireNewName(tree.place);
  FieldCode field{.name = spec.name,
                  .doc = tree.doc.empty() ? "A field of a law as text." : tree.doc,
                  .components = spec.components,
                  .dimension = DimensionOf(spec.unit),
                  .values = {kNoNode, kNoNode, kNoNode},
                  .program = {},
                  .slopes = {}};
  Value place;
  place.dimension = kLength;
  place.components = 3;
  for (uint16_t i = 0; i < 3; ++i) {
    place.node[i] = graph_.Parameter(kPlaceParameter + i);
  }
  lets_.clear();
  lets_.emplace_back(tree.place.word, place);
  for (const Statement& let : tree_.lets) CheckLet(let);
  Value value = Evaluate(*tree.value);
  value.span = tree.value->span;
  RequireQuantity(value);
  if (value.any_unit && value.components == 1 && spec.components == 3) {
    value.components = 3;
    value.node[1] = value.node[2] = value.node[0];
  }
  if (value.components != spec.components) {
    problems_.Fail(value.span, Quoted(value.span) +
                                   (value.IsVector() ? " is a vector" : " is a number") +
                                   ", but the field " + name +
                                   (spec.components == 3 ? " is a vector" : " is a number"));
  }
  RequireUnit(value, field.dimension, name);
  for (uint32_t i = 0; i < 3; ++i) {
    field.values[i] = i < spec.components ? value.node[i] : kNoNode;
    if (field.values[i] != kNoNode) RequireOfPlace(field.values[i], value.span);
  }
  field.program = FieldProgram(graph_, std::span(field.values).first(spec.components));
  if (field.program.size() > FieldProgram::kMostNodes) {
    problems_.Fail(value.span, "the field is too large: its formula has more than " +
                                   std::to_string(FieldProgram::kMostNodes) + " parts");
  }
  field.slopes =
      FieldProgram::WithSlopes(graph_, std::span(field.values).first(spec.components), value.span);
  lets_.clear();
  code_.fields.push_back(std::move(field));
}

void Checker::Declare() {
  for (const Ownership& owned : tree_.owned) {
    if (problems_.full()) return;
    try {
      DeclareOwned(owned);
    } catch (const Abandon&) {
      failed_.insert(owned.name.word);
    }
  }
  for (const ParameterTree& parameter : tree_.parameters) {
    if (problems_.full()) return;
    try {
      DeclareParameter(parameter);
    } catch (const Abandon&) {
      failed_.insert(parameter.name.word);
    }
  }
  for (const FieldTree& field : tree_.fields) {
    if (problems_.full()) return;
    try {
      DeclareField(field);
    } catch (const Abandon&) {
      lets_.clear();
    }
  }
}

double Checker::ConstantOf(const Value& value) const { return graph_[value.node[0]].value; }

Value Checker::ConstantExpression(const Expression& tree, const char* what) {
  Value value = Evaluate(tree);
  RequireQuantity(value);
  for (uint32_t i = 0; i < value.components; ++i) {
    if (graph_.IsConstant(value.node[i])) continue;
    problems_.Fail(tree.span, std::string(what) + " must be a number, found " + Quoted(tree.span),
                   "values that depend on others begin with let");
  }
  return value;
}

void Checker::DeclareParameter(const ParameterTree& tree) {
  RequireNewName(tree.name);
  if (tree.name.word.size() > 40) {
    problems_.Fail(tree.name.span, "the name has more than 40 letters");
  }
  Value value = ConstantExpression(*tree.value, "the value of a parameter");
  if (value.IsRotation()) problems_.Fail(tree.value->span, "a parameter is a number or a vector");
  double minimum = -std::numeric_limits<double>::max();
  double maximum = std::numeric_limits<double>::max();
  if (tree.minimum != nullptr) {
    Value low = ConstantExpression(*tree.minimum, "the least value of a parameter");
    Value high = ConstantExpression(*tree.maximum, "the greatest value of a parameter");
    RequireNumber(low, "the least value");
    RequireNumber(high, "the greatest value");
    if (high.dimension.IsOne() && !high.any_unit && !value.dimension.IsOne()) {
      RequireUnit(high, value.dimension, "'" + tree.name.word + "'");
    }
    RequireUnit(high, value.dimension, "'" + tree.name.word + "'");
    RequireUnit(low, value.dimension, "'" + tree.name.word + "'");
    minimum = ConstantOf(low);
    maximum = ConstantOf(high);
    if (minimum > maximum) {
      problems_.Fail(Join(tree.minimum->span, tree.maximum->span),
                     "the least value is above the greatest");
    }
  }
  Parameter parameter{tree.name.word, value};
  for (uint32_t i = 0; i < value.components; ++i) {
    const double component = graph_[value.node[i]].value;
    if (component < minimum || component > maximum || !std::isfinite(component)) {
      problems_.Fail(tree.value->span, "the value is not between the least and the greatest one");
    }
    ParameterCode code;
    code.name = tree.name.word;
    if (value.components == 3) code.name += std::string("_") + "xyz"[i];
    code.doc = tree.doc.empty() ? "Parameter " + tree.name.word + "." : tree.doc;
    code.dimension = value.dimension;
    code.value = component;
    code.minimum = minimum;
    code.maximum = maximum;
    if (!value.dimension.IsWhole())
      problems_.Fail(tree.value->span, "its unit is no unit of columns");
    const auto same_name = [&](const ParameterCode& known) { return known.name == code.name; };
    if (std::any_of(code_.parameters.begin(), code_.parameters.end(), same_name)) {
      problems_.Fail(tree.name.span, "a parameter '" + code.name + "' is there already");
    }
    parameter.value.node[i] = graph_.Parameter(static_cast<uint32_t>(code_.parameters.size()));
    code_.parameters.push_back(std::move(code));
    if (code_.parameters.size() > kMostDeclared) {
      problems_.Fail(tree.name.span,
                     "the law has over " + std::to_string(kMostDeclared) + " parameters");
    }
  }
  parameter.value.any_unit = false;
  parameters_.push_back(std::move(parameter));
}

uint32_t Checker::KindOf(const Name& name, bool plural) const {
  const auto& kinds = prototype_.kinds();
  for (uint32_t i = 0; i < kinds.size(); ++i) {
    const bool matches = name.word == kinds[i] || (plural && name.word == Plural(i));
    if (matches) return i;
  }
  std::string hint;
  for (uint32_t i = 0; i < kinds.size(); ++i) {
    if (!plural && name.word == Plural(i)) hint = "write each " + kinds[i];
  }
  std::string known;
  for (uint32_t i = 0; i < kinds.size(); ++i) {
    if (i == world_kind_) continue;
    known += (known.empty() ? "" : ", ") + (plural ? Plural(i) : kinds[i]);
  }
  if (hint.empty()) hint = "kinds of this world are " + known;
  problems_.Fail(name.span, "there is no kind '" + name.word + "'", hint);
}

void Checker::DeclareOwned(const Ownership& tree) {
  if (owned_.size() == kMostDeclared) {
    problems_.Fail(tree.name.span,
                   "the law declares over " + std::to_string(kMostDeclared) + " properties");
  }
  const uint32_t kind = KindOf(tree.rows, false);
  if (kind == world_kind_) {
    problems_.Fail(tree.rows.span, "the world has one row of constants",
                   "declare a constant by: parameter " + tree.name.word + " = VALUE UNIT");
  }
  if (IsFunction(tree.name.word)) {
    problems_.Fail(tree.name.span, "'" + tree.name.word + "' is a function; choose another name");
  }
  if (FindOwned(kind, tree.name.word) < owned_.size()) {
    problems_.Fail(tree.name.span, "'" + tree.name.word + "' is declared twice");
  }
  Owned owned{&tree, kind, tree.unit ? DimensionOf(*tree.unit) : kNumber};
  const uint32_t found = FindProperty(kind, tree.name.word);
  if (found != kNone) {
    const PropertySpec& spec = prototype_.properties()[found];
    if (tree.unit && DimensionOf(spec.unit) != owned.dimension) {
      problems_.Fail(tree.unit_span,
                     "'" + tree.name.word + "' of this world is in " +
                         UnitName(DimensionOf(spec.unit)) + ", found " + UnitName(owned.dimension),
                     "write in " + UnitName(DimensionOf(spec.unit)) + ", or choose another name");
    }
    if (!tree.optional && !tree.unit && !DimensionOf(spec.unit).IsOne()) {
      problems_.Fail(tree.name.span, Plural(kind) + " have '" + tree.name.word + "' already",
                     "use it without declaring it");
    }
    owned.dimension = DimensionOf(spec.unit);
  } else if (tree.optional && !tree.unit) {
    const vesper_prototype* standard = vesper_prototype_standard("si-f64");
    for (uint32_t i = 0; i < standard->property_count; ++i) {
      const vesper_property_descriptor& known = standard->properties[i];
      if (tree.name.word == known.name) owned.dimension = DimensionOf(known.unit);
    }
  }
  try {
    if (tree.minimum != nullptr) ReadLimits(owned);
  } catch (const Abandon&) {
    // The property exists, so that its uses are no further problems.
  }
  owned_.push_back(owned);
}

void Checker::ReadLimits(Owned& owned) {
  const Ownership& tree = *owned.tree;
  const std::string name = "'" + tree.name.word + "'";
  if (tree.optional) {
    problems_.Fail(tree.limits_span, name + " is a property of the world, which sets its limits",
                   "only properties of the law's own (has) have limits in a text");
  }
  const auto limit = [&](const Expression& expression, const char* what) {
    Value value = ConstantExpression(expression, what);
    RequireNumber(value, what);
    RequireUnit(value, owned.dimension, name);
    return ConstantOf(value);
  };
  owned.minimum = limit(*tree.minimum, "the least value");
  if (tree.maximum != nullptr) owned.maximum = limit(*tree.maximum, "the greatest value");
  if (owned.minimum > 0 || owned.maximum < 0) {
    problems_.Fail(tree.limits_span, name + " is 0 at the start, which these limits exclude",
                   "choose limits that include 0, or declare the property in the world file");
  }
}

void Checker::CheckLimits() {
  for (size_t i = 0; i < owned_.size(); ++i) {
    const Owned& owned = owned_[i];
    const Ownership& tree = *owned.tree;
    if (tree.minimum == nullptr || FindProperty(owned.kind, tree.name.word) != kNone) continue;
    const uint16_t property = UseOwned(i);
    PassCode pass{};
    pass.kind = BlockKind::kRows;
    pass.checks_limits = true;
    pass.span = Join(tree.name.span, tree.limits_span);
    pass.rows = prototype_.kinds()[owned.kind];
    graph_.At(tree.limits_span);
    for (uint16_t component = 0; component < tree.components; ++component) {
      const Load load{kOwnRow, property, component};
      const NodeId value = graph_.LoadOf(load);
      NodeId inside = graph_.Binary(Operation::kLessOrEqual, graph_.Constant(owned.minimum), value);
      if (tree.maximum != nullptr) {
        inside = graph_.Binary(
            Operation::kAnd, inside,
            graph_.Binary(Operation::kLessOrEqual, value, graph_.Constant(owned.maximum)));
      }
      const NodeId none = graph_.Constant(std::numeric_limits<double>::quiet_NaN());
      pass.outputs.push_back({load, false, graph_.Select(inside, value, none), tree.limits_span});
    }
    code_.passes.push_back(std::move(pass));
  }
}

/// Requires that a law of phase observe sets only properties that it declares, and none of those
/// that every world has.
void Checker::RequireOnlyOwnChanges() {
  const vesper_prototype* standard = vesper_prototype_standard("si-f64");
  for (const PropertyCode& use : code_.properties) {
    if (use.own || use.set_at.end == 0) continue;
    const std::span known(standard->properties, standard->property_count);
    const bool is_standard =
        std::any_of(known.begin(), known.end(), [&](const vesper_property_descriptor& property) {
          return use.name == property.name && use.kind == property.kind;
        });
    const size_t declared = FindOwned(prototype_.FindKind(use.kind), use.name);
    if (!is_standard && declared < owned_.size()) continue;
    problems_.Fail(
        use.set_at,
        Quoted(use.set_at) +
            " cannot be set in phase observe, which only records the result of the step",
        "set a property that the law declares by: each " + use.kind + " has NAME in UNIT");
  }
}

void Checker::DerivePhase() {
  const bool declared = tree_.phase.has_value();
  const std::string phase = declared ? tree_.phase->word : added_force_ ? "force" : "constrain";
  code_.phase = phase == "force"       ? VESPER_PHASE_FORCE
                : phase == "integrate" ? VESPER_PHASE_INTEGRATE
                : phase == "constrain" ? VESPER_PHASE_CONSTRAIN
                                       : VESPER_PHASE_OBSERVE;
  if (added_force_ && code_.phase != VESPER_PHASE_FORCE) {
    problems_.Fail(tree_.phase->span, "a law that adds forces is of phase force, found " + phase,
                   "remove the line, because force is the phase of such laws");
  }
  if (code_.phase == VESPER_PHASE_OBSERVE) RequireOnlyOwnChanges();
  if (code_.phase != VESPER_PHASE_INTEGRATE) {
    if (tree_.stages != 1 || !tree_.weights.empty()) {
      problems_.Fail(tree_.phase->span, "only laws of phase integrate have stages");
    }
    if (uses_stage_) {
      problems_.Fail(tree_.name.span, "only laws of phase integrate have stages",
                     "add the line: phase integrate");
    }
    return;
  }
  code_.stages = tree_.stages;
  code_.first_stage = uses_stage_ ? 0 : 1;
  if (tree_.weights.empty()) return;
  double sum = 0;
  for (const ExpressionTree& weight : tree_.weights) {
    const Value value = ConstantExpression(*weight, "a weight");
    RequireNumber(value, "a weight");
    code_.force_weights.push_back(ConstantOf(value));
    sum += code_.force_weights.back();
  }
  if (code_.force_weights.size() != code_.stages + 1 || std::abs(sum - 1) > 1e-9) {
    problems_.Fail(tree_.phase->span,
                   "expected one weight before the step and one for each stage, "
                   "with the sum 1");
  }
}

/// Derives the access of each property from the formulas.
void Checker::FinishProperties() {
  std::set<std::pair<uint16_t, uint16_t>> stored_in;
  for (PassCode& pass : code_.passes) {
    std::vector<NodeId> roots;
    for (const Output& output : pass.outputs) roots.push_back(output.value);
    if (pass.energy != kNoNode) roots.push_back(pass.energy);
    if (pass.within != kNoNode) roots.push_back(pass.within);
    for (const NodeId root : roots) {
      for (const Load& load : graph_.LoadsOf(root)) {
        PropertyCode& use = code_.properties[load.property];
        use.read = true;
        if (use.accumulator && code_.phase == VESPER_PHASE_FORCE) {
          const Span span = graph_[graph_.LoadOf(load)].span;
          problems_.Fail(span,
                         Quoted(span) +
                             " is being summed by the laws of phase force, so this law cannot "
                             "read it");
        }
      }
    }
    for (const Output& output : pass.outputs) {
      PropertyCode& use = code_.properties[output.to.property];
      if (output.add) {
        (use.accumulator ? use.added : use.modified) = true;
      } else {
        // Other values stay as they are if this pass does not store all components of every row.
        // The property then counts as modified and not as stored.
        const size_t components = static_cast<size_t>(
            std::count_if(pass.outputs.begin(), pass.outputs.end(), [&](const Output& other) {
              return other.to.property == output.to.property && !other.add;
            }));
        const bool every_row =
            components == use.components && !pass.stage && pass.kind == BlockKind::kRows;
        (every_row ? use.stored : use.modified) = true;
      }
    }
  }
  for (const PropertyCode& use : code_.properties) {
    const uint32_t kind = prototype_.FindKind(use.kind);
    const uint32_t found = FindProperty(kind, use.name);
    if (found == kNone || use.own) continue;
    const vesper_access lacking = use.Access() & ~prototype_.properties()[found].law_access;
    if (lacking == 0) continue;
    problems_.Fail(use.set_at, "'" + use.name + "' may be set by laws, but not read",
                   "set it for every row, without conditions that leave it as it is");
  }
  for (const bool own : {false, true}) {
    for (uint32_t i = 0; i < code_.properties.size(); ++i) {
      const PropertyCode& use = code_.properties[i];
      if (use.own == own && (!use.is_field || use.first_of_field == i)) {
        code_.table_order.push_back(i);
      }
    }
  }
  if (code_.properties.size() > 200) {
    problems_.Fail(tree_.name.span, "the law uses over 200 properties");
  }
}

LawCode Check(std::string_view text, const LawTree& law, const Prototype& prototype,
              Problems& problems) {
  return Checker(text, law, prototype, problems).Run();
}

}  // namespace vesper::text
