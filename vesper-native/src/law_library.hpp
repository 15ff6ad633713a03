// SPDX-License-Identifier: Apache-2.0
// A law library that belongs to an engine.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aligned_buffer.hpp"
#include "config.hpp"
#include "field.hpp"
#include "kernels.hpp"
#include "law.hpp"
#include "law_runner.hpp"
#include "prepared_library.hpp"
#include "scratch_column.hpp"
#include "thread_pool.hpp"
#include "watched_field.hpp"

namespace vesper {

/// A use of a law, and the property of the prototype that it is matched with.
struct MatchedUse {
  bool IsScratch() const { return use->access == VESPER_SCRATCH; }

  uint32_t property;  // kNone for scratch, and for an optional property that the prototype lacks
  const vesper_property_use* use;
  AlignedBuffer share{};  // the law's accumulated values, where they are separate from the total
  UnitRatio to_law{};     // conversion from the property's unit to the law's unit
  uint32_t scratch_kind = 0;
  ScratchColumn scratch{};
  std::optional<double> minimum = {};        // minimum of the property, if the law writes it
  std::unique_ptr<WatchedField> field = {};  // of a FIELD property that is bound
};

/// A field of a library, and the property of the prototype that it is matched with.
struct LoadedField {
  uint32_t property;
  const vesper_field_desc* desc;
  UnitRatio from_library;  // from the library's unit to the property's
                           // unit
  FieldProvider provider = {};
  std::unique_ptr<ConvertedField> function = nullptr;  // created with the suite
  std::unique_ptr<ConvertedField> slopes = nullptr;    // null: the slopes are unknown
};

class LawLibrary;

/// Thrown if a law failed because of a field; `failure` names the library that provides the field.
struct FieldFailure {
  Failure failure;
};

/// A law with all data that the engine keeps for it.
struct LoadedLaw {
  LoadedLaw(const vesper_law_desc& desc, vesper_library_id library, uint32_t law_index,
            std::vector<MatchedUse> matched, ThreadPool& pool, const Config& config);

  bool Writes(uint32_t property) const;
  /// Returns true if one of its uses is DEFERRED.
  bool Defers() const;
  /// Runs the law on its targets. While the law rests, and in steps in which its interval skips the
  /// law, zeroes its contributions instead. Throws FieldFailure if a field is the cause of a
  /// failure.
  void Run(const vesper_step& step);
  /// Returns the potential energy [J] of the bound arrays; 0 while the law rests.
  double PotentialEnergy() const { return resting ? 0 : runner->PotentialEnergy(); }
  /// Returns the magnitude [unit of the property] from which the law cannot use a value of a field.
  double LimitOfFields() const { return limit_of_fields_; }
  /// Throws ACCESS_CONFLICT if the law cannot have an interval other than 1.
  void RequireInterval(const LawLibrary& library, uint32_t wanted) const;

  Law law;
  uint32_t index;  // index within its library, counting only laws in the engine's precision
  std::vector<MatchedUse> uses;
  std::unique_ptr<LawRunner> runner;
  Targets targets;        // arrays to which the law is bound; empty before the first bind
  uint32_t interval = 1;  // see vesper_engine_set_interval
  bool resting = false;   // a field that it reads is not bound; see vesper_engine_config

 private:
  void RunDue(const vesper_step& step);
  /// Throws FieldFailure if a field gave a wrong value in a call of the law that failed.
  void BlameFields(const Failure& failure) const;
  void AddNothing();
  void MultiplyAdded();
  /// Throws LAW_MISBEHAVED if a property that the law writes is below its minimum.
  void CheckMinima() const;

  double limit_of_fields_;
};

/// The laws of a library, their shared state and the mapped file; destroyed in this order.
class LawLibrary {
 public:
  LawLibrary(vesper_library_id id, std::string name, const Config& config, ThreadPool& pool);
  ~LawLibrary();
  LawLibrary(const LawLibrary&) = delete;
  LawLibrary& operator=(const LawLibrary&) = delete;

  /// Creates the suite and the laws, with one list of parameters for each law.
  void Create(const vesper_law_library& table, const std::vector<std::vector<double>>& parameters);
  /// Takes ownership of `prepared`; the mapped file is closed when this object is destroyed.
  void Take(vesper_prepared_library* prepared) { prepared_.reset(prepared); }

  /// Takes over the SCRATCH values of `old`, the library that this library replaces, for uses with
  /// the same layout. The SCRATCH values of `old` are undefined afterwards.
  void TakeScratch(LawLibrary& old) noexcept;

  /// Makes the library keep the log lines of its laws from now on. Later they are passed to the log
  /// or dropped.
  void HoldLog() { hold_log_ = true; }
  /// Writes a line to the engine's log.
  void Log(uint32_t level, const std::string& line) const { config_.Log(level, line.c_str()); }
  void ReleaseLog();
  void DropLog();

  vesper_library_id id() const { return id_; }
  const std::string& name() const { return name_; }
  std::vector<std::unique_ptr<LoadedLaw>>& laws() { return laws_; }
  const std::vector<std::unique_ptr<LoadedLaw>>& laws() const { return laws_; }
  std::vector<std::unique_ptr<LoadedField>>& fields() { return fields_; }
  const std::vector<std::unique_ptr<LoadedField>>& fields() const { return fields_; }

 private:
  static void HostLog(void* context, uint32_t level, const char* message);
  static void HostParallelFor(void* context, uint64_t count, uint64_t grain, RangeBody body,
                              void* user);
  void Hold(uint32_t level, const char* line) noexcept;

  vesper_library_id id_;
  std::string name_;
  const Config& config_;
  ThreadPool& pool_;
  vesper_host host_;
  std::unique_ptr<vesper_prepared_library> prepared_;
  vesper_suite* suite_ = nullptr;
  void (*close_)(vesper_suite*) = nullptr;
  std::vector<std::unique_ptr<LoadedField>> fields_;
  std::vector<std::unique_ptr<LoadedLaw>> laws_;
  bool hold_log_ = false;
  std::string held_log_;  // lines: one byte for the level, the text, and a zero
};

}  // namespace vesper
