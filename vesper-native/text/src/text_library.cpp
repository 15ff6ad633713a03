// SPDX-License-Identifier: Apache-2.0
#include "text_library.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "cpp_writer.hpp"
#include "evaluator.hpp"
#include "failure.hpp"
#include "law_code.hpp"

namespace vesper::text {
namespace {

/// A law in an engine: the `vesper_law` between `create` and `destroy`.
class Instance {
 public:
  virtual ~Instance() = default;
  virtual void Bind(const vesper_property* properties) = 0;
  virtual std::optional<Fault> Advance(const vesper_step& step) = 0;
  virtual double PotentialEnergy() = 0;
  virtual const std::string& WhyEvaluated() const = 0;
};

template <class Real>
class InstanceOf final : public Instance {
 public:
  template <class... Arguments>
  explicit InstanceOf(Arguments&&... arguments)
      : evaluator_(std::forward<Arguments>(arguments)...) {}
  void Bind(const vesper_property* properties) override { evaluator_.Bind(properties); }
  std::optional<Fault> Advance(const vesper_step& step) override {
    return evaluator_.Advance(step);
  }
  double PotentialEnergy() override { return evaluator_.PotentialEnergy(); }
  const std::string& WhyEvaluated() const override { return evaluator_.WhyEvaluated(); }

 private:
  Evaluator<Real> evaluator_;
};

Instance& InstanceOfLaw(vesper_law* law) { return *reinterpret_cast<Instance*>(law); }

vesper_status Bind(vesper_law* law, const vesper_property* properties, vesper_error* error) {
  return Guarded(error, [&] { InstanceOfLaw(law).Bind(properties); });
}

vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  return Guarded(error, [&] {
    const std::optional<Fault> fault = InstanceOfLaw(law).Advance(*step);
    if (!fault) return;
    throw Failure(VESPER_LAW_FAILED, "%s", fault->message.c_str())
        .Property(fault->property)
        .Row(fault->row);
  });
}

vesper_status PotentialEnergy(vesper_law* law, double* out, vesper_error* error) {
  return Guarded(error, [&] { *out = InstanceOfLaw(law).PotentialEnergy(); });
}

void Destroy(vesper_law* law) { delete &InstanceOfLaw(law); }

}  // namespace

/// The table of a text, compiled for one prototype, with each law in both precisions.
class CompiledText {
 public:
  CompiledText(std::string_view source, std::string_view text, std::vector<LawCode> laws)
      : source_(source), text_(text), laws_(std::move(laws)) {
    uses_.resize(2 * laws_.size());
    parameters_.resize(laws_.size());
    for (size_t i = 0; i < laws_.size(); ++i) {
      FillParameters(i);
      for (const size_t precision : {0, 1}) {
        FillUses(i, precision);
        descs_.push_back(Describe(i, precision));
      }
    }
    table_.struct_size = sizeof table_;
    table_.abi_version = VESPER_ABI_VERSION;
    table_.name = laws_.front().name.c_str();
    table_.law_count = static_cast<uint32_t>(descs_.size());
    table_.laws = descs_.data();
    table_.user = this;
    FillFields();
  }

  const vesper_law_library& table() const { return table_; }

  /// Creates a law; `entry` is its index in the table.
  std::unique_ptr<Instance> Create(size_t entry, const vesper_host& host,
                                   const double* parameters) const {
    const LawCode& law = laws_[entry / 2];
    std::unique_ptr<Instance> instance;
    if (kPrecisions[entry % 2] == VESPER_F32) {
      instance = std::make_unique<InstanceOf<float>>(law, source_, text_, host, parameters);
    } else {
      instance = std::make_unique<InstanceOf<double>>(law, source_, text_, host, parameters);
    }
    if (const std::string& why = instance->WhyEvaluated(); !why.empty()) {
      const std::string line =
          "the law " + law.name + " is evaluated, not compiled, so it is slower: " + why;
      host.log(host.context, VESPER_LOG_INFO, line.c_str());
    }
    return instance;
  }

 private:
  using CreateFunction = decltype(vesper_law_desc::create);
  static constexpr vesper_scalar_type kPrecisions[] = {VESPER_F64, VESPER_F32};

