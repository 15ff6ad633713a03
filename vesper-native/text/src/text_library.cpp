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
  static vesper_status CreateLaw(const vesper_host* host, vesper_suite*, const double* parameters,
                                 vesper_law** out, vesper_error* error) {
    return Guarded(error, [&] {
      const auto* text = static_cast<const CompiledText*>(host->user);
      *out = reinterpret_cast<vesper_law*>(text->Create(entry, *host, parameters).release());
    });
  }
  template <size_t... entries>
  static constexpr std::array<CreateFunction, sizeof...(entries)> CreateFunctions(
      std::index_sequence<entries...>) {
    return {CreateLaw<entries>...};
  }

  void FillUses(size_t law, size_t precision) {
    for (const uint32_t place : laws_[law].table_order) {
      const PropertyCode& property = laws_[law].properties[place];
      vesper_property_use use{};
      use.struct_size = sizeof use;
      use.scalar_type = property.is_reference ? VESPER_U32 : kPrecisions[precision];
      use.name = property.name.c_str();
      use.kind = property.kind.c_str();
      use.components = property.components;
      use.access = property.Access();
      use.unit = ToUnit(property.dimension);
      use.flags = property.optional ? VESPER_USE_OPTIONAL : 0;
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
  for (size_t i = 0; i < laws.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (laws[i].name.word == laws[j].name.word) {
        problems.Add(laws[i].name.span, "a law '" + laws[i].name.word + "' is in the text already");
      }
    }
  }
  if (laws.size() > kMaxLaws) {
    problems.Add(laws[kMaxLaws].name.span, "a text has at most 16 laws");
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
  return WriteCpp(source, text, codes);
}

}  // namespace vesper::text
