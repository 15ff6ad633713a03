// SPDX-License-Identifier: Apache-2.0
// Checks of the blocks and statements of a law text.
#include <algorithm>

#include "checker.hpp"
#include "nearest_name.hpp"
#include "unit.hpp"

namespace vesper::text {

void Checker::CheckBlock(const Block& block) {
  code_.passes.emplace_back();
  pass_ = &code_.passes.back();
  block_ = &block;
  lets_.resize(0);
  participants_.clear();
  separation_ = direction_ = {kNoNode, kNoNode, kNoNode};
  distance_ = kNoNode;
  row_kind_ = KindOf(block.rows, block.kind == BlockKind::kPairs);
  pass_->kind = block.kind;
  pass_->span = block.span;
  pass_->rows = prototype_.kinds()[row_kind_];
  pass_->stage = block.stage;
  uses_stage_ = uses_stage_ || block.stage.has_value();
  if (block.kind == BlockKind::kJoined) OpenJoined(block);
  if (block.kind == BlockKind::kPairs) OpenPairs(block);
  if (block.kind == BlockKind::kRows && row_kind_ == world_kind_) {
    problems_.Fail(block.rows.span, "the world has one row of constants, which laws only read");
  }
  Effects effects;
  effects_ = &effects;
  checked_lets_ += tree_.lets.size();
  if (checked_lets_ > kMostLets) {
    problems_.Fail(block.span,
                   "the " + std::to_string(tree_.lets.size()) +
                       " lets of the law are evaluated in each of its " +
                       std::to_string(tree_.blocks.size()) + " blocks, more than " +
                       std::to_string(kMostLets) + " times in all",
                   "write a let into the block that uses it");
  }
  for (const Statement& let : tree_.lets) {
    try {
      CheckLet(let);
    } catch (const Abandon&) {
    }
  }
  CheckStatements(block.statements, effects);
  FinishEnergy(block, effects);
  FinishBlock(block, effects);
  effects_ = nullptr;
  block_ = nullptr;
  pass_ = nullptr;
}

void Checker::OpenJoined(const Block& block) {
  for (uint32_t i = 0; i < prototype_.properties().size(); ++i) {
    const PropertySpec& spec = prototype_.properties()[i];
    if (spec.kind != row_kind_ || spec.refers_to == kNone) continue;
    for (uint16_t component = 0; component < spec.components; ++component) {
      if (participants_.size() == block.participants.size()) break;
      const Name& name = block.participants[participants_.size()];
      if (IsProperty(row_kind_, name.word)) {
        problems_.Fail(name.span,
                       "'" + name.word + "' is a property of " + Plural(row_kind_) + " already",
                       "choose another name for the row that it refers to");
      }
      RequireNewName(name);
      const uint16_t property = UseProperty(i);
      code_.properties[property].read = true;
      pass_->references.push_back({kOwnRow, property, component});
      participants_.emplace_back(name.word, spec.refers_to);
      pass_->participant_names.push_back(name.word);
    }
  }
  if (participants_.size() < block.participants.size()) {
    problems_.Fail(block.participants[participants_.size()].span,
                   participants_.empty() ? Plural(row_kind_) + " refer to no other rows"
                                         : Plural(row_kind_) + " refer to " +
                                               std::to_string(participants_.size()) + " rows only");
  }
  if (participants_.size() == 2 && participants_[0].second == participants_[1].second) {
    OpenSeparation(block);
  } else if (block.distance) {
    problems_.Fail(block.distance->span, "a distance needs two rows of one kind");
  }
}

void Checker::OpenPairs(const Block& block) {
  const uint32_t kind = row_kind_;
  row_kind_ = kNone;
  if (block.participants.empty()) {
    participants_ = {{"a", kind}, {"b", kind}};
  } else {
    for (const Name& name : block.participants) {
      RequireNewName(name);
      participants_.emplace_back(name.word, kind);
    }
  }
  for (const auto& [name, unused] : participants_) pass_->participant_names.push_back(name);
  OpenSeparation(block);
  if (block.within == nullptr) {
    if (block.edge != Edge::kUnsaid) {
      problems_.Fail(block.edge_span, "an energy is cut only where the block says within");
    }
    return;
  }
  effects_ = nullptr;
  Value within = Evaluate(*block.within);
  RequireNumber(within, "a distance");
  RequireUnit(within, kLength, "the distance behind 'within'");
  if (!graph_[within.node[0]].uniform) {
    problems_.Fail(block.within->span,
                   "the distance behind 'within' must be the same for all pairs",
                   "use parameters and constants here, and a condition in the block: if " +
                       std::string("r < ") + Source(block.within->span) + ":");
  }
  if (graph_.IsConstant(within.node[0]) && graph_[within.node[0]].value <= 0) {
    problems_.Fail(block.within->span, "the distance behind 'within' must be above 0");
  }
  pass_->within = within.node[0];
}

/// Defines the values `distance` and `direction` of a block's two participants, if their kind has
/// positions.
void Checker::OpenSeparation(const Block& block) {
  const uint32_t property = FindProperty(participants_[0].second, "position");
  const auto fail = [&](Span span) {
    problems_.Fail(span, Plural(participants_[0].second) + " have no position");
  };
  if (property == kNone || prototype_.properties()[property].components != 3) {
    if (block.distance) fail(block.distance->span);
    if (block.within != nullptr) fail(block.within->span);
    return;
  }
  pass_->position = UseProperty(property);
  code_.properties[pass_->position].read =
      code_.properties[pass_->position].read || block.within != nullptr;
  graph_.At(block.distance ? block.distance->span : block.span);
  NodeId square = graph_.Constant(0);
  for (uint16_t i = 0; i < 3; ++i) {
    separation_[i] = graph_.Subtract(graph_.LoadOf({kFirst + 1, pass_->position, i}),
                                     graph_.LoadOf({kFirst, pass_->position, i}));
    square = graph_.Add(square, graph_.Multiply(separation_[i], separation_[i]));
  }
  distance_ = graph_.Sqrt(square);
  const NodeId zero = graph_.Constant(0);
  const NodeId inverse = graph_.Select(graph_.Binary(Operation::kEqual, distance_, zero), zero,
                                       graph_.Divide(graph_.Constant(1), distance_));
  for (uint32_t i = 0; i < 3; ++i) direction_[i] = graph_.Multiply(inverse, separation_[i]);
  const Value distance = Number(distance_, kLength, block.span);
  Value separation, direction;
  separation.components = direction.components = 3;
  for (uint32_t i = 0; i < 3; ++i) {
    separation.node[i] = separation_[i];
    direction.node[i] = direction_[i];
  }
  NoteName("separation", separation);
  NoteName(block.distance ? block.distance->word : "distance", distance);
  NoteName(block.direction ? block.direction->word : "direction", direction);
  if (block.distance) {
    RequireNewName(*block.distance);
    lets_.emplace_back(block.distance->word, distance);
  }
  if (block.direction) {
    RequireNewName(*block.direction);
    direction.span = block.direction->span;
    lets_.emplace_back(block.direction->word, direction);
  }
}

void Checker::CheckStatements(const std::vector<Statement>& statements, Effects& effects) {
  const size_t outer = lets_.size();
  for (const Statement& statement : statements) {
    effects_ = &effects;
    try {
      CheckStatement(statement, effects);
    } catch (const Abandon&) {
      // Further statements are still checked.
    }
  }
  effects_ = &effects;
  lets_.resize(outer);
}

void Checker::CheckStatement(const Statement& statement, Effects& effects) {
  switch (statement.kind) {
    case StatementKind::kLet:
      CheckLet(statement);
      break;
    case StatementKind::kIf:
      CheckIf(statement, effects);
      break;
    case StatementKind::kAssign:
    case StatementKind::kAdd:
    case StatementKind::kSubtract: {
      const Expression& target = *statement.target;
      if (target.kind == ExpressionKind::kName && target.word == "energy" &&
          !IsProperty(row_kind_, "energy")) {
        AssignEnergy(statement, effects);
      } else if (target.kind == ExpressionKind::kName &&
                 (target.word == "attraction" || target.word == "repulsion") &&
                 !IsProperty(row_kind_, target.word)) {
        AssignPull(statement, effects);
      } else {
        Assign(statement, effects);
      }
      break;
    }
  }
}

void Checker::CheckLet(const Statement& statement) {
  RequireNewName(statement.name);
  try {
    Value value = Evaluate(*statement.value);
    value.span = statement.value->span;
    lets_.emplace_back(statement.name.word, value);
    NoteName(statement.name.word, value);
  } catch (const Abandon&) {
    failed_.insert(statement.name.word);
    throw;
  }
}

void Checker::NoteName(const std::string& name, const Value& value) {
  if (pass_ != nullptr) pass_->names.push_back({name, value.components, value.node});
}

void Checker::CheckIf(const Statement& statement, Effects& effects) {
  const Value condition = Evaluate(*statement.value);
  if (!condition.condition) {
    problems_.Fail(condition.span, Quoted(condition.span) + " is no condition",
                   "compare two values, such as: if r < 1 m:");
  }
  const auto branch = [&](const std::vector<Statement>& statements) {
    Effects inner;
    inner.stored = effects.stored;
    // The copy contains the sums so far, so statements inside `if` cannot read these sums either.
    CheckStatements(statements, inner);
    return inner;
  };
  const Effects then = branch(statement.then);
  const Effects otherwise = branch(statement.otherwise);
  effects_ = &effects;
  graph_.At(statement.span);
  const auto in_branch = [&](const Effects& inner, const Load& load) {
    const auto found = inner.stored.find(load);
    return found != inner.stored.end() ? found->second.first : graph_.LoadOf(load);
  };
  for (const Effects* inner : {&then, &otherwise}) {
    for (const auto& [load, value] : inner->stored) {
      effects.stored.insert_or_assign(
          load, std::pair(graph_.Select(condition.node[0], in_branch(then, load),
                                        in_branch(otherwise, load)),
                          value.second));
    }
  }
  const NodeId zero = graph_.Constant(0);
  const auto sum_in = [&](const Effects& inner, const Load& load) {
    const auto found = inner.added.find(load);
    return found != inner.added.end() ? found->second.first : zero;
  };
  std::map<Load, Span> added;
  for (const Effects* inner : {&then, &otherwise}) {
    for (const auto& [load, value] : inner->added) added.emplace(load, value.second);
  }
  for (const auto& [load, span] : added) {
    const NodeId chosen =
        graph_.Select(condition.node[0], sum_in(then, load), sum_in(otherwise, load));
    const auto [found, is_new] = effects.added.try_emplace(load, std::pair(chosen, span));
    if (!is_new) found->second.first = graph_.Add(found->second.first, chosen);
  }
  if (then.energy != kNoNode || otherwise.energy != kNoNode) {
    const NodeId chosen =
        graph_.Select(condition.node[0], then.energy == kNoNode ? zero : then.energy,
                      otherwise.energy == kNoNode ? zero : otherwise.energy);
    effects.energy = effects.energy == kNoNode ? chosen : graph_.Add(effects.energy, chosen);
    effects.energy_span = then.energy == kNoNode ? otherwise.energy_span : then.energy_span;
  }
}

void Checker::Assign(const Statement& statement, Effects& effects) {
  // The target is a property, or participant.property, and either may have a component.
  const Expression* target = statement.target.get();
  std::string component;
  const auto participant_of = [&](const Expression& name) -> int {
    for (size_t i = 0; i < participants_.size(); ++i) {
      if (participants_[i].first == name.word) return static_cast<int>(kFirst + i);
    }
    return -1;
  };
  uint16_t participant = kOwnRow;
  std::string name;
  if (target->kind == ExpressionKind::kMember &&
      (target->parts[0]->kind == ExpressionKind::kMember ||
       participant_of(*target->parts[0]) < 0)) {
    component = target->word;
    target = target->parts[0].get();
  }
  if (target->kind == ExpressionKind::kMember) {
    const int found =
        target->parts[0]->kind == ExpressionKind::kName ? participant_of(*target->parts[0]) : -1;
    if (found < 0) {
      problems_.Fail(statement.target->span,
                     Quoted(statement.target->span) + " is nothing that can be set");
    }
    participant = static_cast<uint16_t>(found);
    name = target->word;
  } else {
    name = target->word;
    const bool is_let =
        std::any_of(lets_.begin(), lets_.end(), [&](const auto& let) { return let.first == name; });
    const bool is_parameter =
        std::any_of(parameters_.begin(), parameters_.end(),
                    [&](const Parameter& parameter) { return parameter.name == name; });
    if (is_let ||
        ((is_parameter || name == "dt" || name == "time" || name == "stage" || name == "pi") &&
         !IsProperty(row_kind_, name))) {
      problems_.Fail(target->span, "'" + name + "' keeps its value in a step and cannot be set",
                     is_let ? "give the new value another name: let " + name + "2 = …" : "");
    }
    if (!IsProperty(row_kind_, name)) {
      if (participant_of(*target) >= 0) {
        problems_.Fail(target->span, "'" + name + "' is a whole row, expected a property of it",
                       "write " + name + ".force, for example");
      }
      if (IsProperty(world_kind_, name)) {
        problems_.Fail(target->span,
                       "'" + name + "' is a constant of the world; laws only read it");
      }
      if (statement.kind == StatementKind::kAssign && participants_.empty()) {
        const std::vector<std::string> names = NamesInScope();
        const std::string* nearest = name.size() > 2 ? NearestName(name, names) : nullptr;
        problems_.Fail(target->span, Plural(row_kind_) + " have no '" + name + "'",
                       nearest != nullptr ? "did you mean '" + *nearest + "'?"
                                          : "a new name begins with let: let " + name + " = …");
      }
      FailUnknown(name, target->span);
    }
  }
  const uint16_t property = Resolve(participant, name, target->span);
  const PropertyCode use = code_.properties[property];
  if (use.is_reference) {
    problems_.Fail(target->span, "'" + name + "' says which rows it joins, and cannot be set");
  }
  if (use.is_field) {
    problems_.Fail(target->span,
                   "'" + name + "' is a field, a function of the place; laws only read it");
  }
  Value value = Evaluate(*statement.value);
  value.span = statement.value->span;
  RequireQuantity(value);
  graph_.At(statement.span);
  uint16_t first = 0;
  uint32_t components = use.components;
  if (!component.empty()) {
    const std::string_view names = use.components == 4 ? "xyzw" : "xyz";
    const size_t at = component.size() == 1 ? names.find(component[0]) : std::string::npos;
    if (use.components == 1 || at == std::string::npos) {
      problems_.Fail(statement.target->span, "'" + name + "' has no '" + component + "'",
                     use.components == 1 ? "it is a number" : "its components are x, y and z");
    }
    first = static_cast<uint16_t>(at);
    components = 1;
    uses_axes_ = true;
  }
  if (value.any_unit && value.components == 1 && components > 1) {
    for (uint32_t i = 1; i < components; ++i) value.node[i] = value.node[0];
    value.components = components;
  }
  if (value.components != components) {
    const auto kind = [](uint32_t count) {
      return count == 1 ? "a number" : count == 3 ? "a vector" : "a rotation";
    };
    std::string hint;
    if (components == 3)
      hint = "write (x, y, z) " + UnitName(use.dimension) + ", or multiply it with a direction";
    if (components == 1 && value.components == 3) {
      hint = "write |" + Source(value.span) + "| for its length, or (" + Source(value.span) +
             ").x for a component";
    }
    problems_.Fail(value.span,
                   Quoted(value.span) + " is " + kind(value.components) + ", but " +
                       Quoted(statement.target->span) + " is " + kind(components),
                   hint);
  }
  RequireUnit(value, use.dimension, Quoted(statement.target->span));
  const vesper_access allowed = [&] {
    const uint32_t kind = KindOfParticipant(participant);
    const uint32_t found = FindProperty(kind, name);
    return found == kNone ? VESPER_READ_WRITE : prototype_.properties()[found].law_access;
  }();
  if (use.optional) {
    problems_.Fail(target->span, "'" + name + "' may be missing in a world, so it is only read",
                   "declare it by 'has' instead of 'may have'");
  }
  const bool adds = statement.kind != StatementKind::kAssign;
  if (use.accumulator) {
    if (!adds) {
      problems_.Fail(statement.span,
                     "'" + name + "' is the sum over all laws, so no law can set it",
                     "write += to add to it");
    }
  } else if ((allowed & VESPER_WRITE) == 0) {
    problems_.Fail(target->span,
                   "'" + name + "' is only read by laws; the world's designer sets it");
  }
  const bool shared = participant != kOwnRow;
  if (shared && !adds) {
    problems_.Fail(
        statement.span,
        "several " + (pass_->kind == BlockKind::kPairs ? std::string("pairs") : Plural(row_kind_)) +
            " may share one row, so " + Quoted(statement.target->span) + " cannot be set here",
        "write += or -=, or set it in a block of its own: each " +
            prototype_.kinds()[KindOfParticipant(participant)] + ":");
  }
  added_force_ = added_force_ || use.accumulator;
  if (use.set_at.end == 0) code_.properties[property].set_at = target->span;
  for (uint16_t i = 0; i < components; ++i) {
    const Load load{participant, property, static_cast<uint16_t>(first + i)};
    NodeId node = value.node[i];
    if (statement.kind == StatementKind::kSubtract) node = graph_.Negate(node);
    if (use.accumulator || shared) {
      const auto [found, is_new] = effects.added.try_emplace(load, std::pair(node, statement.span));
      if (!is_new) found->second.first = graph_.Add(found->second.first, node);
    } else {
      const auto found = effects.stored.find(load);
      if (adds) {
        const NodeId now =
            found != effects.stored.end() ? found->second.first : graph_.LoadOf(load);
        node = graph_.Add(now, node);
      }
      effects.stored.insert_or_assign(load, std::pair(node, statement.span));
    }
  }
}

void Checker::AssignEnergy(const Statement& statement, Effects& effects) {
  Value value = Evaluate(*statement.value);
  value.span = statement.value->span;
  RequireNumber(value, "an energy");
  RequireUnit(value, kEnergy, "an energy");
  if (statement.kind == StatementKind::kAssign && effects.energy != kNoNode) {
    problems_.Fail(statement.span, "the energy of this block is set already",
                   "write += to add to it");
  }
  graph_.At(statement.span);
  const NodeId node =
      statement.kind == StatementKind::kSubtract ? graph_.Negate(value.node[0]) : value.node[0];
  effects.energy = effects.energy == kNoNode ? node : graph_.Add(effects.energy, node);
  effects.energy_span = statement.span;
}

/// Adds a force along the line between the two participants.
void Checker::AssignPull(const Statement& statement, Effects& effects) {
  const std::string& name = statement.target->word;
  if (distance_ == kNoNode || prototype_.kinds()[participants_[0].second] != "body") {
    problems_.Fail(statement.target->span,
                   "'" + name + "' acts between two bodies, but this block is about " +
                       (participants_.empty() ? "single rows" : "other rows"),
                   "use it below: each pair of bodies:, or each spring from a to b:");
  }
  Value value = Evaluate(*statement.value);
  value.span = statement.value->span;
  if (value.IsVector()) {
    problems_.Fail(value.span, Quoted(value.span) + " is a vector, but '" + name + "' is a number",
                   "it acts along the line between the two; write its strength only");
  }
  RequireNumber(value, "'" + name + "'");
  RequireUnit(value, kForce, "'" + name + "'");
  if (statement.kind == StatementKind::kAssign &&
      effects.added.contains(
          {kFirst, UseProperty(FindProperty(participants_[0].second, "externalForce")), 0})) {
    problems_.Fail(statement.span, "a force between the two is set already",
                   "write += to add to it");
  }
  graph_.At(statement.span);
  NodeId pull = value.node[0];
  if (statement.kind == StatementKind::kSubtract) pull = graph_.Negate(pull);
  if (name == "repulsion") pull = graph_.Negate(pull);
  std::array<NodeId, 3> force;
  for (uint32_t i = 0; i < 3; ++i) force[i] = graph_.Multiply(pull, direction_[i]);
  Push(kFirst, force, statement.span, effects);
  for (NodeId& component : force) component = graph_.Negate(component);
  Push(kFirst + 1, force, statement.span, effects);
}

void Checker::Push(uint16_t participant, const std::array<NodeId, 3>& force, Span span,
                   Effects& effects) {
  const uint32_t found = FindProperty(KindOfParticipant(participant), "externalForce");
  if (found == kNone) {
    problems_.Fail(span, Plural(KindOfParticipant(participant)) + " of this world have no force");
  }
  const uint16_t property = UseProperty(found);
  added_force_ = true;
  for (uint16_t i = 0; i < 3; ++i) {
    const Load load{participant, property, i};
    const auto [entry, is_new] = effects.added.try_emplace(load, std::pair(force[i], span));
    if (!is_new) entry->second.first = graph_.Add(entry->second.first, force[i]);
  }
}

NodeId Checker::EnergyAtEdge(const Block& block, NodeId energy, Span span) {
  if (pass_->within == kNoNode || block.edge == Edge::kCut) return energy;
  const NodeId square = graph_[distance_].a;  // r^2 is this node, without a root
  for (const Load& load : graph_.LoadsOf(energy, {distance_, square})) {
    if (load.property != pass_->position || code_.properties[load.property].own) continue;
    problems_.Fail(span,
                   "the energy depends on positions other than by the distance, so it cannot be "
                   "shifted to 0 at the distance of 'within'",
                   "end the heading by: energy cut:");
  }
  if (block.edge != Edge::kSmooth) {
    const NodeId edge = graph_.Substitute(
        energy, {{distance_, pass_->within}, {square, graph_.WholePower(pass_->within, 2)}});
    return graph_.Subtract(energy, edge);
  }
  // The smooth cutoff for `within R` is a factor that decreases from 1 at 0.9 R to 0 at R. Its
  // first and second derivatives are 0 at both ends.
  const NodeId begin = graph_.Multiply(graph_.Constant(0.9), pass_->within);
  const NodeId t = graph_.Binary(
      Operation::kMax, graph_.Constant(0),
      graph_.Divide(graph_.Subtract(distance_, begin), graph_.Subtract(pass_->within, begin)));
  const NodeId inner = graph_.Add(
      graph_.Constant(-10),
      graph_.Multiply(
          t, graph_.Subtract(graph_.Constant(15), graph_.Multiply(graph_.Constant(6), t))));
  return graph_.Multiply(
      energy, graph_.Add(graph_.Constant(1), graph_.Multiply(graph_.WholePower(t, 3), inner)));
}

/// Derives the forces of a block from its energy.
void Checker::FinishEnergy(const Block& block, Effects& effects) {
  if (effects.energy == kNoNode) return;
  const Span span = effects.energy_span;
  graph_.At(span);
  const bool has_step = pass_->within != kNoNode && block.edge == Edge::kCut;
  pass_->conserves_energy = effects.stored.empty() && effects.added.empty() && !has_step &&
                            graph_.IsContinuous(effects.energy);
  const NodeId energy = EnergyAtEdge(block, effects.energy, span);
  std::vector<Load> wanted;
  for (const Load& load : graph_.LoadsOf(energy)) {
    const PropertyCode& use = code_.properties[load.property];
    if (use.is_field) {
      pass_->conserves_energy = false;  // because the field may depend on the time
      if (use.kind == "body") wanted.push_back(load);
      continue;
    }
    if (use.kind == "body" && use.name == "position" && load.participant != kWorld) {
      wanted.push_back(load);
    } else if (use.name == "velocity" || use.name == "angularVelocity" ||
               use.name == "orientation") {
      problems_.Fail(
          span, "an energy depends on positions only, but this one depends on '" + use.name + "'",
          "write the force itself: force += …");
    }
  }
  if (wanted.empty()) {
    problems_.Fail(span,
                   "the energy depends on no position of a body, so no force follows from it");
  }
  std::sort(wanted.begin(), wanted.end());
  std::map<Load, NodeId> gradient = graph_.Gradient(energy, wanted);
  std::map<uint16_t, std::array<NodeId, 3>> forces;
  for (const Load& load : wanted) {
    auto [entry, is_new] = forces.try_emplace(load.participant);
    std::array<NodeId, 3>& force = entry->second;
    if (is_new) force.fill(graph_.Constant(0));
    const auto found = gradient.find(load);
    if (found == gradient.end()) continue;
    if (!code_.properties[load.property].is_field) {
      force[load.component] = graph_.Subtract(force[load.component], found->second);
      continue;
    }
    const uint16_t slope = UseSlope(load.property, load.component);
    for (uint16_t i = 0; i < 3; ++i) {
      const NodeId by = graph_.LoadOf({load.participant, slope, i});
      force[i] = graph_.Subtract(force[i], graph_.Multiply(found->second, by));
    }
  }
  for (const auto& [participant, force] : forces) Push(participant, force, span, effects);
  pass_->energy = energy;
  code_.has_energy = true;
}

void Checker::FinishBlock(const Block& block, Effects& effects) {
  if (effects.stored.empty() && effects.added.empty()) {
    if (problems_.empty()) {
      problems_.Add(block.span, "the block changes nothing",
                    "add to a property, such as: force += …, or set an energy");
    }
    return;
  }
  for (const auto& [load, value] : effects.stored) {
    pass_->outputs.push_back({load, false, value.first, value.second});
  }
  for (const auto& [load, value] : effects.added) {
    pass_->outputs.push_back({load, true, value.first, value.second});
  }
}

}  // namespace vesper::text
