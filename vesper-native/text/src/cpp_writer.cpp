// SPDX-License-Identifier: Apache-2.0
#include "cpp_writer.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <utility>

#include "cpp_fields.hpp"
#include "cpp_names.hpp"
#include "cpp_pass.hpp"

namespace vesper::text {
namespace {

const char* PhaseName(vesper_phase phase) {
  switch (phase) {
    case VESPER_PHASE_FORCE:
      return "kForce";
    case VESPER_PHASE_INTEGRATE:
      return "kIntegrate";
    case VESPER_PHASE_CONSTRAIN:
      return "kConstrain";
    default:
      return "kObserve";
  }
}

std::string ClaimNames(uint32_t claims) {
  std::string text;
  for (const auto& [claim, name] :
       {std::pair<uint32_t, const char*>{VESPER_CLAIM_MOMENTUM, "kMomentum"},
        {VESPER_CLAIM_ANGULAR_MOMENTUM, "kAngularMomentum"},
        {VESPER_CLAIM_TRANSLATION, "kTranslation"},
        {VESPER_CLAIM_ENERGY, "kEnergy"},
        {VESPER_CLAIM_ROTATION, "kRotation"}}) {
    if ((claims & claim) != 0) text += (text.empty() ? "" : " | ") + std::string(name);
  }
  return text;
}

/// Returns the type of a column, such as "Read<Vec3<Real>>".
std::string ColumnType(const PropertyCode& property) {
  std::string access;
  switch (property.Access()) {
    case VESPER_READ:
      access = "Read";
      break;
    case VESPER_WRITE:
      access = "Write";
      break;
    case VESPER_READ_WRITE:
      access = "ReadWrite";
      break;
    case VESPER_ACCUMULATE:
      access = "Accumulate";
      break;
    default:
      access = "Scratch";
      break;
  }
  const std::string number = property.is_reference               ? "uint32_t"
                             : property.fixed_type == VESPER_F64 ? "double"
                             : property.fixed_type == VESPER_F32 ? "float"
                                                                 : "Real";
  std::string row = number;
  if (property.is_field) access = "Field";
  if (property.components == 3 && !property.is_reference) {
    row = "Vec3<" + number + ">";
  } else if (property.components > 1) {
    row = "std::array<" + number + ", " + std::to_string(property.components) + ">";
  }
  return (property.optional ? "Optional" : "") + access + "<" + row + ">";
}

class LawWriter {
 public:
  LawWriter(const LawCode& law, std::string_view text, std::string name, CppUnits& units,
            CppNeeds& needs, FieldsWriter& fields)
      : law_(law),
        text_(text),
        name_(std::move(name)),
        units_(units),
        needs_(needs),
        fields_(fields) {
    NameMembers();
  }

  std::string Write() {
    const std::string methods = Methods();
    lines_ = "/** " + Comment(law_.doc) + " */\ntemplate <class Real>\nstruct " + name_ + " {\n";
    Constants();
    Parameters();
    Columns();
    lines_ += fields_.Join(law_, members_.parameters);
    lines_ += methods + "};\n";
    return std::move(lines_);
  }

 private:
  static std::string Comment(std::string text) {
    for (size_t at = 0; (at = text.find("*/", at)) != std::string::npos;) text.insert(at + 1, " ");
    return text;
  }

  void NameMembers() {
    for (const char* taken : {"Advance", "Bind", "Join", "Suite", "PotentialEnergy", "Parameters",
                              "Properties", "energy", "fields"}) {
      names_.Take(taken);
    }
    for (const PropertyCode& property : law_.properties) {
      const auto same_name = [&](const PropertyCode& other) {
        return other.name == property.name && other.kind != property.kind;
      };
      const bool twice = std::ranges::any_of(law_.properties, same_name);
      const std::string usual = property.name == "externalForce" ? "force" : property.name;
      members_.properties.push_back(
          names_.Take(SnakeCase(twice ? property.kind + "_" + usual : usual)));
    }
    for (const ParameterCode& parameter : law_.parameters) {
      members_.parameters.push_back(names_.Take(SnakeCase(parameter.name)));
    }
    const auto is_near = [](const PassCode& pass) { return pass.within != kNoNode; };
    if (std::ranges::any_of(law_.passes, is_near)) members_.neighbours = names_.Take("neighbours");
    members_.last_time = names_.Take("last_time");
    members_.last_dt = names_.Take("last_dt");
    members_.last_stage = names_.Take("last_stage");
  }

