// SPDX-License-Identifier: Apache-2.0
// A law written with Eigen maps: rows, whole columns, quaternions.
#include "vesper/law_eigen.hpp"

namespace {

using namespace vesper;

/** Centrifugal force about the centre of mass: F = -m w x (w x (x - c)), c = sum(m x) / sum(m). */
template <class Real>
struct Centrifugal {
  static constexpr auto kName = "centrifugal", kVersion = "1.0.0";
  static constexpr auto kDoc = "Centrifugal force about the centre of mass.";
  static constexpr auto kPhase = Phase::kForce;

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Properties() { return std::tie(mass, position, force); }

  void Advance(const Step&) {
    using Vector = Eigen::Matrix<Real, 3, 1>;
    const Vector omega(1, 2, -0.5);
    const Vector moment = (ArrayOf(position).rowwise() * ArrayOf(mass)).rowwise().sum();
    const Vector centre = moment / ArrayOf(mass).sum();
    for (uint64_t i = 0; i < force.size(); ++i) {
      const Vector r = VectorAt(position, i) - centre;
      VectorAt(force, i) -= mass[i] * omega.cross(omega.cross(r));
    }
  }
};

/** Computes the acceleration F / m of every body at once, optionally along its own axes. */
template <class Real>
struct Accelerometer {
  static constexpr auto kName = "accelerometer", kVersion = "1.0.0";
  static constexpr auto kDoc = "Acceleration of every body, in its own frame where it has one.";
  static constexpr auto kPhase = Phase::kObserve;

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> force{"externalForce", "body", units::newton};
  OptionalRead<std::array<Real, 4>> orientation{"orientation", "body", units::one};
  Write<Vec3<Real>> acceleration{"acceleration", "body", units::metre_per_second_squared};

  auto Properties() { return std::tie(mass, force, orientation, acceleration); }

  void Advance(const Step&) {
    ArrayOf(acceleration) = ArrayOf(force).rowwise() / ArrayOf(mass);
    for (uint64_t i = 0; i < orientation.size(); ++i) {
      VectorAt(acceleration, i) = QuaternionAt(orientation, i).conjugate() *
                                  Eigen::Matrix<Real, 3, 1>(VectorAt(acceleration, i));
    }
  }
};

/** Adds columns of different length, which fails an assertion of Eigen. */
template <class Real>
struct Unequal {
  static constexpr auto kName = "unequal", kVersion = "1.0.0", kDoc = "Breaks an assertion.";
  static constexpr auto kPhase = Phase::kObserve;

  Parameter act{"act", "1: add.", units::one, 0, 0, 1};
  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Real> length{"length", "spring", units::metre};

  auto Parameters() { return std::tie(act); }
  auto Properties() { return std::tie(mass, length); }

  void Advance(const Step&) {
    if (act.value() == 1) (ArrayOf(mass) + ArrayOf(length)).eval();
  }
};

}  // namespace

VESPER_LAW_LIBRARY("sdk_test_eigen", Centrifugal, Accelerometer, Unequal)
