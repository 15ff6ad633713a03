// SPDX-License-Identifier: Apache-2.0
// Pushes all bodies along x on a copy of their positions, as a law on a device does, and shows how
// often it took the column and how often it was asked to write it.
#include <algorithm>
#include <vector>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

template <class Real>
struct KeepsCopy {
  static constexpr auto kName = "keeps_copy", kVersion = "1.0.0";
  static constexpr auto kDoc = "Moves bodies by 1 m along x in each step, on a copy.";
  static constexpr auto kPhase = Phase::kConstrain;

  DeferredReadWrite<Vec3<Real>> position{"position", "body", units::metre};
  Write<Vec3<Real>> shown{"acceleration", "body", units::metre_per_second_squared};

  auto Properties() { return std::tie(position, shown); }

  void Bind() {
    if (version_ == position.version()) return;
    version_ = position.version();
    copy_.assign(position.begin(), position.end());
    ++taken_;
  }

  void Advance(const Step&) {
    for (auto& at : copy_) at.x += 1;
    for (auto& row : shown) row = {taken_, written_, 0};
  }

  void Synchronize(auto& column) {
    std::copy(copy_.begin(), copy_.end(), column.begin());
    ++written_;
  }

 private:
  std::vector<Vec3<Real>> copy_;
  uint64_t version_ = 0;
  Real taken_ = 0, written_ = 0;
};

}  // namespace

VESPER_LAW_LIBRARY("keeps_copy", KeepsCopy)
