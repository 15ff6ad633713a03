// SPDX-License-Identifier: Apache-2.0
// Two laws that share a copy of the velocities, as laws that compute on a GPU do.
#include <vector>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

/** Velocities (rows x 3) [m/s], newer than the array after a law changed them. */
struct Velocities {
  std::vector<double> values;
  uint64_t version = 0;

  void Take(const auto& column) {
    if (version == column.version()) return;
    version = column.version();
    values.clear();
    for (const auto& v : column) values.insert(values.end(), {v.x, v.y, v.z});
  }
};

/** Adds 1 m/s along x to the copy. */
template <class Real>
struct Faster {
  static constexpr auto kName = "faster", kVersion = "1.0.0", kDoc = "Speeds up.";
  static constexpr auto kPhase = Phase::kConstrain;
  using Suite = Velocities;

  Read<Real> mass{"mass", "body", units::kilogram};
  DeferredReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};

  auto Properties() { return std::tie(mass, velocity); }

  void Join(Velocities& copy) { copy_ = &copy; }
  void Bind() { copy_->Take(velocity); }

  void Advance(const Step&) {
    for (uint64_t i = 0; i < velocity.size(); ++i) copy_->values[3 * i] += 1;
  }

  void Synchronize(auto& column) {
    const double* at = copy_->values.data();
    for (auto& v : column) {
      v = {static_cast<Real>(at[0]), static_cast<Real>(at[1]), static_cast<Real>(at[2])};
      at += 3;
    }
  }

 private:
  Velocities* copy_ = nullptr;
};

/** Writes the copy to the acceleration. */
template <class Real>
struct Witness {
  static constexpr auto kName = "witness", kVersion = "1.0.0", kDoc = "Shows the copy.";
  static constexpr auto kPhase = Phase::kObserve;
  using Suite = Velocities;

  DeferredRead<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  Write<Vec3<Real>> acceleration{"acceleration", "body", units::metre_per_second_squared};

  auto Properties() { return std::tie(velocity, acceleration); }

  void Join(Velocities& copy) { copy_ = &copy; }
  void Bind() { copy_->Take(velocity); }

  void Advance(const Step&) {
    for (uint64_t i = 0; i < acceleration.size(); ++i) {
      acceleration[i] = {static_cast<Real>(copy_->values[3 * i]), 0, 0};
    }
  }

 private:
  Velocities* copy_ = nullptr;
};

}  // namespace

VESPER_LAW_LIBRARY("sdk_test_deferred", Faster, Witness)
