// SPDX-License-Identifier: Apache-2.0
// One law of a library, as an engine calls it.
#pragma once

#include <string>
#include <vector>

#include "running.hpp"
#include "vesper/law.h"

namespace vesper {

/// Owner of a law's private data. Every call into the law passes through this class; failures name
/// the law.
class Law {
 public:
  /// Stores `desc`, which must outlive the object. Does not call the law. During each call of the
  /// law, `running` shows observers that the law is running.
  Law(const vesper_law_desc& desc, const Running& running);
  ~Law();
  Law(const Law&) = delete;
  Law& operator=(const Law&) = delete;

  void Create(const vesper_host& host, vesper_suite* suite, const std::vector<double>& parameters);
  void Bind(const std::vector<vesper_property>& properties);
  void Advance(const vesper_step& step);
  /// Makes the law write the array of a DEFERRED use.
  void Synchronize(uint32_t use);
  /// Returns the potential energy [J] of the bound arrays; only for a law that reports it. Throws
  /// LAW_MISBEHAVED if it is not finite.
  double PotentialEnergy();

  const vesper_law_desc& desc() const { return desc_; }
  /// Returns true if the use at this index is DEFERRED.
  bool Defers(size_t use) const { return deferred_[use]; }
  /// Returns a label for messages, e.g. "law hooke_spring".
  const std::string& label() const { return label_; }
  uint64_t calls() const { return calls_; }
  uint64_t nanoseconds() const { return nanoseconds_; }

 private:
  /// Calls the law; throws if it returns an error.
  template <class Function>
  void Call(Function&& function);
  /// Makes a call and adds its time to the law's total.
  template <class Function>
  void Timed(Function&& function);

  const vesper_law_desc& desc_;
  Running running_;
  std::string label_;
  std::vector<bool> deferred_;  // whether each use is DEFERRED
  vesper_law* law_ = nullptr;
  uint64_t calls_ = 0;
  uint64_t nanoseconds_ = 0;
};

}  // namespace vesper
