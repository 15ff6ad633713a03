// SPDX-License-Identifier: Apache-2.0
// The law that uploads columns to the device; the first of each OpenCL library.
#pragma once

#include "suite.hpp"
#include "vesper/law.hpp"

namespace vesper::opencl {

/** Uploads masses and positions to the OpenCL device of its suite whenever the client or another
 *  library wrote them. */
template <class Real>
struct OpenClSetup {
  static constexpr auto kName = "opencl_setup", kVersion = "1.0.0";
  static constexpr auto kDoc = "Opens an OpenCL device, and keeps masses and positions on it.";
  static constexpr auto kPhase = Phase::kForce;
  using Suite = opencl::Suite;

  DeferredRead<Real> mass{"mass", "body", units::kilogram};
  DeferredRead<Vec3<Real>> position{"position", "body", units::metre};

  auto Properties() { return std::tie(mass, position); }

  void Join(Suite& suite) { suite_ = &suite; }
  void Bind() {
    suite_->mass.Take(mass);
    suite_->position.Take(position);
  }
  /** Does nothing, because Bind has uploaded the columns that were written. */
  void Advance(const Step&) {}

 private:
  Suite* suite_ = nullptr;
};

}  // namespace vesper::opencl
