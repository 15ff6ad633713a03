// SPDX-License-Identifier: Apache-2.0
// Execution of a law on its arrays: in place, or on guarded copies.
#pragma once

#include <memory>
#include <vector>

#include "config.hpp"
#include "law.hpp"
#include "thread_pool.hpp"

namespace vesper {

/// Arrays of a law's uses, in the order of the uses, in the engine's memory layout and units.
using Targets = std::vector<vesper_property>;

class LawRunner {
 public:
  virtual ~LawRunner() = default;

  /// Passes `targets` to the law; they must outlive the next Bind.
  virtual void Bind(const Targets& targets) = 0;
  /// Zeroes the arrays that the law accumulates into, and applies the law. Throws LAW_MISBEHAVED if
  /// the law wrote NaN, infinity or a value that `vesper_engine_config.limit_values` forbids.
  /// Throws INVALID_ARGUMENT if a read-only input of the law contains NaN or infinity. After a
  /// failure, the targets are undefined. A use that the law defers is neither checked nor written.
  virtual void Advance(const vesper_step& step) = 0;
  /// Makes the law write the array of a DEFERRED use. Throws LAW_MISBEHAVED if the values contain
  /// NaN or infinity.
  virtual void Synchronize(uint32_t use) = 0;
  /// Returns the law's potential energy [J] in the current state of the targets; only for a law
  /// that reports it.
  virtual double PotentialEnergy() = 0;
};

/// Returns a runner that runs the law in place or, with `config.validate`, on guarded copies, to
/// check its accesses against its declarations. `pool` zeroes and checks whole columns in parallel;
/// it must outlive the runner.
std::unique_ptr<LawRunner> MakeRunner(Law& law, ThreadPool& pool, const Config& config);

}  // namespace vesper
