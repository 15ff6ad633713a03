// SPDX-License-Identifier: Apache-2.0
#include "served_library.hpp"

#include <dlfcn.h>

#include <cstring>
#include <exception>

#include "failure.hpp"
#include "floating_point.hpp"
#include "grain.hpp"
#include "loop_bound.hpp"
#include "message.hpp"

namespace vesper::apart {
namespace {

using host::Reader;
using host::Writer;

void WriteUse(Writer& to, const vesper_property_use& use) {
  to.Text(use.name);
  to.Text(use.kind);
  to.Value(use.scalar_type);
  to.Value(use.components);
  to.Value(use.access);
  to.Unit(use.unit);
  to.Value(use.flags);
}

void WriteParameter(Writer& to, const vesper_parameter_desc& parameter) {
  to.Text(parameter.name);
  to.Text(parameter.doc);
  to.Unit(parameter.unit);
  to.Value(parameter.default_value);
  to.Value(parameter.minimum);
  to.Value(parameter.maximum);
}

void WriteLaw(Writer& to, const vesper_law_desc& law) {
  to.Value(law.real_type);
  for (const char* text : {law.name, law.version, law.doc}) to.Text(text);
  to.Value(law.phase);
  to.Value(law.stages);
  to.Value(law.claims);
  to.Value(law.first_stage);
  to.Value(uint32_t{law.potential_energy != nullptr});
  const uint32_t weights = law.force_weights == nullptr ? 0 : law.stages + 1;
  to.Value(weights);
  for (uint32_t i = 0; i < weights; ++i) to.Value(law.force_weights[i]);
  to.Value(law.use_count);
  for (uint32_t i = 0; i < law.use_count; ++i) WriteUse(to, law.uses[i]);
  to.Value(law.parameter_count);
  for (uint32_t i = 0; i < law.parameter_count; ++i) WriteParameter(to, law.parameters[i]);
}

}  // namespace

ServedLibrary::ServedLibrary(Exchange& exchange, std::byte* read, std::byte* written)
    : exchange_(exchange), read_(read), written_(written) {
  host_.struct_size = sizeof host_;
  host_.context = this;
  host_.log = Log;
  host_.parallel_for = ParallelFor;
}

void ServedLibrary::Open(const std::string& path, const std::string& source) {
  source_ = source;
  const FloatingPointGuard guard;
  handle_ = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle_ != nullptr) return;
  std::string message = dlerror();
  if (message.starts_with(path + ": ")) message.erase(0, path.size() + 2);
  throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: %s", source.c_str(), message.c_str());
}

void ServedLibrary::Answer() noexcept {
  exchange_.log_used = 0;
  exchange_.log_dropped = 0;
  vesper_error error = BlankError();
  exchange_.status = Guarded(&error, [this] { Dispatch(); });
  exchange_.error = error;
}

void ServedLibrary::Dispatch() {
  if (refused_.status != VESPER_OK) throw Failure(refused_);
  switch (exchange_.command) {
    case Command::kDescribe:
      return Describe();
    case Command::kCreate:
      return Create();
    case Command::kBind:
      return Bind();
    case Command::kAdvance: {
      const vesper_step step = exchange_.step;
      return CallLaw([&](const vesper_law_desc& desc, vesper_error* error) {
        return desc.advance(Law(), &step, error);
      });
    }
    case Command::kPotentialEnergy:
      return CallLaw([&](const vesper_law_desc& desc, vesper_error* error) {
        double energy = 0;
        const vesper_status status = desc.potential_energy(Law(), &energy, error);
        exchange_.energy = energy;
        return status;
      });
  }
  throw Failure(VESPER_INTERNAL, "unknown command");
}

void ServedLibrary::Describe() {
  const auto entry = reinterpret_cast<decltype(&vesper_law_library_entry)>(
      dlsym(handle_, VESPER_LAW_LIBRARY_ENTRY));
  if (entry == nullptr) {
    throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: does not export %s", source_.c_str(),
                  VESPER_LAW_LIBRARY_ENTRY);
  }
  tables_.emplace_back(entry(), source_.c_str());
  const vesper_law_library& library = tables_.front().library();
  laws_.resize(library.law_count);
  host_.user = library.user;
  Writer to(Mailbox(exchange_), kMailboxSize);
  to.Text(library.name);
  to.Value(library.field_count);
  to.Value(library.law_count);
  for (uint32_t i = 0; i < library.law_count; ++i) WriteLaw(to, library.laws[i]);
}

