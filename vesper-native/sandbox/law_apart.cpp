// SPDX-License-Identifier: Apache-2.0
#include "law_apart.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <memory>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "failure.hpp"
#include "law_table.hpp"
#include "long_lived_thread.hpp"
#include "message.hpp"
#include "unit.hpp"

namespace vesper::apart {
namespace {

using host::Reader;
using host::Writer;

constexpr uint64_t kAlignment = 64;
constexpr int kMostTries = 5;  // maximum number of tries of a call whose sandbox is killed from
                               // outside

uint64_t SizeOf(const vesper_property& property) {
  return property.row_count * property.components * ScalarSize(property.scalar_type);
}

/// A law of the library, as its sandbox has described it.
struct Declared {
  std::deque<std::string> texts;  // strings to which the descriptions point
  std::vector<double> force_weights;
  std::vector<vesper_property_use> uses;
  std::vector<vesper_parameter_desc> parameters;
  vesper_law_desc desc{};

  const char* Keep(std::string text) { return texts.emplace_back(std::move(text)).c_str(); }
};

uint32_t ReadCount(Reader& from) {
  const auto count = from.Value<uint32_t>();
  if (count > kMaxTableEntries) throw Failure(VESPER_LIBRARY_LOAD_FAILED, "a table is too long");
  return count;
}

vesper_property_use ReadUse(Reader& from, Declared& law) {
  vesper_property_use use{};
  use.struct_size = sizeof use;
  use.name = law.Keep(from.Text());
  use.kind = law.Keep(from.Text());
  use.scalar_type = from.Value<uint32_t>();
  use.components = from.Value<uint32_t>();
  use.access = from.Value<uint32_t>();
  use.unit = from.Unit();
  use.flags = from.Value<uint32_t>();
  return use;
}

vesper_parameter_desc ReadParameter(Reader& from, Declared& law) {
  vesper_parameter_desc parameter{};
  parameter.struct_size = sizeof parameter;
  parameter.name = law.Keep(from.Text());
  parameter.doc = law.Keep(from.Text());
  parameter.unit = from.Unit();
  parameter.default_value = from.Value<double>();
  parameter.minimum = from.Value<double>();
  parameter.maximum = from.Value<double>();
  return parameter;
}

class Library;

vesper_status Bind(vesper_law* law, const vesper_property* properties, vesper_error* error);
vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error);
vesper_status PotentialEnergy(vesper_law* law, double* out, vesper_error* error);
void Destroy(vesper_law* law);

void ReadLaw(Reader& from, Declared& law) {
  vesper_law_desc& desc = law.desc;
  desc.struct_size = sizeof desc;
  desc.real_type = from.Value<uint32_t>();
  desc.name = law.Keep(from.Text());
  desc.version = law.Keep(from.Text());
  desc.doc = law.Keep(from.Text());
  desc.phase = from.Value<uint32_t>();
  desc.stages = from.Value<uint32_t>();
  desc.claims = from.Value<uint32_t>();
  desc.first_stage = from.Value<uint32_t>();
  if (from.Value<uint32_t>() != 0) desc.potential_energy = PotentialEnergy;
  law.force_weights.resize(ReadCount(from));
  for (double& weight : law.force_weights) weight = from.Value<double>();
  if (!law.force_weights.empty()) {
    law.force_weights.resize(std::max<size_t>(law.force_weights.size(), 17));  // stages + 1 at most
    desc.force_weights = law.force_weights.data();
  }
  law.uses.resize(ReadCount(from));
  for (vesper_property_use& use : law.uses) use = ReadUse(from, law);
  law.parameters.resize(ReadCount(from));
  for (vesper_parameter_desc& parameter : law.parameters) parameter = ReadParameter(from, law);
  desc.use_count = static_cast<uint32_t>(law.uses.size());
  desc.uses = law.uses.data();
  desc.parameter_count = static_cast<uint32_t>(law.parameters.size());
  desc.parameters = law.parameters.data();
  desc.bind = apart::Bind;
  desc.advance = apart::Advance;
  desc.destroy = apart::Destroy;
}

/// A library that runs in a sandbox, with its bytes, its table, and the present sandbox. The engine
/// frees this object after the laws of the library.
class Library {
 public:
  Library(const vesper_prototype& prototype, const Options& options,
          std::span<const std::byte> bytes, std::string source);

