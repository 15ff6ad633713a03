// SPDX-License-Identifier: Apache-2.0
// One law of a library, as an engine calls it.
#pragma once

#include <string>
#include <vector>

#include "vesper/law.h"

namespace vesper {

/// Owns the law's private data. Every call into the law goes through here; failures name it.
class Law {
 public:
  /// Calls nothing of the law yet. `desc` outlives it.
  explicit Law(const vesper_law_desc& desc);
  ~Law();
  Law(const Law&) = delete;
  Law& operator=(const Law&) = delete;

  void Create(const vesper_host& host, vesper_suite* suite, const std::vector<double>& parameters);
  void Bind(const std::vector<vesper_property>& properties);
  void Advance(const vesper_step& step);
  /// Writes the array of a use that it deferred.
  void Synchronize(uint32_t use);
  /// [J], of the arrays it is bound to; only of a law that reports it. Throws LAW_MISBEHAVED if it
  /// is not finite.
  double PotentialEnergy();

  const vesper_law_desc& desc() const { return desc_; }
  /// Whether a use is DEFERRED, by its place.
  bool Defers(size_t use) const { return deferred_[use]; }
  /// "law hooke_spring", for messages.
  const std::string& label() const { return label_; }
  uint64_t calls() const { return calls_; }
  uint64_t nanoseconds() const { return nanoseconds_; }

 private:
  /// Makes a call whose time is counted.
  template <class Call>
  void Timed(Call&& call);

  const vesper_law_desc& desc_;
  std::string label_;
  std::vector<bool> deferred_;  // by use
  vesper_law* law_ = nullptr;
  uint64_t calls_ = 0;
  uint64_t nanoseconds_ = 0;
};

}  // namespace vesper