  template <size_t entry>
  static vesper_status CreateLaw(const vesper_host* host, vesper_suite* suite,
                                 const double* parameters, vesper_law** out, vesper_error* error) {
    return Guarded(error, [&] {
      const auto* text = static_cast<const CompiledText*>(host->user);
      if (suite != nullptr) {
        SuiteOf(suite).parameters[entry / 2].assign(
            parameters, parameters + text->laws_[entry / 2].parameters.size());
      }
      *out = reinterpret_cast<vesper_law*>(text->Create(entry, *host, parameters).release());
    });
  }
  template <size_t... entries>
  static constexpr std::array<CreateFunction, sizeof...(entries)> CreateFunctions(
      std::index_sequence<entries...>) {
    return {CreateLaw<entries>...};
  }

  /// The parameters of the laws in one engine, with which fields are evaluated.
  struct Suite {
    const CompiledText* text;
    std::vector<std::vector<double>> parameters;  // by law
    double time = 0;                              // at the start of the step [s]
  };
  /// A field of a law.
  struct ProvidedField {
    size_t law;
    const FieldCode* code;
  };
  static Suite& SuiteOf(vesper_suite* suite) { return *reinterpret_cast<Suite*>(suite); }

  static vesper_status OpenSuite(const vesper_host* host, vesper_suite** out, vesper_error* error) {
    return Guarded(error, [&] {
      const auto* text = static_cast<const CompiledText*>(host->user);
      auto suite = std::make_unique<Suite>(Suite{text, {}, 0});
      suite->parameters.resize(text->laws_.size());
      *out = reinterpret_cast<vesper_suite*>(suite.release());
    });
  }
  static void CloseSuite(vesper_suite* suite) { delete &SuiteOf(suite); }

  template <size_t field>
  static void EvaluateField(void* user, uint64_t count, const double* at, double* out) {
    const auto& suite = *static_cast<const Suite*>(user);
    const ProvidedField& provided = suite.text->provided_[field];
    provided.code->program.Evaluate({suite.parameters[provided.law], suite.time}, count, at, out);
  }
  template <size_t field>
  static void EvaluateSlopes(void* user, uint64_t count, const double* at, double* out) {
    const auto& suite = *static_cast<const Suite*>(user);
    const ProvidedField& provided = suite.text->provided_[field];
    provided.code->slopes.Evaluate({suite.parameters[provided.law], suite.time}, count, at, out);
  }
  template <size_t field>
  static void ExplainField(void* user, const double* at, vesper_error* error) {
    const auto& suite = *static_cast<const Suite*>(user);
    suite.text->Explain(suite, suite.text->provided_[field], at, *error);
  }
  static void BeginStep(void* user, const vesper_step* step) {
    static_cast<Suite*>(user)->time = step->time;
  }
  /// The functions of a field of a text, of which each has a number.
  struct FieldFunctions {
    decltype(vesper_field_desc::evaluate) evaluate;
    decltype(vesper_field_desc::explain) explain;
    decltype(vesper_field_desc::slopes) slopes;
  };
  template <size_t... fields>
  static constexpr std::array<FieldFunctions, sizeof...(fields)> FunctionsOfFields(
      std::index_sequence<fields...>) {
    return {FieldFunctions{EvaluateField<fields>, ExplainField<fields>, EvaluateSlopes<fields>}...};
  }

  /// Describes which part of a formula gives no finite number at a place.
  void Explain(const Suite& suite, const ProvidedField& provided, const double* at,
               vesper_error& error) const {
    const FieldCode& code = *provided.code;
    const FieldProgram::Uniforms uniforms{suite.parameters[provided.law], suite.time};
    const bool of_slope = code.program.IsFinite(uniforms, at) && code.slopes.size() > 0 &&
                          !code.slopes.IsFinite(uniforms, at);
    const FieldProgram::Cause cause = (of_slope ? code.slopes : code.program).Explain(uniforms, at);
    std::snprintf(error.message, sizeof error.message, "%s%s %s: %s %s at (%g, %g, %g) m",
                  Located(source_, text_, cause.span).c_str(),
                  of_slope ? "slope of field" : "field", code.name.c_str(),
                  QuotedPart(text_, cause.span).c_str(), cause.what, at[0], at[1], at[2]);
    error.law_index = static_cast<uint32_t>(provided.law);
  }

