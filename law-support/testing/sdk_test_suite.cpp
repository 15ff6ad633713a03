// SPDX-License-Identifier: Apache-2.0
// Two laws that use every part of law.hpp and can throw in each function.
#include <stdexcept>
#include <string>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

/** Counter of the laws that joined the suite. */
struct Members {
  int count = 0;
};

/** Pushes every body along x with `push` plus its charge times `chargePush`. */
template <class Real>
struct Pusher {
  static constexpr auto kName = "pusher", kVersion = "1.2.3", kDoc = "Pushes.";
  static constexpr auto kPhase = Phase::kForce;
  using Suite = Members;

  Parameter push{"push", "Force.", units::newton, 2, -100, 100};
  Parameter charge_push{
      "chargePush", "Force per coulomb.", {{1, 1, -3, -1, 0, 0, 0}, 0, 1, "N/C"}, 0.5, 0, 1};
  /** Function that throws: 0 none, 1 Bind, 2 Advance, 3 ParallelFor, 4 Advance (not a
   *  std::exception), 5 Join. */
  Parameter throw_in{"throwIn", "Where to throw.", units::one, 0, 0, 5};

  OptionalRead<Real> charge{"charge", "body", units::coulomb};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Parameters() { return std::tie(push, charge_push, throw_in); }
  auto Properties() { return std::tie(charge, force); }

  void Join(Members& members) {
    if (throw_in.value() == 5) throw std::runtime_error("thrown by Join");
    ++members.count;
  }

  void Bind() {
    if (throw_in.value() == 1) throw std::runtime_error("thrown by Bind");
  }

  void Advance(const Step& step) {
    if (throw_in.value() == 2) throw std::runtime_error("thrown by Advance");
    if (throw_in.value() == 4) throw 4;
    step.ParallelFor(force.size(), 10, [&](uint64_t begin, uint64_t end) {
      if (throw_in.value() == 3 && begin >= 20) {
        throw std::runtime_error("thrown from row " + std::to_string(begin));
      }
      for (uint64_t i = begin; i < end; ++i) {
        force[i].x += Real(push);
        if (charge.present()) force[i].x += Real(charge_push) * charge[i];
      }
    });
  }
};

/** Logs the step and copies the force to the acceleration. */
template <class Real>
struct Reporter {
  static constexpr auto kName = "reporter", kVersion = "1.0.0", kDoc = "Reports.";
  static constexpr auto kPhase = Phase::kObserve;
  using Suite = Members;

  Read<Vec3<Real>> force{"externalForce", "body", units::newton};
  Write<Vec3<Real>> acceleration{"acceleration", "body", units::metre_per_second_squared};

  auto Properties() { return std::tie(force, acceleration); }

  void Join(Members& members) {
    members_ = &members;
    ++members.count;
  }

  void Advance(const Step& step) {
    if (step.index == 1) {
      step.Log(VESPER_LOG_INFO, ("second step begins at " + std::to_string(step.time) + ", " +
                                 std::to_string(members_->count) + " laws in the suite")
                                    .c_str());
    }
    for (uint64_t i = 0; i < force.size(); ++i) acceleration[i] = force[i];
  }

 private:
  const Members* members_ = nullptr;
};

}  // namespace

VESPER_LAW_LIBRARY("sdk_test_suite", Pusher, Reporter)