  void Constants() {
    const auto constant = [&](const std::string& declaration) {
      lines_ += "  static constexpr " + declaration + ";\n";
    };
    constant("auto kName = " + CppString(law_.name) + ", kVersion = " + CppString(law_.version));
    const bool is_short = law_.doc.size() < 60;
    constant(std::string("auto kDoc =") + (is_short ? " " : "\n      ") + CppString(law_.doc));
    constant(std::string("auto kPhase = Phase::") + PhaseName(law_.phase));
    if (law_.phase == VESPER_PHASE_INTEGRATE) {
      if (law_.stages != 1) constant("uint32_t kStages = " + std::to_string(law_.stages));
      if (law_.first_stage != 0) {
        constant("uint32_t kFirstStage = " + std::to_string(law_.first_stage));
      }
    }
    if (!law_.force_weights.empty()) {
      std::string weights;
      for (const double weight : law_.force_weights) {
        weights += (weights.empty() ? "" : ", ") + CppDouble(weight);
      }
      constant("std::array<double, " + std::to_string(law_.force_weights.size()) +
               "> kForceWeights = {" + weights + "}");
    }
    if (law_.claims != 0) constant("uint32_t kClaims = " + ClaimNames(law_.claims));
  }

  std::string Limit(double value) {
    if (std::abs(value) != std::numeric_limits<double>::max()) return CppDouble(value);
    needs_.limits = true;
    return value < 0 ? "-kUnlimited" : "kUnlimited";
  }

  void Parameters() {
    if (law_.parameters.empty()) return;
    lines_ += "\n";
    std::string tied;
    for (size_t i = 0; i < law_.parameters.size(); ++i) {
      const ParameterCode& parameter = law_.parameters[i];
      lines_ += "  Parameter " + members_.parameters[i] + "{" + CppString(parameter.name) + ", " +
                CppString(parameter.doc) + ",\n      " + units_.Of(parameter.dimension) + ", " +
                CppDouble(parameter.value) + ", " + Limit(parameter.minimum) + ", " +
                Limit(parameter.maximum) + "};\n";
      tied += (tied.empty() ? "" : ", ") + members_.parameters[i];
    }
    lines_ += CppLine(2, "auto Parameters() { return std::tie(" + tied + "); }");
  }

  void Columns() {
    lines_ += "\n";
    std::string tied;
    for (const uint32_t i : law_.table_order) {
      const PropertyCode& property = law_.properties[i];
      lines_ += CppLine(2, ColumnType(property) + " " + members_.properties[i] + "{" +
                               CppString(property.name) + ", " +
                               CppString(property.is_field ? property.field_kind : property.kind) +
                               ", " + units_.Of(property.dimension) + "};");
      tied += (tied.empty() ? "" : ", ") + members_.properties[i];
    }
    lines_ += CppLine(2, "auto Properties() { return std::tie(" + tied + "); }");
  }