  const vesper_law_library& table() const { return table_; }
  const Declared& law(size_t index) const { return laws_[index]; }
  /// Returns the sandbox. Starts another sandbox if the last one has ended.
  Sandbox& Live();
  /// Returns true if the last sandbox was killed from outside.
  bool WasKilled() const { return sandbox_->WasKilled(); }
  /// Returns a number that increases with each new sandbox.
  uint64_t generation() const { return generation_; }
  /// Returns true if no law may write the property, so that it changes only when it is bound.
  bool IsSteady(const char* property) const { return steady_.contains(property); }
  std::string Missing() const { return sandbox_->layers().Missing(); }

 private:
  void Describe();
  void Refuse(const char* reason) const {
    throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: cannot run apart: %s", source_.c_str(), reason);
  }

  Options options_;
  std::vector<std::byte> bytes_;
  std::string source_;
  std::set<std::string> steady_;
  std::unique_ptr<Sandbox> sandbox_;
  uint64_t generation_ = 1;
  std::string name_;
  std::deque<Declared> laws_;
  std::vector<vesper_law_desc> descs_;
  vesper_law_library table_{};
};

/// A law in an engine: the `vesper_law` between `create` and `destroy`.
class Proxy {
 public:
  Proxy(const vesper_host& host, Library& library, uint32_t index, const double* parameters)
      : host_(host),
        library_(library),
        index_(index),
        uses_(library.law(index).uses),
        parameters_(parameters, parameters + library.law(index).parameters.size()) {
    for (const vesper_property_use& use : uses_) steady_.push_back(library.IsSteady(use.name));
    Repeated([this] { Connect(); });
  }

  void Bind(const vesper_property* properties) {
    bound_.assign(properties, properties + uses_.size());
    Repeated([this] { BindIn(Connected()); });
  }

  void Advance(const vesper_step& step) {
    Repeated([&] {
      Sandbox& sandbox = Ready();
      CopyIn(sandbox, false);
      sandbox.exchange().step = step;
      Call(sandbox, Command::kAdvance, true);
      CopyOut(sandbox);
    });
  }

  double PotentialEnergy() {
    double energy = 0;
    Repeated([&] {
      Sandbox& sandbox = Ready();
      CopyIn(sandbox, false);
      Call(sandbox, Command::kPotentialEnergy, true);
      energy = sandbox.exchange().energy;
    });
    return energy;
  }

 private:
  /// Makes a call of the law. Repeats the call in a new sandbox if another process killed the
  /// sandbox during the call. The interrupted call has written nothing to the engine's arrays.
  template <class Function>
  void Repeated(Function&& function) {
    for (int tries = 1;; ++tries) {
      try {
        return function();
      } catch (const Failure&) {
        if (!library_.WasKilled() || tries == kMostTries) throw;
      }
    }
  }

  /// Creates the law in the present sandbox.
  Sandbox& Connect() {
    Sandbox& sandbox = library_.Live();
    generation_ = library_.generation();
    reading_ = writing_ = Region();
    Writer to(Mailbox(sandbox.exchange()), kMailboxSize);
    for (const double value : parameters_) to.Value(value);
    Call(sandbox, Command::kCreate, false);
    return sandbox;
  }

  Sandbox& Connected() {
    Sandbox& sandbox = library_.Live();
    return generation_ == library_.generation() ? sandbox : Connect();
  }

  /// Returns a sandbox in which the law is created and bound.
  Sandbox& Ready() {
    Sandbox& sandbox = library_.Live();
    if (generation_ == library_.generation()) return sandbox;
    BindIn(Connect());
    return library_.Live();
  }

  bool IsWritten(size_t use) const { return uses_[use].access != VESPER_READ; }

  std::byte* At(Sandbox& sandbox, size_t use) const {
    return IsWritten(use) ? sandbox.written() + writing_.offset + offsets_[use]
                          : sandbox.read() + reading_.offset + offsets_[use];
  }

