// SPDX-License-Identifier: Apache-2.0
// The engine behind the C interface.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "columns.hpp"
#include "config.hpp"
#include "custom_provider.hpp"
#include "law_library.hpp"
#include "ledger.hpp"
#include "prototype.hpp"
#include "saved_state.hpp"
#include "schedule.hpp"
#include "step_clock.hpp"
#include "thread_pool.hpp"

struct vesper_provider {
  vesper_engine& engine;
};

/// Implementation of engine.h. Each member function implements one C function. It throws
/// `vesper::Failure` if the C function returns an error. Every member function except the getters
/// throws BUSY while another member function runs.
struct vesper_engine {
 public:
  vesper_engine(const vesper::Config& config, const vesper_prototype& prototype);
  /// Unloads all libraries in reverse load order.
  ~vesper_engine();

  vesper_provider& provider() { return provider_; }
  bool busy() const { return busy_.load(std::memory_order_acquire); }
  uint64_t step_count() const { return clock_.steps; }
  void SetStepCount(uint64_t steps, double dt);

  void SetProvider(const vesper_provider_callbacks* callbacks);
  void AddProperty(const char* name, const vesper::Arrays& arrays);
  void RebindProperty(const char* name, const vesper::Arrays& arrays);
  void SetField(const char* name, const vesper_field& field);
  void RemoveProperty(const char* name);
  void FindProperty(const char* name, vesper_property& out);
  void Touch(const char* const* names, uint32_t count);

  const vesper::Config& config() const { return config_; }
  vesper_library_id Load(vesper_prepared_library& prepared, const vesper_parameter* parameters,
                         uint32_t count);
  void Unload(vesper_library_id id);
  void Replace(vesper_library_id id, vesper_prepared_library& prepared,
               const vesper_parameter* parameters, uint32_t count);
  void BeginChanges();
  void EndChanges(bool keep);
  void SetInterval(vesper_library_id id, uint32_t interval);
  void LawInfo(vesper_library_id id, uint32_t index, vesper_law_info& out) const;
  void ScratchRow(vesper_library_id id, uint32_t index, uint32_t use, uint64_t row,
                  std::span<double> out) const;

  void Advance(double dt, uint32_t steps);
  void Synchronize(const char* const* names, uint32_t count);
  void ClearFault();
  void MoveRow(const char* kind, uint64_t from, uint64_t to);
  uint64_t StateHash();
  void SetLedger(bool on);
  void LedgerEntry(vesper_library_id id, uint32_t line, vesper_ledger_entry& out);
  double PotentialEnergy(vesper_library_id id, uint32_t index);
  std::vector<std::byte> SaveState();
  void LoadState(std::span<const std::byte> saved);

 private:
  class Turn;
  struct Changes;

  std::vector<std::unique_ptr<vesper::LawLibrary>>::const_iterator FindLibrary(
      vesper_library_id id) const;
  /// Runs `body`; if it fails, arrays are undefined and the engine is FAULTED.
  template <class Body>
  void FaultIfFails(Body&& body);
  /// Marks the engine as FAULTED and discards deferred values; the client must restore its arrays.
  void Fault(vesper_library_id library);
  void RefuseIfFaulted() const;
  /// Returns the named properties, or all bound ones if `names` is null.
  std::vector<uint32_t> BoundProperties(const char* const* names, uint32_t count) const;
  void MatchFields(const vesper_law_library& table, vesper::LawLibrary& added) const;
  const vesper::LawLibrary* FieldOwner(uint32_t property) const;
  void RequireSlopes(const vesper::LawLibrary& added) const;
  void RefuseIfSlopeIsRead(uint32_t property, const std::string& provider) const;
  void RefuseFieldOfLibrary(uint32_t property) const;
  const vesper::LoadedLaw& FindLaw(vesper_library_id id, uint32_t index) const;
  void RefuseLoadedName(const char* name) const;
  /// Creates the laws of a library and checks that they are compatible with all loaded laws.
  std::unique_ptr<vesper::LawLibrary> Build(vesper_library_id id, const vesper_law_library& table,
                                            const vesper_parameter* parameters, uint32_t count);
  /// Removes the library at a place in the load order, and unbinds its fields. The caller must call
  /// Plan afterwards.
  std::unique_ptr<vesper::LawLibrary> TakeOut(size_t place);
  /// Inserts a library at a place in the load order, and binds its fields. The caller must call
  /// Plan afterwards.
  void PutIn(size_t place, std::unique_ptr<vesper::LawLibrary> library);
  /// Keeps a removed library if a series of changes is in progress at whose begin it was loaded.
  void SetAside(std::unique_ptr<vesper::LawLibrary> removed);
  /// Updates all parts that depend on the set of laws.
  void Plan();
  /// Restores the state of the engine at BeginChanges.
  void Undo(Changes& changes);
  /// Passes the current columns to all laws. Throws FAULTED if SCRATCH or deferred values are
  /// undefined.
  void Bind();
  /// Binds as Bind does, then synchronizes all deferred arrays and binds the laws to the result.
  void BindFresh();
  void MatchLaws(const vesper_law_library& table, vesper::LawLibrary& added);
  void CheckConflicts(const vesper::LawLibrary& added) const;
  vesper::EngineState State() const;
  void RefreshColumns();
  uint32_t RequireRegistered(const char* name) const;
  void CheckArraysFit(uint32_t property, const vesper::Arrays& arrays) const;
  template <class Condition>
  void RefuseIfUsed(uint32_t property, const char* refusal, Condition&& condition) const;

  vesper::Config config_;
  vesper::Prototype prototype_;
  vesper::Columns columns_{prototype_};
  std::unique_ptr<vesper::CustomProvider> custom_;  // null: the client registers arrays
  vesper::ThreadPool pool_;
  std::vector<std::unique_ptr<vesper::LawLibrary>> libraries_;  // libraries in load order
  std::unique_ptr<Changes> changes_;                            // null: none are in progress
  vesper::Schedule schedule_{columns_, pool_, config_.rest_without_fields};
  std::unique_ptr<vesper::Ledger> ledger_;  // null: the ledger is off
  vesper_provider provider_{*this};
  mutable std::atomic<bool> busy_ = false;
  bool faulted_ = false;
  vesper_library_id faulted_library_ = VESPER_NO_LIBRARY;
  vesper_library_id next_library_ = 1;
  vesper::StepClock clock_;
};
