// SPDX-License-Identifier: Apache-2.0
// Resolution of names in a law text.
#include <algorithm>
#include <iterator>

#include "checker.hpp"
#include "nearest_name.hpp"
#include "unit.hpp"
#include "unit_parser.hpp"
#include "vesper/engine.h"

namespace vesper::text {
namespace {

/// A common name for a property of the engine, for suggestions.
struct UsualName {
  std::string_view usual;
  std::string_view kind;
  std::string_view property;
};
constexpr UsualName kUsualNames[] = {
    {"force", "body", "externalForce"},
    {"springConstant", "spring", "hookeConstant"},
    {"stiffness", "spring", "hookeConstant"},
    {"damping", "spring", "dampingConstant"},
};

/// Letters by which textbooks denote properties and constants, for suggestions.
constexpr std::pair<std::string_view, std::string_view> kLetters[] = {
    {"m", "mass"},          {"M", "mass"},           {"v", "velocity"},
    {"x", "position"},      {"q", "charge"},         {"Q", "charge"},
    {"F", "force"},         {"g", "gravity"},        {"G", "gravitationalConstant"},
    {"E", "electricField"}, {"B", "magneticField"},  {"t", "time"},
    {"I", "inertia"},       {"k", "springConstant"}, {"omega", "angularVelocity"},
    {"L", "length"},
};

constexpr std::string_view kBuiltIn[] = {"dt",     "time",       "pi",       "stage",
                                         "energy", "attraction", "repulsion"};

/// Returns the type of a standard property that has 64 bits in all worlds; 0 for all others.
vesper_scalar_type FixedTypeOf(const std::string& kind, const std::string& name) {
  const vesper_prototype* single = vesper_prototype_standard("si-f32");
  for (uint32_t i = 0; i < single->property_count; ++i) {
    const vesper_property_descriptor& known = single->properties[i];
    if (known.scalar_type == VESPER_F64 && name == known.name && kind == known.kind) {
      return VESPER_F64;
    }
  }
  return 0;
}

bool IsUnitSymbol(std::string_view name) {
  try {
    ParseUnitOrThrowWhere(name);
    return true;
  } catch (const UnitError&) {
    return false;
  }
}

}  // namespace

std::string Checker::Quoted(Span span) const {
  std::string part = Source(span);
  for (char& c : part) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  constexpr size_t kLongest = 40;
  if (part.size() > kLongest) {
    size_t end = kLongest;
    while (end > 0 && (static_cast<unsigned char>(part[end]) & 0xc0) == 0x80) --end;
    part = part.substr(0, end) + "…";
  }
  return "'" + part + "'";
}

std::string Checker::Plural(uint32_t kind) const {
  const std::string& name = prototype_.kinds()[kind];
  if (name.ends_with("y")) return name.substr(0, name.size() - 1) + "ies";
  return name + "s";
}

uint32_t Checker::FindProperty(uint32_t kind, std::string_view name) const {
  const auto find = [&](std::string_view wanted) {
    const auto& properties = prototype_.properties();
    for (uint32_t i = 0; i < properties.size(); ++i) {
      if (properties[i].kind == kind && properties[i].name == wanted) return i;
    }
    return kNone;
  };
  const uint32_t own = find(name);
  if (own != kNone) return own;
  for (const UsualName& usual : kUsualNames) {
    if (usual.usual == name && prototype_.kinds()[kind] == usual.kind) return find(usual.property);
  }
  return kNone;
}

size_t Checker::FindOwned(uint32_t kind, std::string_view name) const {
  for (size_t i = 0; i < owned_.size(); ++i) {
    if (owned_[i].kind == kind && owned_[i].tree->name.word == name) return i;
  }
  return owned_.size();
}

uint16_t Checker::UseProperty(uint32_t property) {
  const PropertySpec& spec = prototype_.properties()[property];
  const std::string key = prototype_.kinds()[spec.kind] + "." + spec.name;
  for (const auto& [known, place] : used_) {
    if (known == key) return place;
  }
  PropertyCode use;
  use.name = spec.name;
  use.kind = prototype_.kinds()[spec.kind];
  use.components = spec.components;
  use.dimension = DimensionOf(spec.unit);
  use.is_reference = spec.refers_to != kNone;
  use.accumulator = spec.IsAccumulator();
  if (IsReal(spec.type) && spec.type != prototype_.real_type()) use.other_type = spec.type;
  use.fixed_type = use.other_type != 0 ? use.other_type : FixedTypeOf(use.kind, use.name);
  const size_t declared = FindOwned(spec.kind, spec.name);
  use.optional = declared < owned_.size() && owned_[declared].tree->optional;
  code_.properties.push_back(use);
  used_.emplace_back(key, static_cast<uint16_t>(code_.properties.size() - 1));
  return used_.back().second;
}

uint32_t Checker::FindField(std::string_view name) const {
  const auto& properties = prototype_.properties();
  for (uint32_t i = 0; i < properties.size(); ++i) {
    if (IsField(properties[i].type) && properties[i].name == name) return i;
  }
  return kNone;
}

uint16_t Checker::UseField(uint16_t participant, uint32_t field, Span span) {
  const PropertySpec& spec = prototype_.properties()[field];
  const uint32_t kind = KindOfParticipant(participant);
  const uint32_t found =
      kind == kNone || kind == world_kind_ ? kNone : FindProperty(kind, "position");
  if (found == kNone || prototype_.properties()[found].components != 3) {
    std::string owner = "this part of the law has no rows with a position";
    if (kind != kNone && kind != world_kind_) owner = Plural(kind) + " have no position";
    problems_.Fail(span, Quoted(span) + " is a field, a function of the place, but " + owner,
                   "use it in a block: each body:");
  }
  if (spec.components != 1 && spec.components != 3) {
    problems_.Fail(span, Quoted(span) + " has " + std::to_string(spec.components) +
                             " components; a law as text reads fields of numbers and vectors");
  }
  const uint16_t positions = Resolve(participant, "position", span);
  for (uint16_t component = 0; component < 3; ++component) {
    if (effects_ == nullptr || !effects_->stored.contains({participant, positions, component})) {
      continue;
    }
    problems_.Fail(span, "this block has set the position, so " + Quoted(span) + " is unknown here",
                   "read the field above, or in a block below this one");
  }
  code_.properties[positions].read = true;
  uses_axes_ =
      true;  // because the law cannot claim that the field looks the same when it is turned
  const std::string key = prototype_.kinds()[kind] + "." + spec.name;
  for (const auto& [known, place] : used_) {
    if (known == key) return place;
  }
  PropertyCode use;
  use.name = spec.name;
  use.kind = prototype_.kinds()[kind];
  use.components = spec.components;
  use.dimension = DimensionOf(spec.unit);
  use.is_field = true;
  use.positions = positions;
  use.field_kind = prototype_.kinds()[spec.kind];
  use.field_components = spec.components;
  return AddField(use, key);
}

uint16_t Checker::AddField(const PropertyCode& use, const std::string& key) {
  const auto place = static_cast<uint16_t>(code_.properties.size());
  const auto first = std::ranges::find_if(code_.properties, [&](const PropertyCode& other) {
    return other.is_field && other.name == use.name;
  });
  const auto first_place = static_cast<uint16_t>(first - code_.properties.begin());
  code_.properties.push_back(use);
  code_.properties.back().first_of_field = first_place;  // `place` if it is the first
  if (use.slope_of != 0) code_.properties[first_place].sloped = true;
  used_.emplace_back(key, place);
  return place;
}

uint16_t Checker::UseSlope(uint16_t values, uint16_t component) {
  PropertyCode use = code_.properties[values];
  const std::string key = use.kind + "." + use.name + "'" + std::to_string(component);
  for (const auto& [known, place] : used_) {
    if (known == key) return place;
  }
  use.components = 3;
  use.slope_of = static_cast<uint16_t>(component + 1);
  use.sloped = false;
  return AddField(use, key);
}

uint16_t Checker::UseOwned(size_t owned) {
  const Owned& declared = owned_[owned];
  const std::string key = prototype_.kinds()[declared.kind] + "." + declared.tree->name.word;
  for (const auto& [known, place] : used_) {
    if (known == key) return place;
  }
  PropertyCode use;
  use.name = declared.tree->name.word;
  use.kind = prototype_.kinds()[declared.kind];
  use.components = declared.tree->components;
  use.dimension = declared.dimension;
  use.own = !declared.tree->optional;
  use.optional = declared.tree->optional;
  code_.properties.push_back(use);
  used_.emplace_back(key, static_cast<uint16_t>(code_.properties.size() - 1));
  return used_.back().second;
}

uint32_t Checker::KindOfParticipant(uint16_t participant) const {
  if (participant == kWorld) return world_kind_;
  if (participant == kOwnRow) return row_kind_;
  return participants_[participant - kFirst].second;
}

bool Checker::IsProperty(uint32_t kind, const std::string& name) const {
  return kind != kNone &&
         (FindProperty(kind, name) != kNone || FindOwned(kind, name) < owned_.size());
}

uint16_t Checker::Resolve(uint16_t participant, const std::string& name, Span span) {
  const uint32_t kind = KindOfParticipant(participant);
  const uint32_t property = FindProperty(kind, name);
  if (property == kNone) {
    const size_t owned = FindOwned(kind, name);
    if (owned < owned_.size()) return UseOwned(owned);
    if (const uint32_t field = FindField(name); field != kNone) {
      return UseField(participant, field, span);
    }
    std::vector<std::string> names;
    for (const PropertySpec& spec : prototype_.properties()) {
      if (spec.kind == kind && !IsField(spec.type)) names.push_back(spec.name);
    }
    for (const UsualName& usual : kUsualNames) {
      if (usual.kind == prototype_.kinds()[kind]) names.emplace_back(usual.usual);
    }
    const std::string* nearest = NearestName(name, names);
    std::string hint = nearest != nullptr ? "did you mean '" + *nearest + "'?" : "";
    if (hint.empty()) {
      hint = "a property of the law's own is declared by: each " + prototype_.kinds()[kind] +
             " has " + name + " in UNIT";
    }
    problems_.Fail(span, Plural(kind) + " of this world have no '" + name + "'", hint);
  }
  const PropertySpec& spec = prototype_.properties()[property];
  if (IsField(spec.type)) return UseField(participant, property, span);
  if (!IsReal(spec.type) && spec.refers_to == kNone) {
    problems_.Fail(span, "'" + name + "' holds whole numbers; a law as text reads real numbers");
  }
  if (spec.refers_to == kNone && spec.components != 1 && spec.components != 3 &&
      spec.components != 4) {
    problems_.Fail(span, "'" + name + "' has " + std::to_string(spec.components) +
                             " components; a law as text reads numbers, vectors and rotations");
  }
  return UseProperty(property);
}

Value Checker::ReadProperty(uint16_t participant, uint16_t property, Span span) {
  const PropertyCode& use = code_.properties[property];
  if (use.is_reference) {
    problems_.Fail(span, "'" + use.name + "' refers to other rows",
                   "name them in the heading, such as: each " + use.kind + " from a to b:");
  }
  Value value;
  value.dimension = use.dimension;
  value.components = use.components;
  value.span = span;
  for (uint16_t component = 0; component < use.components; ++component) {
    const Load load{participant, property, component};
    if (effects_ != nullptr && effects_->added.contains(load)) {
      problems_.Fail(span, Quoted(span) + " is being summed in this block, so it has no value yet",
                     "read it in a block below this one");
    }
    NodeId node = kNoNode;
    if (effects_ != nullptr) {
      const auto stored = effects_->stored.find(load);
      if (stored != effects_->stored.end()) node = stored->second.first;
    }
    value.node[component] = node == kNoNode ? graph_.LoadOf(load) : node;
  }
  return value;
}

bool Checker::IsKnown(const std::string& name) const {
  const auto is_name = [&](const auto& entry) { return entry.first == name; };
  if (std::find(std::begin(kBuiltIn), std::end(kBuiltIn), name) != std::end(kBuiltIn)) return true;
  if (std::any_of(lets_.begin(), lets_.end(), is_name)) return true;
  if (std::any_of(participants_.begin(), participants_.end(), is_name)) return true;
  if (std::any_of(parameters_.begin(), parameters_.end(),
                  [&](const Parameter& parameter) { return parameter.name == name; })) {
    return true;
  }
  return block_ != nullptr && IsProperty(row_kind_, name);
}

void Checker::RequireNewName(const Name& name) {
  if (IsFunction(name.word)) {
    problems_.Fail(name.span, "'" + name.word + "' is a function; choose another name");
  }
  if (!IsKnown(name.word)) return;
  const bool property = row_kind_ != kNone && IsProperty(row_kind_, name.word);
  problems_.Fail(name.span,
                 "'" + name.word + "' is " +
                     (property ? "a property of " + Plural(row_kind_) : "in use") + " already",
                 property ? "choose another name, or change the property without 'let'"
                          : "choose another name");
}

std::vector<std::string> Checker::NamesInScope() const {
  std::vector<std::string> names;
  for (const auto& [name, value] : lets_) names.push_back(name);
  for (const Parameter& parameter : parameters_) names.push_back(parameter.name);
  for (const auto& [name, kind] : participants_) names.push_back(name);
  for (const std::string_view name : kBuiltIn) names.emplace_back(name);
  for (const PropertySpec& spec : prototype_.properties()) {
    if (!IsReal(spec.type) && !IsField(spec.type)) continue;
    if (spec.kind == row_kind_ || spec.kind == world_kind_) names.push_back(spec.name);
  }
  for (const UsualName& usual : kUsualNames) {
    if (row_kind_ != kNone && usual.kind == prototype_.kinds()[row_kind_]) {
      names.emplace_back(usual.usual);
    }
  }
  for (const Owned& owned : owned_) {
    if (owned.kind == row_kind_) names.push_back(owned.tree->name.word);
  }
  return names;
}

void Checker::FailUnknown(const std::string& name, Span span) {
  if (failed_.contains(name)) throw Abandon{};
  if (row_kind_ == kNone && !participants_.empty()) {
    for (const auto& [participant, kind] : participants_) {
      if (!IsProperty(kind, name)) continue;
      problems_.Fail(span, "'" + name + "' of which of the two?",
                     "write " + participants_[0].first + "." + name + " or " +
                         participants_[1].first + "." + name);
    }
  }
  for (const auto& [participant, kind] : participants_) {
    if (!IsProperty(kind, name)) continue;
    problems_.Fail(
        span, "'" + name + "' is no property of " + Plural(row_kind_) + " but of " + Plural(kind),
        "write " + participant + "." + name);
  }
  const std::vector<std::string> names = NamesInScope();
  // A similar name is not a useful suggestion for a name of one or two letters.
  const std::string* nearest = name.size() > 2 ? NearestName(name, names) : nullptr;
  const std::vector<std::string> functions = FunctionNames();
  if (name.size() > 2 && text_.substr(span.end).starts_with("(")) {
    const std::string* function = NearestName(name, functions);
    if (function != nullptr) nearest = function;
  }
  std::string hint;
  if (name == prototype_.kinds()[row_kind_ == kNone ? 0 : row_kind_] && row_kind_ != kNone) {
    hint = "write the property alone, without '" + name + ".'";
  }
  for (const auto& [letter, meaning] : kLetters) {
    const bool known = std::find(names.begin(), names.end(), meaning) != names.end();
    if (name == letter && known) {
      hint = "if it stands for " + std::string(meaning) + ", write " + std::string(meaning) +
             ", or first: let " + name + " = " + std::string(meaning);
    }
  }
  if (IsFunction(name)) hint = "write " + name + "(…)";
  if (name == "length" || name == "norm" || name == "magnitude") {
    hint = "the length of a vector v is |v|";
  }
  if (span.begin >= 3 && IsUnitSymbol(name) && text_.substr(0, span.begin).ends_with(" ")) {
    const char sign = text_[span.begin - 2];
    if (sign == '/' || sign == '*') {
      hint = "to write a unit such as N/m, leave out the spaces";
      nearest = nullptr;
    }
  }
  if (hint.empty() && nearest == nullptr && IsUnitSymbol(name)) {
    hint =
        "a unit stands behind a number and has no spaces inside, such as 1 " + name + " or 1 N*m";
  }
  for (uint32_t kind = 0; kind < prototype_.kinds().size(); ++kind) {
    if (!hint.empty() || nearest != nullptr || kind == row_kind_ || !IsProperty(kind, name))
      continue;
    hint = "it is a property of " + Plural(kind) + "; use it in a block: each " +
           prototype_.kinds()[kind] + ":";
  }
  if (hint.empty()) hint = nearest != nullptr ? "did you mean '" + *nearest + "'?" : "";
  if (hint.empty() && block_ == nullptr) {
    hint = "only parameters, constants of the world and numbers have a value here";
  }
  if (hint.empty()) {
    hint = "a constant is declared by: parameter " + name + " = VALUE UNIT";
    if (row_kind_ != kNone) {
      hint +=
          ", a property by: each " + prototype_.kinds()[row_kind_] + " has " + name + " in UNIT";
    }
  }
  problems_.Fail(span, "nothing here is called '" + name + "'", hint);
}

/// Returns a hint for messages. It names the quantity by which `which` must be multiplied or
/// divided to get the expected unit.
std::string Checker::FactorHint(const std::string& which, const Dimension& found,
                                const Dimension& expected) const {
  const Dimension missing = expected / found;
  std::vector<std::pair<std::string, Dimension>> candidates;
  for (const auto& [name, value] : lets_) {
    if (value.components == 1 && !value.condition) candidates.emplace_back(name, value.dimension);
  }
  for (const Parameter& parameter : parameters_) {
    if (parameter.value.components == 1) {
      candidates.emplace_back(parameter.name, parameter.value.dimension);
    }
  }
  const size_t own = candidates.size();  // number of the law's own names, which come first
  candidates.emplace_back("dt", kTime);
  for (const uint32_t kind : {row_kind_, world_kind_}) {
    if (kind == kNone) continue;
    for (const PropertySpec& spec : prototype_.properties()) {
      if (spec.kind == kind && spec.components == 1 && IsReal(spec.type)) {
        candidates.emplace_back(spec.name, DimensionOf(spec.unit));
      }
    }
  }
  for (const auto& [participant, kind] : participants_) {
    for (const PropertySpec& spec : prototype_.properties()) {
      if (spec.kind == kind && spec.components == 1 && IsReal(spec.type)) {
        candidates.emplace_back(participant + "." + spec.name, DimensionOf(spec.unit));
      }
    }
  }
  const Dimension inverse = Dimension{} / missing;
  std::string hint;
  int found_hints = 0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const auto& [name, dimension] = candidates[i];
    if (i == own && !hint.empty()) break;
    if (dimension.IsOne()) continue;
    std::string one;
    if (dimension == missing) one = "multiply " + which + " by " + name;
    if (dimension == inverse) one = "divide " + which + " by " + name;
    if (dimension * dimension == missing) one = "multiply " + which + " by " + name + "^2";
    if (dimension * dimension == inverse) one = "divide " + which + " by " + name + "^2";
    if (one.empty()) continue;
    hint += (hint.empty() ? "" : ", or ") + one;
    if (++found_hints == 2) break;
  }
  const std::string factor = which + " lacks a factor of " + UnitName(missing);
  return hint.empty() ? factor : factor + ": " + hint;
}

}  // namespace vesper::text
