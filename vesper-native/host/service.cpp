// SPDX-License-Identifier: Apache-2.0
#include "service.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "isolation.hpp"
#include "python_laws.hpp"
#include "received_prototype.hpp"

namespace vesper::host {
namespace {

constexpr uint32_t kNoDescriptor = UINT32_MAX;
constexpr size_t kMaxLine = 1024;
constexpr uint32_t kMaxScratchValues = 4096;  // as many as a SCRATCH use may have in a row
constexpr uint64_t kUnlimitedMemory = uint64_t{1} << 42;  // [bytes]

/// An exception that is thrown after a function of engine.h has failed. The service contains the
/// error.
struct Refused {
  vesper_status status;
};

void Check(vesper_status status) {
  if (status != VESPER_OK) throw Refused{status};
}

/// Calls `visit` for each element of an array whose stride is the first element's struct_size.
template <class T, class Visit>
void ForEach(const T* first, uint32_t count, Visit&& visit) {
  const auto* at = reinterpret_cast<const std::byte*>(first);
  for (uint32_t i = 0; i < count; ++i, at += first->struct_size) {
    T element{};
    std::memcpy(&element, at, std::min<size_t>(sizeof element, first->struct_size));
    visit(element);
  }
}

}  // namespace

Service::Service(int client, Control& control, uint64_t memory_limit)
    : client_(client), control_(control), memory_limit_(memory_limit) {}

Service::~Service() = default;

void Service::Answer() {
  control_.log_used = 0;
  control_.log_dropped = 0;
  std::byte* mailbox = Mailbox(control_);
  uint32_t size;
  std::memcpy(&size, mailbox, sizeof size);
  const std::byte* begin = mailbox + sizeof size;
  request_.assign(begin, begin + std::min<size_t>(size, kMailboxSize - sizeof size));
  Writer reply(mailbox, kMailboxSize);
  reply.Value(int32_t{VESPER_OK});
  try {
    Dispatch(Reader(request_.data(), request_.size()), reply);
    return;
  } catch (const Refused& refused) {
    error_.status = refused.status;
  } catch (const std::exception& failure) {
    error_ = {};
    error_.status = VESPER_INTERNAL;
    error_.law_index = VESPER_NO_LAW;
    error_.row = VESPER_NO_ROW;
    std::snprintf(error_.message, sizeof error_.message, "vesper-host: %s", failure.what());
  }
  reply.Restart();
  reply.Value(int32_t{error_.status});
  reply.Value(error_);
}

void Service::NoteFault(const void* address) {
  uint64_t offset = 0;
  const char* property = columns_.Find(address, offset);
  if (property == nullptr) return;
  std::strncpy(control_.wrote, property, sizeof control_.wrote - 1);
  control_.wrote_offset = offset;
}

void Service::Dispatch(Reader request, Writer& reply) {
  const auto number = static_cast<Request>(request.Value<uint32_t>());
  if (engine_ == nullptr && number != Request::kCreate) {
    throw std::runtime_error("the first request must create the engine");
  }
  switch (number) {
    case Request::kCreate:
      return Create(request);
    case Request::kAdd:
      return Bind(request, false);
    case Request::kRebind:
      return Bind(request, true);
    case Request::kRemove:
      return Remove(request);
    case Request::kFind:
      return Find(request, reply);
    case Request::kTouch:
      return Touch(request);
    case Request::kPrepare:
      return Prepare(request, reply);
    case Request::kLoad:
      return Load(request, reply);
    case Request::kUnload:
      return Unload(request, reply);
    case Request::kLaws:
      return Laws(request, reply);
    case Request::kAdvance:
      return Advance(request, reply);
    case Request::kClearFault:
      return Check(vesper_engine_clear_fault(engine_.get(), &error_));
    case Request::kMoveRows:
      return MoveRows(request);
    case Request::kSetStepCount: {
      const auto steps = request.Value<uint64_t>();
      const auto dt = request.Value<double>();
      return Check(vesper_engine_set_step_count(engine_.get(), steps, dt, &error_));
    }
    case Request::kStateHash: {
      uint64_t hash = 0;
      Check(vesper_engine_state_hash(engine_.get(), &hash, &error_));
      return reply.Value(hash);
    }
    case Request::kStateMemory: {
      const auto descriptor = request.Value<uint32_t>();
      state_ = Mapping(client_, descriptor, request.Value<uint64_t>(), true);
      return;
    }
    case Request::kSaveState:
      return SaveState(reply);
    case Request::kLoadState:
      return LoadState(request);
    case Request::kSetLedger:
      return Check(vesper_engine_set_ledger(engine_.get(), request.Value<uint32_t>(), &error_));
    case Request::kLedger:
      return Ledger(request, reply);
    case Request::kSetInterval: {
      const auto library = request.Value<vesper_library_id>();
      const auto interval = request.Value<uint32_t>();
      return Check(vesper_engine_set_interval(engine_.get(), library, interval, &error_));
    }
    case Request::kReplace:
      return Replace(request, reply);
    case Request::kBeginChanges:
      return BeginChanges();
    case Request::kEndChanges:
      return EndChanges(request, reply);
    case Request::kScratchRow:
      return ScratchRow(request, reply);
    case Request::kBindAll:
      for (auto left = request.Value<uint32_t>(); left > 0; --left) {
        const bool rebind = request.Value<uint32_t>() != 0;
        Bind(request, rebind);
      }
      return;
  }
  throw std::runtime_error("unknown request " + std::to_string(static_cast<uint32_t>(number)));
}

void Service::Create(Reader& request) {
  vesper_engine_config_init(&config_);
  config_.threads = request.Value<uint32_t>();
  config_.validate = request.Value<uint32_t>();
  config_.touches = 1;
  config_.limit_values = 1;
  config_.rest_without_fields = 1;
  config_.probe_path = "";  // no probe process, because this process itself may crash
  config_.log = Log;
  config_.log_user = this;
  config_.running = control_.running;
  prototype_ = std::make_unique<ReceivedPrototype>(request);
  for (const vesper_property_descriptor& property : prototype_->properties()) {
    if ((property.law_access & VESPER_ACCUMULATE) != 0) accumulators_.emplace_back(property.name);
  }
  vesper_engine* engine = nullptr;
  Check(vesper_engine_create(&config_, &prototype_->get(), &engine, &error_));
  engine_.reset(engine);
  ProtectColumns();
}

void Service::Bind(Reader& request, bool rebind) {
  const std::string name = request.Text();
  const auto descriptor = request.Value<uint32_t>();
  const auto offset = request.Value<uint64_t>();
  const auto size = request.Value<uint64_t>();
  const auto value_count = request.Value<uint64_t>();
  const auto index_descriptor = request.Value<uint32_t>();
  const auto index_offset = request.Value<uint64_t>();
  const auto index_size = request.Value<uint64_t>();
  const auto object_count = request.Value<uint64_t>();
  Columns::Arrays arrays;
  if (descriptor != kNoDescriptor) {
    arrays.data = Mapping(client_, descriptor, size, columns_.IsWritable(name), offset);
  }
  if (index_descriptor != kNoDescriptor) {
    arrays.indices = Mapping(client_, index_descriptor, index_size, false, index_offset);
  }
  const auto bind =
      rebind ? vesper_provider_rebind_physical_property : vesper_provider_add_physical_property;
  Check(bind(provider(), name.c_str(), arrays.data.data(), value_count,
             reinterpret_cast<const uint32_t*>(arrays.indices.data()), object_count, &error_));
  columns_.Replace(name, std::move(arrays));
}

void Service::Remove(Reader& request) {
  const std::string name = request.Text();
  Check(vesper_provider_remove_physical_property(provider(), name.c_str(), &error_));
  columns_.Remove(name);
}

void Service::Find(Reader& request, Writer& reply) {
  const std::string name = request.Text();
  vesper_property found{};
  found.struct_size = sizeof found;
  Check(vesper_provider_find_physical_property(provider(), name.c_str(), &found, &error_));
  reply.Value(found.row_count);
  reply.Value(found.version);
}

void Service::Touch(Reader& request) {
  for (auto left = request.Value<uint32_t>(); left > 0; --left) {
    const std::string name = request.Text();
    const char* names[] = {name.c_str()};
    Check(vesper_provider_touch(provider(), names, 1, &error_));
  }
}

apart::Options Service::SandboxOptions(bool incomplete) const {
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe");
  return {own.parent_path() / "vesper-sandbox",
          memory_limit_ == 0 ? kUnlimitedMemory : memory_limit_, incomplete};
}

vesper_prepared_library* Service::Open(Reader& request, std::string* versions) {
  const std::string source = request.Text();
  const auto form = static_cast<Form>(request.Value<uint32_t>());
  const auto descriptor = request.Value<uint32_t>();
  const Mapping bytes(client_, descriptor, request.Value<uint64_t>(), false);
  vesper_prepared_library* prepared = nullptr;
  switch (form) {
    case Form::kNative:
      Check(vesper_library_prepare_bytes(&config_, bytes.data(), bytes.size(), source.c_str(),
                                         &prepared, &error_));
      return prepared;
    case Form::kText:
      Check(vesper_library_prepare_text(source.c_str(), reinterpret_cast<const char*>(bytes.data()),
                                        bytes.size(), &prepared, &error_));
      return prepared;
    case Form::kPython:
      Check(python::PreparePython(prototype_->get(), source, bytes.data(), bytes.size(), &prepared,
                                  &error_, versions));
      return prepared;
    case Form::kApart:
    case Form::kApartWeakly:
      Check(apart::PrepareApart(prototype_->get(), SandboxOptions(form == Form::kApartWeakly),
                                std::span(bytes.data(), bytes.size()), source, &prepared, &error_));
      return prepared;
  }
  throw std::runtime_error("unknown form of a law library");
}

void Service::Prepare(Reader& request, Writer& reply) {
  std::string versions;
  vesper_prepared_library* prepared = Open(request, &versions);
  reply.Text(vesper_library_name(prepared));
  reply.Text(versions.c_str());
  vesper_library_discard(prepared);
}

namespace {
/// The parameters in a request to load a library.
class Parameters {
 public:
  explicit Parameters(Reader& request) : given_(request.Value<uint32_t>()) {
    for (auto& [name, value] : given_) {
      name = request.Text();
      value = request.Value<double>();
    }
    for (const auto& [name, value] : given_) {
      structs_.push_back({sizeof(vesper_parameter), 0, name.c_str(), value});
    }
  }