  /// Describes the fields that the laws provide.
  void FillFields() {
    static constexpr auto kFunctions = FunctionsOfFields(std::make_index_sequence<kMaxFields>());
    for (size_t law = 0; law < laws_.size(); ++law) {
      for (const FieldCode& code : laws_[law].fields) {
        if (provided_.size() == kMaxFields) {
          throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: a text provides at most %zu fields",
                        std::string(source_).c_str(), kMaxFields);
        }
        vesper_field_desc desc{};
        desc.struct_size = sizeof desc;
        desc.components = code.components;
        desc.name = code.name.c_str();
        desc.doc = code.doc.c_str();
        desc.unit = ToUnit(code.dimension);
        desc.evaluate = kFunctions[provided_.size()].evaluate;
        desc.explain = kFunctions[provided_.size()].explain;
        if (code.slopes.size() > 0) desc.slopes = kFunctions[provided_.size()].slopes;
        if (code.program.DependsOnTime()) desc.begin_step = BeginStep;
        provided_.push_back({law, &code});
        fields_.push_back(desc);
      }
    }
    if (fields_.empty()) return;
    table_.open = OpenSuite;
    table_.close = CloseSuite;
    table_.field_count = static_cast<uint32_t>(fields_.size());
    table_.fields = fields_.data();
  }

  void FillUses(size_t law, size_t precision) {
    for (const uint32_t place : laws_[law].table_order) {
      const PropertyCode& property = laws_[law].properties[place];
      vesper_property_use use{};
      use.struct_size = sizeof use;
      use.scalar_type = property.is_reference      ? VESPER_U32
                        : property.is_field        ? VESPER_FIELD
                        : property.other_type != 0 ? property.other_type
                                                   : kPrecisions[precision];
      use.name = property.name.c_str();
      use.kind = property.is_field ? property.field_kind.c_str() : property.kind.c_str();
      use.components = property.is_field ? property.field_components : property.components;
      use.access = property.Access();
      use.unit = ToUnit(property.dimension);
      use.flags =
          (property.optional ? VESPER_USE_OPTIONAL : 0) | (property.sloped ? VESPER_USE_SLOPE : 0);
      uses_[2 * law + precision].push_back(use);
    }
  }

  void FillParameters(size_t law) {
    for (const ParameterCode& parameter : laws_[law].parameters) {
      vesper_parameter_desc desc{};
      desc.struct_size = sizeof desc;
      desc.name = parameter.name.c_str();
      desc.doc = parameter.doc.c_str();
      desc.unit = ToUnit(parameter.dimension);
      desc.default_value = parameter.value;
      desc.minimum = parameter.minimum;
      desc.maximum = parameter.maximum;
      parameters_[law].push_back(desc);
    }
  }

  vesper_law_desc Describe(size_t law, size_t precision) const {
    static constexpr auto kCreate = CreateFunctions(std::make_index_sequence<2 * kMaxLaws>());
    const auto& uses = uses_[2 * law + precision];
    const LawCode& code = laws_[law];
    vesper_law_desc desc{};
    desc.struct_size = sizeof desc;
    desc.real_type = kPrecisions[precision];
    desc.name = code.name.c_str();
    desc.version = code.version.c_str();
    desc.doc = code.doc.c_str();
    desc.phase = code.phase;
    desc.stages = code.stages;
    desc.first_stage = code.first_stage;
    desc.use_count = static_cast<uint32_t>(uses.size());
    desc.uses = uses.data();
    desc.parameter_count = static_cast<uint32_t>(parameters_[law].size());
    desc.parameters = parameters_[law].data();
    desc.claims = code.claims;
    desc.create = kCreate[2 * law + precision];
    desc.bind = text::Bind;
    desc.advance = text::Advance;
    desc.destroy = text::Destroy;
    if (code.has_energy) desc.potential_energy = text::PotentialEnergy;
    if (!code.force_weights.empty()) desc.force_weights = code.force_weights.data();
    return desc;
  }

  std::string_view source_;
  std::string_view text_;
  std::vector<LawCode> laws_;
  std::vector<std::vector<vesper_property_use>> uses_;  // uses by law and precision
  std::vector<std::vector<vesper_parameter_desc>> parameters_;
  std::vector<vesper_law_desc> descs_;
  std::vector<ProvidedField> provided_;
  std::vector<vesper_field_desc> fields_;
  vesper_law_library table_{};
};