vesper_law* ServedLibrary::Law() { return laws_.at(exchange_.law).law; }

/// Calls a function of the law. Converts a status other than OK, or an exception, to a Failure.
template <class Call>
void ServedLibrary::CallLaw(Call&& call) {
  const vesper_law_desc& desc = tables_.at(0).library().laws[exchange_.law];
  vesper_error error = BlankError();
  vesper_status status;
  try {
    const FloatingPointGuard guard;
    status = call(desc, &error);
  } catch (const std::exception& exception) {
    throw Failure(VESPER_LAW_FAILED, "threw: %s", exception.what());
  } catch (...) {
    throw Failure(VESPER_LAW_FAILED, "threw an exception of unknown type");
  }
  ReportRefusedLoop("");
  if (status == VESPER_OK) return;
  Sanitize(error);
  error.status = status;
  throw Failure(error);
}

void ServedLibrary::Create() {
  const vesper_law_library& library = tables_.at(0).library();
  if (suite_ == nullptr && library.open != nullptr) {
    CallLaw([&](const vesper_law_desc&, vesper_error* error) {
      return library.open(&host_, &suite_, error);
    });
    if (suite_ == nullptr) {
      throw Failure(VESPER_LAW_FAILED, "open returned OK but no suite");
    }
  }
  Reader from(Mailbox(exchange_), kMailboxSize);
  std::vector<double> parameters(library.laws[exchange_.law].parameter_count);
  for (double& value : parameters) value = from.Value<double>();
  vesper_law* law = nullptr;
  CallLaw([&](const vesper_law_desc& desc, vesper_error* error) {
    return desc.create(&host_, suite_, parameters.data(), &law, error);
  });
  if (law == nullptr) throw Failure(VESPER_LAW_FAILED, "create returned OK but no law");
  laws_.at(exchange_.law).law = law;
}

void ServedLibrary::Bind() {
  const vesper_law_desc& desc = tables_.at(0).library().laws[exchange_.law];
  Reader from(Mailbox(exchange_), kMailboxSize);
  std::vector<vesper_property>& properties = laws_.at(exchange_.law).properties;
  properties.assign(desc.use_count, {});
  for (uint32_t i = 0; i < desc.use_count; ++i) {
    const vesper_property_use& use = desc.uses[i];
    const auto present = from.Value<uint32_t>();
    const auto offset = from.Value<uint64_t>();
    const auto rows = from.Value<uint64_t>();
    const auto version = from.Value<uint64_t>();
    std::byte* segment = use.access == VESPER_READ ? read_ : written_;
    properties[i] = {sizeof(vesper_property),
                     use.scalar_type,
                     use.name,
                     use.kind,
                     use.components,
                     use.access,
                     present == 0 ? nullptr : segment + offset,
                     rows,
                     version};
  }
  CallLaw([&](const vesper_law_desc& law, vesper_error* error) {
    return law.bind(Law(), properties.data(), error);
  });
}

void ServedLibrary::Log(void* context, uint32_t level, const char* message) {
  if (message == nullptr) return;
  Exchange& exchange = static_cast<ServedLibrary*>(context)->exchange_;
  const auto length = static_cast<uint32_t>(strnlen(message, kMaxLine));
  const size_t size = 2 * sizeof(uint32_t) + length;
  if (exchange.log_used > kLogSize || size > kLogSize - exchange.log_used) {
    ++exchange.log_dropped;
    return;
  }
  char* at = exchange.log + exchange.log_used;
  std::memcpy(at, &level, sizeof level);
  std::memcpy(at + sizeof level, &length, sizeof length);
  std::memcpy(at + 2 * sizeof level, message, length);
  exchange.log_used += static_cast<uint32_t>(size);
}

/// Calls the body on this thread, because a sandbox has no other threads. The ranges are those of
/// the engine, so the result has the same bits.
void ServedLibrary::ParallelFor(void*, uint64_t count, uint64_t grain,
                                void (*body)(void* user, uint64_t begin, uint64_t end),
                                void* user) {
  if (RefuseLoop(count)) return;
  if (grain == 0) grain = ChooseGrain(count);
  for (uint64_t begin = 0; begin < count;) {
    const uint64_t size = std::min(grain, count - begin);
    body(user, begin, begin + size);
    begin += size;
  }
}

}  // namespace vesper::apart
