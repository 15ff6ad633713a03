// SPDX-License-Identifier: Apache-2.0
// Newton's gravitation of all pairs, on an OpenCL device.
#pragma once

#include <vector>

#include "suite.hpp"
#include "vesper/law.hpp"

namespace vesper::opencl {

/** F[i] = G m[i] sum over j of m[j] d / (|d|^2 + softening^2)^(3/2), with d = x[j] - x[i]. */
template <class Real>
struct OpenClGravitation {
  static constexpr auto kName = "opencl_gravitation", kVersion = "1.0.0";
  static constexpr auto kDoc =
      "Newton's gravitation between all pairs of bodies, on an OpenCL device.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kTranslation | kRotation;
  using Suite = opencl::Suite;

  Parameter fast{"fast",
                 "1: the device's own reciprocal square root; 0: square root and division as its "
                 "OpenCL rounds them.",
                 units::one,
                 0,
                 0,
                 1};
  Read<Real> constant{"gravitationalConstant", "world", units::gravitational_constant};
  OptionalRead<Real> softening{"softening", "world", units::metre};
  DeferredRead<Real> mass{"mass", "body", units::kilogram};
  DeferredRead<Vec3<Real>> position{"position", "body", units::metre};
  DeferredAccumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Parameters() { return std::tie(fast); }
  auto Properties() { return std::tie(constant, softening, mass, position, force); }

  void Join(Suite& suite) {
    suite_ = &suite;
    forces_ = suite.Compile<Real>("gravitation", fast.value() != 0);
    potentials_ = suite.Compile<Real>("potential");
  }
  void Bind() {
    suite_->mass.Take(mass);
    suite_->position.Take(position);
  }
  void Advance(const Step&) {
    suite_->device.Finish();  // so that the host is at most one step ahead of the device
    suite_->force.Overwrite(force);
    const uint32_t width = suite_->Width<Real>();
    (*forces_)((position.size() + width - 1) / width, suite_->position.buffer(),
               suite_->mass.buffer(), suite_->force.buffer(), Count(), Constant(), Softening());
  }
  void Synchronize(const DeferredAccumulate<Vec3<Real>>& column) { suite_->force.Give(column); }

  /** Returns minus half the sum of G m[i] m[j] / sqrt(|d|^2 + softening^2) over the bodies. */
  double PotentialEnergy() {
    Buffer energies(suite_->device);
    energies.Reserve(position.size() * sizeof(Real));
    (*potentials_)(position.size(), suite_->position.buffer(), suite_->mass.buffer(), energies,
                   Count(), Constant(), Softening());
    std::vector<Real> of_bodies(position.size());
    energies.Download(of_bodies.data(), of_bodies.size() * sizeof(Real));
    double sum = 0;
    for (const Real energy : of_bodies) sum += double{energy};
    return sum;
  }

 private:
  cl_uint Count() const { return static_cast<cl_uint>(position.size()); }
  /** Returns the gravitational constant; 0 if the kind `world` has no row. */
  Real Constant() const { return constant.size() == 0 ? 0 : constant[0]; }
  Real Softening() const { return softening.size() == 0 ? 0 : softening[0]; }

  Suite* suite_ = nullptr;
  std::unique_ptr<Kernel> forces_, potentials_;
};

}  // namespace vesper::opencl
