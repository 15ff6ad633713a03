// SPDX-License-Identifier: Apache-2.0
// How an engine drives a law over its arrays: in place, or on guarded copies.
#pragma once

#include <memory>
#include <vector>

#include "law.hpp"
#include "thread_pool.hpp"

namespace vesper {

/// Arrays of a law's uses in their order, as far as the engine is concerned.
using Targets = std::vector<vesper_property>;

class LawRunner {
 public:
  virtual ~LawRunner() = default;

  /// Lets the law see `targets`, which outlive the next Bind.
  virtual void Bind(const Targets& targets) = 0;
  /// Zeroes what the law accumulates into, applies the law, and throws LAW_MISBEHAVED if it wrote
  /// NaN or infinity, or INVALID_ARGUMENT if there was one in what it only reads. What it wrote is
  /// in the targets after success only, or undefined. A use that the law defers is neither checked
  /// nor written.
  virtual void Advance(const vesper_step& step) = 0;
  /// Lets the law write the target of a use that it deferred. Throws LAW_MISBEHAVED if that is NaN
  /// or infinity.
  virtual void Synchronize(uint32_t use) = 0;
  /// The law's potential energy [J] in the present state of the targets; only of a law that
  /// reports it.
  virtual double PotentialEnergy() = 0;
};

/// In place, or, if `validate`, on copies that hold the law to its declaration. Whole columns are
/// zeroed and checked by the threads of `pool`, which outlives the runner.
std::unique_ptr<LawRunner> MakeRunner(Law& law, ThreadPool& pool, bool validate);

}  // namespace vesper
