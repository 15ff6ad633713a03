// SPDX-License-Identifier: Apache-2.0
// Laws that each break one promise; FAULT says which.
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cfenv>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

enum Fault {
  kNone,
  kBehind,
  kBefore,
  kWritesRead,
  kThreads,
  kNotANumber,
  kMomentum,
  kAngularMomentum,
  kTranslation_,
  kRotation_,
  kEnergy,
  kCrash,
  kLeak,
  kExit,
  kRepeat,
  kRollback,
  kMassZero,
  kOutput,
  kCoincident,
  kRounding,
  kGrows,
  kImpulse,
  kMisspelt,
  kEnergyStep,
  kNoEnergy
};
constexpr Fault kFault = FAULT;

using Clock = std::chrono::steady_clock;

std::atomic<int> order;

/** Pulls every body to the origin, and breaks one promise in addition. */
template <class Real>
struct Broken {
  static constexpr auto kName = "broken", kVersion = "1.0.0";
  static constexpr auto kDoc = "Breaks one promise.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kFault == kMomentum          ? VESPER_CLAIM_MOMENTUM
                                      : kFault == kAngularMomentum ? VESPER_CLAIM_ANGULAR_MOMENTUM
                                      : kFault == kTranslation_    ? VESPER_CLAIM_TRANSLATION
                                      : kFault == kRotation_       ? VESPER_CLAIM_ROTATION
                                      : kFault >= kEnergyStep      ? VESPER_CLAIM_ENERGY
                                                                   : 0;

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  OptionalRead<Real> charge{kFault == kMisspelt ? "charg" : "charge", "body", units::coulomb};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Properties() { return std::tie(mass, position, charge, force); }

  void Advance(const Step& step) {
    if (kFault == kCrash) std::abort();
    if (kFault == kExit) _exit(7);
    if (kFault == kOutput) std::fputs("a line\n", stderr);
    if (kFault == kRepeat)
      sum_ = static_cast<Real>(Clock::now().time_since_epoch().count() % (1 << 20));
    if (kFault == kRollback) sum_ += 1;
    if (kFault == kRounding) std::fesetround(FE_UPWARD);
    if (kFault == kGrows) grows_ = new int[4];
    dt_ = static_cast<Real>(step.dt);
    if (kFault == kLeak) open("/dev/null", O_RDONLY);
    if (kFault == kWritesRead && mass.size() > 0) const_cast<Real&>(mass[0]) += 1;
    order = 0;
    step.ParallelFor(force.size(), 64, [&](uint64_t begin, uint64_t end) {
      const int turn = order++;
      for (int i = 0; kFault == kThreads && i < 50000; ++i) sink_ = sink_ + 1;  // let others begin
      for (uint64_t i = begin; i < end; ++i) force[i] += Pull(i, turn);
    });
    if (kFault == kBehind) sink_ = position.data()[position.size()].x;
    if (kFault == kBefore) sink_ = position.data()[-1].x;
  }

  Vec3<Real> Pull(uint64_t i, int turn) const {
    if (kFault == kThreads) return {static_cast<Real>(turn), 0, 0};
    if (kFault == kNotANumber && !(position[i].x == position[i].x)) return {};
    if (kFault == kRepeat || kFault == kRollback) return {sum_, 0, 0};
    if (kFault == kMassZero) return {1 / mass[i], 0, 0};
    if (kFault == kImpulse) return -position[i] * (mass[i] * dt_);
    if (kFault == kCoincident) return Attraction(i);
    if (kFault == kRotation_ || kFault == kMomentum) return {mass[i], 0, 0};
    if (kFault == kNoEnergy) return {-position[i].y, position[i].x, 0};
    if (kFault == kAngularMomentum) return {-position[i].y, position[i].x, 0};
    return -position[i] * mass[i];
  }

  /** Attraction by the next body, which is infinite at its place. */
  Vec3<Real> Attraction(uint64_t i) const {
    const Vec3<Real> between = position[(i + 1) % position.size()] - position[i];
    const Real square = Dot(between, between);
    return position.size() == 1 ? Vec3<Real>{} : between * (mass[i] / (square * Length(between)));
  }

  double PotentialEnergy() const {
    double energy = 0;
    for (uint64_t i = 0; i < mass.size(); ++i) {
      energy += 0.5 * double{mass[i]} * double{Dot(position[i], position[i])};
      if (kFault == kEnergyStep && Dot(position[i], position[i]) > 4) energy -= 0.01;
    }
    return kFault == kEnergy ? 2 * energy : energy;
  }

 private:
  volatile Real sink_ = 0;
  Real sum_ = 0, dt_ = 0;
  int* volatile grows_ = nullptr;
};

}  // namespace

VESPER_LAW_LIBRARY(LIBRARY_NAME, Broken)
