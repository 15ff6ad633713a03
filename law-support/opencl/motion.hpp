// SPDX-License-Identifier: Apache-2.0
// Newton's second law on an OpenCL device.
#pragma once

#include "suite.hpp"
#include "vesper/law.hpp"

namespace vesper::opencl {

/** Semi-implicit Euler: v += F/m dt, then x += v dt. Mass 0 means immovable. */
template <class Real>
struct OpenClMotion {
  static constexpr auto kName = "opencl_motion", kVersion = "1.0.0";
  static constexpr auto kDoc =
      "Semi-implicit Euler for point masses, on an OpenCL device; mass 0 means immovable.";
  static constexpr auto kPhase = Phase::kIntegrate;
  using Suite = opencl::Suite;

  DeferredRead<Real> mass{"mass", "body", units::kilogram};
  DeferredRead<Vec3<Real>> force{"externalForce", "body", units::newton};
  DeferredReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  DeferredReadWrite<Vec3<Real>> position{"position", "body", units::metre};

  auto Properties() { return std::tie(mass, force, velocity, position); }

  void Join(Suite& suite) {
    suite_ = &suite;
    move_ = suite.Compile<Real>("motion");
  }
  void Bind() {
    suite_->mass.Take(mass);
    suite_->force.Take(force);
    suite_->velocity.Take(velocity);
    suite_->position.Take(position);
  }
  void Advance(const Step& step) {
    if (step.stage == 0) return;
    suite_->device.Finish();  // so that the host is at most one step ahead of the device
    (*move_)(position.size(), suite_->mass.buffer(), suite_->force.buffer(),
             suite_->velocity.buffer(), suite_->position.buffer(),
             static_cast<cl_uint>(position.size()), static_cast<Real>(step.dt));
  }
  void Synchronize(const DeferredReadWrite<Vec3<Real>>& column) {
    (&column == &position ? suite_->position : suite_->velocity).Give(column);
  }

 private:
  Suite* suite_ = nullptr;
  std::unique_ptr<Kernel> move_;
};

}  // namespace vesper::opencl