  void BindIn(Sandbox& sandbox) {
    uint64_t ends[2] = {0, 0};
    offsets_.assign(uses_.size(), 0);
    for (size_t i = 0; i < uses_.size(); ++i) {
      uint64_t& end = ends[IsWritten(i)];
      offsets_[i] = end;
      end += (SizeOf(bound_[i]) + kAlignment - 1) / kAlignment * kAlignment + kAlignment;
    }
    sandbox.Reserve(false, reading_, ends[0]);
    sandbox.Reserve(true, writing_, ends[1]);
    CopyIn(sandbox, true);
    Writer to(Mailbox(sandbox.exchange()), kMailboxSize);
    for (size_t i = 0; i < uses_.size(); ++i) {
      to.Value(uint32_t{bound_[i].data != nullptr});
      to.Value((IsWritten(i) ? writing_ : reading_).offset + offsets_[i]);
      to.Value(bound_[i].row_count);
      to.Value(bound_[i].version);
    }
    Call(sandbox, Command::kBind, false);
  }

  void CopyIn(Sandbox& sandbox, bool all) {
    for (size_t i = 0; i < uses_.size(); ++i) {
      if (bound_[i].row_count == 0 || (steady_[i] && !all)) continue;
      std::memcpy(At(sandbox, i), bound_[i].data, SizeOf(bound_[i]));
    }
  }

  void CopyOut(Sandbox& sandbox) {
    for (size_t i = 0; i < uses_.size(); ++i) {
      if (bound_[i].row_count == 0 || !IsWritten(i)) continue;
      std::memcpy(bound_[i].data, At(sandbox, i), SizeOf(bound_[i]));
    }
  }

  /// Carries out a command, and passes the log lines of the law to the engine.
  void Call(Sandbox& sandbox, Command command, bool limited) {
    const auto log = [&] { PassLog(sandbox.exchange()); };
    try {
      sandbox.Call(command, index_, limited);
    } catch (...) {
      log();
      throw;
    }
    log();
  }

  void PassLog(const Exchange& exchange) {
    const uint32_t used = std::min<uint32_t>(exchange.log_used, kLogSize);
    if (used == 0) return;
    const std::vector<char> lines(exchange.log, exchange.log + used);
    Reader from(reinterpret_cast<const std::byte*>(lines.data()), lines.size());
    try {
      for (uint64_t read = 0; read < used;) {
        const auto level = from.Value<uint32_t>();
        const std::string line = from.Text();
        host_.log(host_.context, std::clamp(level, VESPER_LOG_DEBUG, VESPER_LOG_ERROR),
                  line.c_str());
        read += 2 * sizeof level + line.size();
      }
    } catch (const std::exception&) {
      // The exception is ignored. It means that the law has overwritten the log lines.
    }
    const uint32_t dropped = exchange.log_dropped;
    if (dropped == 0) return;
    const std::string text = std::to_string(dropped) + " more log lines were dropped";
    host_.log(host_.context, VESPER_LOG_WARNING, text.c_str());
  }

  const vesper_host& host_;
  Library& library_;
  uint32_t index_;
  const std::vector<vesper_property_use>& uses_;
  std::vector<bool> steady_;  // whether the property of each use is steady
  std::vector<double> parameters_;
  std::vector<vesper_property> bound_;
  std::vector<uint64_t> offsets_;  // offset of each use in its region [bytes]
  Region reading_;
  Region writing_;
  uint64_t generation_ = 0;
};

template <size_t index>
vesper_status Create(const vesper_host* host, vesper_suite*, const double* parameters,
                     vesper_law** out, vesper_error* error) {
  return Guarded(error, [&] {
    auto& library = *static_cast<Library*>(const_cast<void*>(host->user));
    if (const std::string missing = library.Missing(); index == 0 && !missing.empty()) {
      const std::string text = "runs apart without " + missing;
      host->log(host->context, VESPER_LOG_WARNING, text.c_str());
    }
    *out = reinterpret_cast<vesper_law*>(new Proxy(*host, library, index, parameters));
  });
}

template <size_t... indices>
constexpr auto CreateFunctions(std::index_sequence<indices...>) {
  return std::array<decltype(vesper_law_desc::create), sizeof...(indices)>{Create<indices>...};
}

Proxy& ProxyOf(vesper_law* law) { return *reinterpret_cast<Proxy*>(law); }

vesper_status Bind(vesper_law* law, const vesper_property* properties, vesper_error* error) {
  return Guarded(error, [&] { ProxyOf(law).Bind(properties); });
}

vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  return Guarded(error, [&] { ProxyOf(law).Advance(*step); });
}

