// SPDX-License-Identifier: Apache-2.0
// The requests that a host answers: the functions of engine.h, one request each.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "columns.hpp"
#include "control.hpp"
#include "law_apart.hpp"
#include "message.hpp"
#include "vesper/engine.h"

namespace vesper::host {

/// Numbers of requests. The enum reve.pe.hosted.Request in Java has the same numbers.
enum class Request : uint32_t {
  kCreate = 1,
  kAdd,
  kRebind,
  kRemove,
  kFind,
  kTouch,
  kPrepare,
  kLoad,
  kUnload,
  kLaws,
  kAdvance,
  kClearFault,
  kMoveRows,
  kSetStepCount,
  kStateHash,
  kStateMemory,
  kSaveState,
  kLoadState,
  kSetLedger,
  kLedger,
  kBindAll,
  kSetInterval,
  kBeginChanges,
  kEndChanges,
  kReplace,
  kScratchRow,
};

/// The form of the bytes of a law library. The class reve.pe.hosted.HostedLibrary in Java has the
/// same numbers.
/// kApart: native code that runs in a sandbox and is refused if this machine lacks a layer of the
/// sandbox. kApartWeakly: native code that runs in a sandbox even if this machine lacks a layer.
enum class Form : uint32_t { kNative, kText, kPython, kApart, kApartWeakly };

class ReceivedPrototype;

/// One engine and its answers to requests. A reply begins with a status (int32_t). After a failure,
/// the `vesper_error` follows; after success, the result of the request.
class Service {
 public:
  /// `memory_limit` also limits the private memory of each sandbox [bytes]; 0: no limit.
  Service(int client, Control& control, uint64_t memory_limit);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  /// Answers the request in the mailbox.
  void Answer();
  /// Writes to the shared memory which property is at the address at which this process crashes.
  void NoteFault(const void* address);

 private:
  struct EngineDeleter {
    void operator()(vesper_engine* engine) const { vesper_engine_destroy(engine); }
  };

  void Dispatch(Reader request, Writer& reply);
  void Create(Reader& request);
  void Bind(Reader& request, bool rebind);
  void Remove(Reader& request);
  void Find(Reader& request, Writer& reply);
  void Touch(Reader& request);
  void Prepare(Reader& request, Writer& reply);
  void Load(Reader& request, Writer& reply);
  void Unload(Reader& request, Writer& reply);
  void Laws(Reader& request, Writer& reply);
  void Advance(Reader& request, Writer& reply);
  void Replace(Reader& request, Writer& reply);
  void BeginChanges();
  void EndChanges(Reader& request, Writer& reply);
  void MoveRows(Reader& request);
  void SaveState(Writer& reply);
  void LoadState(Reader& request);
  void Ledger(Reader& request, Writer& reply);
  void ScratchRow(Reader& request, Writer& reply);

  apart::Options SandboxOptions(bool incomplete) const;
  vesper_prepared_library* Open(Reader& request, std::string* versions = nullptr);
  void WriteLaws(vesper_library_id library, Writer& reply);
  void ProtectColumns();
  vesper_provider* provider() { return vesper_engine_property_provider(engine_.get()); }
  static void Log(void* user, uint32_t level, const char* message);

  int client_;
  Control& control_;
  uint64_t memory_limit_;
  std::vector<std::byte> request_;  // a copy, because the reply overwrites the mailbox
  Columns columns_;                 // declared before the engine, which it must outlive
  std::vector<std::string> accumulators_;
  vesper_engine_config config_{};
  std::unique_ptr<ReceivedPrototype> prototype_;
  std::unique_ptr<vesper_engine, EngineDeleter> engine_;
  std::vector<vesper_library_id> libraries_;  // libraries in the order of loading
  std::vector<vesper_library_id> before_;     // libraries before the changes in progress
  Mapping state_;                             // memory of the client, to which states are saved
  uint64_t state_size_ = 0;                   // size of the last saved state [bytes]
  vesper_error error_{};
};

}  // namespace vesper::host