  std::string HeadingOf(const PassCode& pass) const {
    std::string heading;
    for (const char c : text_.substr(pass.span.begin, pass.span.end - pass.span.begin)) {
      heading += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
    return heading;
  }

  /// Returns the methods, and the members that they need.
  std::string Methods() {
    CppNeeds needs;
    std::vector<std::string> bodies, energies;
    for (const PassCode& pass : law_.passes) {
      CppNeeds of_pass;
      std::string body = PassWriter(law_, pass, members_, names_, false, of_pass).Write(4);
      if (pass.stage) {
        body = "    if (step.stage == " + std::to_string(*pass.stage) + ") {\n" + body + "    }\n";
        of_pass.step = true;
      }
      bodies.push_back(std::move(body));
      Join(needs, of_pass);
      uses_step_.push_back(of_pass.step);
      if (pass.energy == kNoNode) continue;
      energies.push_back(PassWriter(law_, pass, members_, names_, true, needs).Write(4));
    }
    std::string text;
    if (!members_.neighbours.empty()) {
      const std::string& position = members_.properties[PositionOfPairs()];
      text += "\n  void Bind() { " + members_.neighbours + ".Reserve(" + position + ".size()); }\n";
    }
    text += bodies.size() == 1 ? OnlyBlock(bodies[0], needs) : Blocks(bodies, needs);
    if (law_.has_energy) text += Energy(energies, needs);
    text += Members(needs);
    Join(needs_, needs);
    needs_.step = false;
    return text;
  }

  uint16_t PositionOfPairs() const {
    for (const PassCode& pass : law_.passes) {
      if (pass.within != kNoNode) return pass.position;
    }
    return 0;
  }

  static void Join(CppNeeds& to, const CppNeeds& from) {
    to.grain |= from.grain;
    to.constants_of_world |= from.constants_of_world;
    to.optional_columns |= from.optional_columns;
    to.algorithms |= from.algorithms;
    to.limits |= from.limits;
    to.step |= from.step;
    to.last_step |= from.last_step;
    to.finite |= from.finite;
    to.precisions |= from.precisions;
  }

  std::string NoteStep(const CppNeeds& needs) const {
    if (!needs.last_step) return {};
    return "    " + members_.last_time + " = step.time;\n    " + members_.last_dt +
           " = step.dt;\n    " + members_.last_stage + " = step.stage;\n";
  }

  std::string OnlyBlock(const std::string& body, const CppNeeds& needs) const {
    const bool uses_step = uses_step_[0] || needs.last_step;
    return std::string("\n  void Advance(const Step&") + (uses_step ? " step" : "") + ") {\n" +
           NoteStep(needs) + "    // " + HeadingOf(law_.passes[0]) + "\n" + body + "  }\n";
  }

  std::string Blocks(const std::vector<std::string>& bodies, const CppNeeds& needs) {
    std::string methods, calls;
    for (size_t i = 0; i < bodies.size(); ++i) {
      const PassCode& pass = law_.passes[i];
      const std::string kind = PascalCase(pass.rows);
      const std::string method =
          names_.Take(pass.kind == BlockKind::kPairs ? "EachPairOf" + kind : "Each" + kind);
      calls += "    " + method + "(" + (uses_step_[i] ? "step" : "") + ");\n";
      methods += "\n  // " + HeadingOf(pass) + "\n  void " + method + "(" +
                 (uses_step_[i] ? "const Step& step" : "") + ") {\n" + bodies[i] + "  }\n";
    }
    const bool any_step = std::ranges::find(uses_step_, true) != uses_step_.end();
    return std::string("\n  void Advance(const Step&") +
           (any_step || needs.last_step ? " step" : "") + ") {\n" + NoteStep(needs) + calls +
           "  }\n" + methods;
  }

  static std::string Energy(const std::vector<std::string>& energies, const CppNeeds&) {
    std::string text = "\n  double PotentialEnergy() {\n    double energy = 0;\n";
    for (const std::string& energy : energies) {
      text += energies.size() == 1 ? energy : "    {\n" + energy + "    }\n";
    }
    return text + "    return energy;\n  }\n";
  }

  std::string Members(const CppNeeds& needs) const {
    std::string text;
    if (!members_.neighbours.empty()) {
      text += "\n  Neighbours<Real> " + members_.neighbours + ";\n";
    }
    if (needs.last_step) {
      text += "\n  // Of the last step, for the energy.\n  double " + members_.last_time +
              " = 0, " + members_.last_dt + " = 0, " + members_.last_stage + " = 0;\n";
    }
    return text;
  }

  const LawCode& law_;
  std::string_view text_;
  std::string name_;
  CppUnits& units_;
  CppNeeds& needs_;
  FieldsWriter& fields_;
  CppNames names_;
  CppMembers members_;
  std::vector<bool> uses_step_;  // whether each pass uses the step
  std::string lines_;
};

constexpr const char* kFirstFunction =
    "/** Returns the constant of the world; 0 if the world has none. */\n"
    "template <class Column>\n"
    "auto First(const Column& column) {\n"
    "  using Row = std::remove_const_t<typename Column::Element>;\n"
    "  return column.size() == 0 ? Row{} : column[0];\n"
    "}\n\n";

constexpr const char* kValueOrZeroFunction =
    "/** Returns the value of a row; 0 in a world without this property. */\n"
    "template <class Column>\n"
    "auto ValueOrZero(const Column& column, uint64_t row) {\n"
    "  using Row = std::remove_const_t<typename Column::Element>;\n"
    "  return column.present() ? column[row] : Row{};\n"
    "}\n\n";

constexpr const char* kPrecisionFunctions =
    "/** Returns a vector in the precision of a law. */\n"
    "template <class Real, class Other>\n"
    "Vec3<Real> To(const Vec3<Other>& from) {\n"
    "  return {static_cast<Real>(from.x), static_cast<Real>(from.y), static_cast<Real>(from.z)};\n"
    "}\n\n"
    "/** Stores a number in another precision. A number that does not change keeps all its bits. "
    "*/\n"
    "template <class Other, class Real>\n"
    "void Store(Other& to, Real value) {\n"
    "  if (static_cast<Real>(to) != value) to = static_cast<Other>(value);\n"
    "}\n\n"
    "template <class Other, class Real>\n"
    "void Store(Vec3<Other>& to, const Vec3<Real>& value) {\n"
    "  Store(to.x, value.x);\n"
    "  Store(to.y, value.y);\n"
    "  Store(to.z, value.z);\n"
    "}\n\n";

constexpr const char* kRequireFiniteFunction =
    "/** Throws an exception if a position is not finite, so that it has no distance to others. "
    "*/\n"
    "template <class Column>\n"
    "void RequireFinite(const Column& position) {\n"
    "  for (uint64_t i = 0; i < position.size(); ++i) {\n"
    "    const auto& at = position[i];\n"
    "    if (std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z)) continue;\n"
    "    throw std::domain_error(\"the position of row \" + std::to_string(i) +\n"
    "                            \" is not finite, so it has no distance to other rows\");\n"
    "  }\n"
    "}\n\n";

}  // namespace

std::string WriteCpp(std::string_view source, std::string_view text,
                     const std::vector<LawCode>& laws) {
  CppUnits units;
  CppNeeds needs;
  CppNames names;
  for (const char* function : {"To", "Store", "RequireFinite"}) names.Take(function);
  FieldsWriter fields(laws, names);
  std::string structs, listed;
  bool near = false;
  for (const LawCode& law : laws) {
    const std::string name = names.Take(PascalCase(law.name));
    listed += ", " + name;
    structs += LawWriter(law, text, name, units, needs, fields).Write() + "\n";
    for (const PassCode& pass : law.passes) near = near || pass.within != kNoNode;
  }
  const std::string suite = fields.Suite();
  const std::string functions = fields.Functions(units, needs);
  std::string head =
      "// Written by `vesper law to-cpp` from the text " + std::string(source) + ".\n";
  if (needs.algorithms) head += "#include <algorithm>\n";
  head += "#include <cmath>\n";
  if (needs.limits) head += "#include <limits>\n";
  if (needs.finite) head += "#include <stdexcept>\n#include <string>\n";
  head += "#include <tuple>\n#include <type_traits>\n\n#include \"vesper/law.hpp\"\n";
  if (near) head += "#include \"vesper/law_neighbours.hpp\"\n";
  head += "\nnamespace {\n\nusing namespace vesper;\n\n";
  const std::string declared = units.Declarations();
  head += declared + (declared.empty() ? "" : "\n");
  if (needs.grain)
    head += "// Rows that a thread takes at once.\nconstexpr uint64_t kGrain = 8192;\n\n";
  if (needs.limits) {
    head += "constexpr double kUnlimited = std::numeric_limits<double>::max();\n\n";
  }
  if (needs.constants_of_world) head += kFirstFunction;
  if (needs.optional_columns) head += kValueOrZeroFunction;
  if (needs.precisions) head += kPrecisionFunctions;
  if (needs.finite) head += kRequireFiniteFunction;
  const std::string macro =
      suite.empty() ? "VESPER_LAW_LIBRARY(" : "VESPER_LAW_LIBRARY_WITH_FIELDS(";
  return head + suite + structs + functions + "}  // namespace\n\n" + macro +
         CppString(laws[0].name) + (suite.empty() ? "" : ", kFields") + listed + ")\n";
}

}  // namespace vesper::text