vesper_status PotentialEnergy(vesper_law* law, double* out, vesper_error* error) {
  return Guarded(error, [&] { *out = ProxyOf(law).PotentialEnergy(); });
}

void Destroy(vesper_law* law) { delete &ProxyOf(law); }

/// Returns the properties that no law may write.
std::set<std::string> SteadyProperties(const vesper_prototype& prototype) {
  std::set<std::string> steady;
  const auto* at = reinterpret_cast<const std::byte*>(prototype.properties);
  for (uint32_t i = 0; i < prototype.property_count; ++i) {
    vesper_property_descriptor property{};
    const uint32_t size = prototype.properties->struct_size;
    std::memcpy(&property, at + size_t{i} * size, std::min<size_t>(sizeof property, size));
    if ((property.law_access & (VESPER_WRITE | VESPER_ACCUMULATE)) == 0) {
      steady.insert(property.name);
    }
  }
  return steady;
}

Library::Library(const vesper_prototype& prototype, const Options& options,
                 std::span<const std::byte> bytes, std::string source)
    : options_(options),
      bytes_(bytes.begin(), bytes.end()),
      source_(std::move(source)),
      steady_(SteadyProperties(prototype)),
      sandbox_(std::make_unique<Sandbox>(options_, bytes_, source_)) {
  static constexpr auto kCreate = CreateFunctions(std::make_index_sequence<kMaxTableEntries>());
  sandbox_->Call(Command::kDescribe, 0, false);
  // Copies the description, because the library can overwrite the exchange at any time.
  const std::vector<std::byte> described(Mailbox(sandbox_->exchange()),
                                         Mailbox(sandbox_->exchange()) + kMailboxSize);
  Reader from(described.data(), described.size());
  name_ = from.Text();
  if (from.Value<uint32_t>() != 0) Refuse("it provides a field, which other laws call");
  laws_.resize(ReadCount(from));
  for (Declared& law : laws_) {
    ReadLaw(from, law);
    law.desc.create = kCreate[descs_.size()];
    for (const vesper_property_use& use : law.uses) {
      if ((use.flags & VESPER_USE_DEFERRED) != 0) Refuse("it keeps properties on a device");
      if (use.scalar_type == VESPER_FIELD) Refuse("it reads a field, which other code computes");
    }
    descs_.push_back(law.desc);
  }
  table_.struct_size = sizeof table_;
  table_.abi_version = VESPER_ABI_VERSION;
  table_.name = name_.c_str();
  table_.law_count = static_cast<uint32_t>(descs_.size());
  table_.laws = descs_.data();
  table_.user = this;
}

Sandbox& Library::Live() {
  if (sandbox_->IsAlive()) return *sandbox_;
  sandbox_ = std::make_unique<Sandbox>(options_, bytes_, source_);
  sandbox_->Call(Command::kDescribe, 0, false);
  ++generation_;
  return *sandbox_;
}

}  // namespace

void Prepare() { LongLivedThread::Get(); }

vesper_status PrepareApart(const vesper_prototype& prototype, const Options& options,
                           std::span<const std::byte> bytes, const std::string& source,
                           vesper_prepared_library** out, vesper_error* error) {
  return Guarded(error, [&] {
    try {
      auto library = std::make_unique<Library>(prototype, options, bytes, source);
      const auto release = [](void* user) { delete static_cast<Library*>(user); };
      vesper_error refused = BlankError();
      if (vesper_library_prepare_table(&library->table(), release, library.get(), out, &refused) !=
          VESPER_OK) {
        throw Failure(refused).Within(source);
      }
      library.release();
    } catch (const Failure& failure) {
      const bool named = std::string_view(failure.error().message).starts_with(source + ":");
      vesper_error refused = failure.error();
      refused.status = VESPER_LIBRARY_LOAD_FAILED;
      throw named ? Failure(refused) : Failure(refused).Within(source);
    }
  });
}

}  // namespace vesper::apart