  const vesper_parameter* data() const { return structs_.data(); }
  uint32_t size() const { return static_cast<uint32_t>(structs_.size()); }

 private:
  std::vector<std::pair<std::string, double>> given_;
  std::vector<vesper_parameter> structs_;
};
}  // namespace

void Service::Load(Reader& request, Writer& reply) {
  reply.Value(CountThreads());
  vesper_prepared_library* prepared = Open(request);
  const Parameters given(request);
  vesper_library_id id = 0;
  const vesper_status status = vesper_engine_load_prepared(engine_.get(), prepared, given.data(),
                                                           given.size(), &id, &error_);
  if (status != VESPER_OK) vesper_library_discard(prepared);
  Check(status);
  libraries_.push_back(id);
  ProtectColumns();
  reply.Value(id);
  WriteLaws(id, reply);
}

void Service::Unload(Reader& request, Writer& reply) {
  const auto id = request.Value<vesper_library_id>();
  Check(vesper_engine_unload_physics_law(engine_.get(), id, &error_));
  std::erase(libraries_, id);
  ProtectColumns();
  reply.Value(CountThreads());
}

/// Replaces a library. Replies with the number of threads of this process before and after the
/// change, and with the new laws.
void Service::Replace(Reader& request, Writer& reply) {
  const uint32_t threads = CountThreads();
  const auto id = request.Value<vesper_library_id>();
  vesper_prepared_library* prepared = Open(request);
  const Parameters given(request);
  const vesper_status status = vesper_engine_replace_library(engine_.get(), id, prepared,
                                                             given.data(), given.size(), &error_);
  if (status != VESPER_OK) vesper_library_discard(prepared);
  Check(status);
  ProtectColumns();
  reply.Value(threads);
  reply.Value(CountThreads());
  WriteLaws(id, reply);
}

void Service::BeginChanges() {
  Check(vesper_engine_begin_changes(engine_.get(), &error_));
  before_ = libraries_;
}

void Service::EndChanges(Reader& request, Writer& reply) {
  const auto keep = request.Value<uint32_t>();
  Check(vesper_engine_end_changes(engine_.get(), keep, &error_));
  if (keep == 0) {
    libraries_ = before_;
    ProtectColumns();
  }
  reply.Value(CountThreads());
}

void Service::Laws(Reader& request, Writer& reply) {
  WriteLaws(request.Value<vesper_library_id>(), reply);
}

/// Writes the laws of a library: the number 1 before each law, and 0 after the last one.
void Service::WriteLaws(vesper_library_id library, Writer& reply) {
  vesper_law_info info{};
  info.struct_size = sizeof info;
  for (uint32_t i = 0; vesper_engine_law_info(engine_.get(), library, i, &info, nullptr) == 0;
       ++i) {
    reply.Value(uint32_t{1});
    for (const char* text : {info.library, info.name, info.version, info.doc}) reply.Text(text);
    reply.Value(info.phase);
    reply.Value(info.stages);
    reply.Value(info.claims);
    reply.Value(info.use_count);
    ForEach(info.uses, info.use_count, [&](const vesper_property_use& use) {
      reply.Text(use.name);
      reply.Text(use.kind);
      reply.Value(use.scalar_type);
      reply.Value(use.components);
      reply.Value(use.access);
      reply.Unit(use.unit);
      reply.Value(use.flags);
    });
    reply.Value(info.parameter_count);
    ForEach(info.parameters, info.parameter_count, [&](const vesper_parameter_desc& parameter) {
      reply.Text(parameter.name);
      reply.Text(parameter.doc == nullptr ? "" : parameter.doc);
      reply.Unit(parameter.unit);
      reply.Value(parameter.default_value);
      reply.Value(parameter.minimum);
      reply.Value(parameter.maximum);
    });
    reply.Value(info.calls);
    reply.Value(info.nanoseconds);
    reply.Value(info.resting);
  }
  reply.Value(uint32_t{0});
}

/// Makes the columns writable that loaded laws write, and the accumulators, which the engine itself
/// writes. Makes all other columns read-only.
void Service::ProtectColumns() {
  std::set<std::string> written(accumulators_.begin(), accumulators_.end());
  vesper_law_info info{};
  info.struct_size = sizeof info;
  for (const vesper_library_id id : libraries_) {
    for (uint32_t i = 0; vesper_engine_law_info(engine_.get(), id, i, &info, nullptr) == 0; ++i) {
      ForEach(info.uses, info.use_count, [&](const vesper_property_use& use) {
        if ((use.access & VESPER_WRITE) != 0) written.insert(use.name);
      });
    }
  }
  columns_.SetWritable(std::move(written));
}

void Service::Advance(Reader& request, Writer& reply) {
  const auto dt = request.Value<double>();
  const auto steps = request.Value<uint32_t>();
  apart::Sandbox::BeginFrame(std::chrono::nanoseconds(request.Value<int64_t>()));
  Check(vesper_engine_advance(engine_.get(), dt, steps, &error_));
  SaveState(reply);
  vesper_law_info info{};
  info.struct_size = sizeof info;
  for (const vesper_library_id id : libraries_) {
    for (uint32_t i = 0; vesper_engine_law_info(engine_.get(), id, i, &info, nullptr) == 0; ++i) {
      reply.Value(info.calls);
      reply.Value(info.nanoseconds);
      reply.Value(info.resting);
    }
  }
}

void Service::MoveRows(Reader& request) {
  const std::string kind = request.Text();
  const auto count = request.Value<uint32_t>();
  for (uint32_t i = 0; i < count; ++i) {
    const auto from = request.Value<uint64_t>();
    const auto to = request.Value<uint64_t>();
    Check(vesper_engine_move_row(engine_.get(), kind.c_str(), from, to, &error_));
  }
}

/// Writes the state to the client's memory. Replies with the step count, the size of the state, and
/// 1 if the state was written or 0 if the memory is too small.
void Service::SaveState(Writer& reply) {
  const auto save = [&] {
    return state_size_ <= state_.size()
               ? vesper_engine_save_state(engine_.get(), state_.data(), state_size_, nullptr)
               : VESPER_INVALID_ARGUMENT;
  };
  // The first attempt uses the size of the last state, because the size changes only with laws and
  // rows.
  vesper_status saved = state_size_ == 0 ? VESPER_INVALID_ARGUMENT : save();
  if (saved != VESPER_OK) {
    Check(vesper_engine_state_size(engine_.get(), &state_size_, &error_));
    saved = save();
  }
  reply.Value(vesper_engine_step_count(engine_.get()));
  reply.Value(state_size_);
  reply.Value(uint32_t{saved == VESPER_OK});
}

void Service::LoadState(Reader& request) {
  auto size = request.Value<uint64_t>();
  if (size > state_.size()) throw std::runtime_error("a saved state is cut");
  for (auto left = request.Value<uint32_t>(); left > 0; --left) {
    const std::string library = request.Text();
    Check(vesper_saved_state_remove_library(state_.data(), &size, library.c_str(), &error_));
  }
  Check(vesper_engine_load_state(engine_.get(), state_.data(), size, &error_));
}

void Service::Ledger(Reader& request, Writer& reply) {
  for (auto left = request.Value<uint32_t>(); left > 0; --left) {
    const auto library = request.Value<vesper_library_id>();
    const auto line = request.Value<uint32_t>();
    vesper_ledger_entry entry{};
    entry.struct_size = sizeof entry;
    Check(vesper_engine_ledger(engine_.get(), library, line, &entry, &error_));
    reply.Value(entry);
  }
}

/// Writes one row of SCRATCH uses: the values of each use, one after the other.
void Service::ScratchRow(Reader& request, Writer& reply) {
  const auto row = request.Value<uint64_t>();
  std::vector<double> values;
  for (auto left = request.Value<uint32_t>(); left > 0; --left) {
    const auto library = request.Value<vesper_library_id>();
    const auto law = request.Value<uint32_t>();
    const auto use = request.Value<uint32_t>();
    values.resize(std::min(request.Value<uint32_t>(), kMaxScratchValues));
    Check(vesper_engine_scratch_row(engine_.get(), library, law, use, row, values.data(),
                                    static_cast<uint32_t>(values.size()), &error_));
    for (const double value : values) reply.Value(value);
  }
}

void Service::Log(void* user, uint32_t level, const char* message) {
  Control& control = static_cast<Service*>(user)->control_;
  const auto length = static_cast<uint32_t>(strnlen(message, kMaxLine));
  const size_t size = 2 * sizeof(uint32_t) + length;
  if (control.log_used > kLogSize || size > kLogSize - control.log_used) {
    ++control.log_dropped;
    return;
  }
  char* at = control.log + control.log_used;
  std::memcpy(at, &level, sizeof level);
  std::memcpy(at + sizeof level, &length, sizeof length);
  std::memcpy(at + 2 * sizeof level, message, length);
  control.log_used += static_cast<uint32_t>(size);
}

}  // namespace vesper::host