namespace {

std::vector<LawTree> ParseChecked(std::string_view text, Problems& problems) {
  if (text.size() > kMaxText) {
    problems.Add({0, 1}, "the text has " + std::to_string(text.size()) + " bytes, at most " +
                             std::to_string(kMaxText) + " are allowed");
    return {};
  }
  const auto control = std::ranges::find_if(text, [](char c) {
    return (static_cast<unsigned char>(c) < ' ' && c != '\n' && c != '\r' && c != '\t') ||
           c == 0x7f;
  });
  if (control != text.end()) {
    const auto at = static_cast<uint32_t>(control - text.begin());
    char name[8];
    std::snprintf(name, sizeof name, "0x%02x", static_cast<unsigned char>(*control));
    problems.Add({at, at + 1}, std::string("the text contains the control character ") + name,
                 "delete it");
    return {};
  }
  std::vector<LawTree> laws = Parse(text, problems);
  if (laws.size() > kMaxLaws) {
    problems.Add(laws[kMaxLaws].name.span, "a text has at most 16 laws");
    laws.resize(kMaxLaws);  // limits the work for the others
  }
  for (size_t i = 0; i < laws.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (laws[i].name.word == laws[j].name.word) {
        problems.Add(laws[i].name.span, "a law '" + laws[i].name.word + "' is in the text already");
      }
    }
  }
  return laws;
}

std::vector<LawCode> CheckAll(std::string_view text, const std::vector<LawTree>& laws,
                              const Prototype& prototype, Problems& problems) {
  std::vector<LawCode> codes;
  for (const LawTree& law : laws) {
    if (problems.full()) break;
    codes.push_back(Check(text, law, prototype, problems));
  }
  return codes;
}

[[noreturn]] void Refuse(const Problems& problems, std::string_view source, std::string_view text) {
  throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s", problems.FirstLine(source, text).c_str());
}

}  // namespace

TextLibrary::TextLibrary(std::string source, std::string text)
    : source_(std::move(source)), text_(std::move(text)) {
  Problems problems;
  laws_ = ParseChecked(text_, problems);
  if (!problems.empty()) Refuse(problems, source_, text_);
}

TextLibrary::~TextLibrary() = default;

const vesper_law_library& TextLibrary::TableFor(const Prototype& prototype) {
  Problems problems;
  std::vector<LawCode> codes = CheckAll(text_, laws_, prototype, problems);
  if (!problems.empty()) Refuse(problems, source_, text_);
  compiled_.push_back(std::make_unique<CompiledText>(source_, text_, std::move(codes)));
  return compiled_.back()->table();
}

std::string Report(std::string_view source, std::string_view text, const Prototype& prototype) {
  Problems problems;
  const std::vector<LawTree> laws = ParseChecked(text, problems);
  if (problems.empty()) CheckAll(text, laws, prototype, problems);
  return problems.Report(source, text.substr(0, kMaxText));
}

std::string ToCpp(std::string_view source, std::string_view text, const Prototype& prototype) {
  Problems problems;
  const std::vector<LawTree> laws = ParseChecked(text, problems);
  std::vector<LawCode> codes;
  if (problems.empty()) codes = CheckAll(text, laws, prototype, problems);
  if (!problems.empty()) Refuse(problems, source, text);
  for (const LawCode& code : codes) {
    for (const PassCode& pass : code.passes) {
      if (pass.within == kNoNode || code.properties[pass.position].fixed_type == 0) continue;
      throw Failure(VESPER_LIBRARY_LOAD_FAILED,
                    "%s: law %s searches for pairs by positions with another precision than the "
                    "world; such laws are not translated to C++",
                    std::string(source).c_str(), code.name.c_str());
    }
    if (std::ranges::none_of(code.properties, &PropertyCode::sloped)) continue;
    throw Failure(VESPER_LIBRARY_LOAD_FAILED,
                  "%s: law %s has an energy that depends on a field; such laws are not translated "
                  "to C++; write the force itself: force += …",
                  std::string(source).c_str(), code.name.c_str());
  }
  return WriteCpp(source, text, codes);
}

}  // namespace vesper::text
