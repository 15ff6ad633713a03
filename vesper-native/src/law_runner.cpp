// SPDX-License-Identifier: Apache-2.0
#include "law_runner.hpp"

#include <algorithm>
#include <atomic>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>

#include "column_passes.hpp"
#include "failure.hpp"
#include "guarded_copy.hpp"
#include "kernels.hpp"
#include "unit.hpp"

namespace vesper {
namespace {

uint64_t ValueCount(const vesper_property& property) {
  return property.row_count * property.components;
}

size_t ByteSize(const vesper_property& property) {
  return ValueCount(property) * ScalarSize(property.scalar_type);
}

void Zero(ThreadPool& pool, const vesper_property& property) {
  Zero(pool, property.scalar_type, property.data, ValueCount(property));
}

uint64_t FindNonFinite(ThreadPool& pool, const vesper_property& property) {
  return FindNonFinite(pool, property.scalar_type, property.data, ValueCount(property));
}

/// Returns the index of the first value that is not finite or, if `limited`, immense; or kNotFound.
uint64_t FindWrong(ThreadPool& pool, const vesper_property& property, bool limited) {
  return limited ? FindImmense(pool, property.scalar_type, property.data, ValueCount(property))
                 : FindNonFinite(pool, property);
}

/// Returns true if the rows in [begin, end) contain no value that FindWrong finds. Ignores rows
/// past the last row.
bool IsRight(const vesper_property& property, bool limited, uint64_t begin, uint64_t end) {
  end = std::min(end, property.row_count);
  if (begin >= end) return true;
  const uint64_t first = begin * property.components;
  const auto* bytes = static_cast<const std::byte*>(property.data);
  const auto* values = bytes + first * ScalarSize(property.scalar_type);
  const uint64_t count = end * property.components - first;
  return (limited ? FindImmense(property.scalar_type, values, count)
                  : vesper::FindNonFinite(property.scalar_type, values, count)) == kNotFound;
}

/// Copies a column. An empty column is skipped, because memcpy and memcmp must not receive its null
/// pointer.
void Copy(const vesper_property& to, const vesper_property& from) {
  if (to.row_count > 0) std::memcpy(to.data, from.data, ByteSize(to));
}

std::string PrintValue(const vesper_property& property, uint64_t index) {
  const double value = ValueAt(property.scalar_type, property.data, index);
  if (std::isnan(value)) return "nan";  // the sign of a NaN has no meaning
  if (std::isinf(value) || std::abs(value) < 1e100) return std::to_string(value);
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

Failure Misbehaved(const Law& law, const vesper_property& property, uint64_t row,
                   const std::string& what) {
  return Failure(VESPER_LAW_MISBEHAVED, "%s: property %s, row %" PRIu64 ": %s", law.label().c_str(),
                 property.name, row, what.c_str())
      .Property(property.name)
      .Row(row);
}

void CheckColumn(const Law& law, ThreadPool& pool, const vesper_property& property, bool limited) {
  const uint64_t bad = FindWrong(pool, property, limited);
  if (bad == kNotFound) return;
  const double value = ValueAt(property.scalar_type, property.data, bad);
  const uint64_t component = bad % property.components;
  const bool unwritten = IsUnwritten(property.scalar_type, property.data, bad);
  throw Misbehaved(law, property, bad / property.components,
                   unwritten && property.access == VESPER_WRITE
                       ? "declared WRITE, but the row was not written"
                   : unwritten ? "the row was not written"
                               : "wrote " + PrintValue(property, bad) +
                                     (std::isfinite(value) ? ", more than 1.7e100," : "") +
                                     " to component " + std::to_string(component));
}

/// Returns true if the law writes the array of the use within `advance`.
bool IsWritten(const Law& law, const Targets& targets, size_t use) {
  return targets[use].access != VESPER_READ && !law.Defers(use);
}

/// Throws an exception if a property that the law only reads contains NaN or infinity. The client
/// must have written such a value, because the engine checks the values of each law before the next
/// law runs.
void CheckInputs(const Law& law, ThreadPool& pool, const Targets& seen) {
  for (const vesper_property& property : seen) {
    if (property.access != VESPER_READ || IsField(property.scalar_type)) continue;
    const uint64_t bad = FindNonFinite(pool, property);
    if (bad == kNotFound) continue;
    const uint64_t row = bad / property.components;
    throw Failure(VESPER_INVALID_ARGUMENT,
                  "property %s, row %" PRIu64 ": is %s, which %s reads; give it a finite value",
                  property.name, row, PrintValue(property, bad).c_str(), law.label().c_str())
        .Property(property.name)
        .Row(row);
  }
}

/// Returns true if the columns that the law wrote contain no value that FindWrong finds. Scans all
/// these columns in one pass, because each pass synchronizes the threads.
bool WroteRight(const Law& law, ThreadPool& pool, const Targets& seen, bool limited) {
  uint64_t rows = 0, values = 0;
  for (size_t i = 0; i < seen.size(); ++i) {
    if (!IsWritten(law, seen, i)) continue;
    rows = std::max(rows, seen[i].row_count);
    values += ValueCount(seen[i]);
  }
  if (values == 0) return true;
  std::atomic<bool> right = true;
  auto look = [&](uint64_t begin, uint64_t end) {
    for (size_t i = 0; i < seen.size(); ++i) {
      if (IsWritten(law, seen, i) && !IsRight(seen[i], limited, begin, end)) right = false;
    }
  };
  const Sharing sharing = ShareOut(values);
  pool.ParallelFor(rows, sharing.grain * rows / values + 1, look, sharing.helpers);
  return right;
}

/// Throws an exception if a value that the law wrote is not finite or, if `limited`, immense.
/// Checks the law's inputs first, because they may be the cause.
void CheckWritten(const Law& law, ThreadPool& pool, const Targets& seen, bool limited) {
  if (WroteRight(law, pool, seen, limited)) return;
  CheckInputs(law, pool, seen);
  for (size_t i = 0; i < seen.size(); ++i) {
    if (IsWritten(law, seen, i)) CheckColumn(law, pool, seen[i], limited);
  }
}

class DirectRunner final : public LawRunner {
 public:
  DirectRunner(Law& law, ThreadPool& pool, bool limited)
      : law_(law), pool_(pool), limited_(limited) {}

  void Bind(const Targets& targets) override {
    targets_ = &targets;
    law_.Bind(targets);
  }

  void Advance(const vesper_step& step) override {
    for (size_t i = 0; i < targets_->size(); ++i) {
      const vesper_property& target = (*targets_)[i];
      if (target.access == VESPER_ACCUMULATE && !law_.Defers(i)) Zero(pool_, target);
    }
    law_.Advance(step);
    CheckWritten(law_, pool_, *targets_, limited_);
  }

  void Synchronize(uint32_t use) override {
    law_.Synchronize(use);
    CheckColumn(law_, pool_, (*targets_)[use], limited_);
  }

  double PotentialEnergy() override { return law_.PotentialEnergy(); }

 private:
  Law& law_;
  ThreadPool& pool_;
  bool limited_;
  const Targets* targets_ = nullptr;
};

class GuardedRunner final : public LawRunner {
 public:
  GuardedRunner(Law& law, ThreadPool& pool, bool limited)
      : law_(law), pool_(pool), limited_(limited) {}

  void Bind(const Targets& targets) override {
    targets_ = &targets;
    seen_ = targets;
    copies_.resize(targets.size());
    for (size_t i = 0; i < targets.size(); ++i) {
      if (targets[i].data == nullptr || IsField(targets[i].scalar_type)) continue;
      copies_[i].Resize(ByteSize(targets[i]));
      seen_[i].data = copies_[i].data();
    }
    CopyIn();
    law_.Bind(seen_);
    CheckKeptWord();
  }

  void Advance(const vesper_step& step) override {
    CopyIn();
    law_.Advance(step);
    CheckKeptWord();
    CheckWritten(law_, pool_, seen_, limited_);
    for (size_t i = 0; i < seen_.size(); ++i) {
      if (IsWritten(law_, seen_, i)) Copy((*targets_)[i], seen_[i]);
    }
  }

  void Synchronize(uint32_t use) override {
    CopyIn();
    const vesper_property& seen = seen_[use];
    FillUnwritten(seen.scalar_type, seen.data, ValueCount(seen));
    law_.Synchronize(use);
    CheckKeptWord(use);
    CheckColumn(law_, pool_, seen, limited_);
    Copy((*targets_)[use], seen);
  }

  double PotentialEnergy() override {
    CopyIn();
    const double energy = law_.PotentialEnergy();
    CheckKeptWord();
    return energy;
  }

 private:
  void CopyIn() {
    for (size_t i = 0; i < seen_.size(); ++i) {
      if (seen_[i].access == VESPER_ACCUMULATE && !law_.Defers(i)) {
        Zero(pool_, seen_[i]);
      } else {
        Copy(seen_[i], (*targets_)[i]);
      }
      if (seen_[i].access == VESPER_WRITE && !law_.Defers(i)) {
        FillUnwritten(seen_[i].scalar_type, seen_[i].data, ValueCount(seen_[i]));
      }
    }
  }

  /// Throws an exception if the law wrote outside of its arrays, or to an array that it declared
  /// READ or DEFERRED. The law may write to the array of the use `synchronized`.
  void CheckKeptWord(size_t synchronized = SIZE_MAX) const {
    for (size_t i = 0; i < seen_.size(); ++i) {
      const vesper_property& seen = seen_[i];
      if (seen.data == nullptr || IsField(seen.scalar_type)) continue;
      if (!copies_[i].FrontIntact()) throw Misbehaved(law_, seen, 0, "wrote before the first row");
      if (!copies_[i].BackIntact()) {
        throw Misbehaved(law_, seen, seen.row_count, "wrote past the last row");
      }
      if (seen.access == VESPER_READ) CheckUnchanged(i, "READ");
      if (seen.access != VESPER_READ && law_.Defers(i) && i != synchronized) {
        CheckUnchanged(i, "DEFERRED");
      }
    }
  }

  void CheckUnchanged(size_t i, const char* declared) const {
    const vesper_property& seen = seen_[i];
    const vesper_property& target = (*targets_)[i];
    if (seen.row_count == 0 || std::memcmp(seen.data, target.data, ByteSize(seen)) == 0) return;
    const size_t row_size = ByteSize(seen) / seen.row_count;
    const auto* found = static_cast<const std::byte*>(seen.data);
    const auto* expected = static_cast<const std::byte*>(target.data);
    uint64_t row = 0;
    while (std::memcmp(found + row * row_size, expected + row * row_size, row_size) == 0) ++row;
    throw Misbehaved(law_, seen, row,
                     "declared " + std::string(declared) + ", but the row was changed");
  }

  Law& law_;
  ThreadPool& pool_;
  bool limited_;
  const Targets* targets_ = nullptr;
  Targets seen_;
  std::vector<GuardedCopy> copies_;
};

}  // namespace

std::unique_ptr<LawRunner> MakeRunner(Law& law, ThreadPool& pool, const Config& config) {
  if (config.validate) return std::make_unique<GuardedRunner>(law, pool, config.limit_values);
  return std::make_unique<DirectRunner>(law, pool, config.limit_values);
}

}  // namespace vesper
