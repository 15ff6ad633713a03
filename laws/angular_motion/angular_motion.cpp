// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "rigid/rotation.hpp"
#include "vesper/law.hpp"

namespace {

using namespace vesper;
using namespace vesper::rigid;

// Bodies per chunk of a thread; a chunk's columns fill about half a megabyte.
constexpr uint64_t kGrain = 4096;

/** Euler's equations of a rigid body. In a step, the torque first changes the angular velocity;
 *  then the body rotates without torque. */
template <class Real>
struct AngularMotion {
  static constexpr auto kName = "angular_motion", kVersion = "1.0.0";
  static constexpr auto kDoc = "Turns bodies by their torques; inertia 0 does not turn.";
  static constexpr auto kPhase = Phase::kIntegrate;
  static constexpr uint32_t kFirstStage = 1;
  static constexpr uint32_t kClaims = kTranslation | kRotation;

  Read<Vec3<Real>> inertia{"inertia", "body", units::kilogram_metre_squared};
  Read<Vec3<Real>> torque{"torque", "body", units::newton_metre};
  ReadWrite<Vec3<Real>> angular_velocity{"angularVelocity", "body", units::radian_per_second};
  ReadWrite<std::array<Real, 4>> orientation{"orientation", "body", units::one};

  auto Properties() { return std::tie(inertia, torque, angular_velocity, orientation); }

  void Advance(const Step& step) {
    step.ParallelFor(inertia.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        const Vec3<Real> moments = inertia[i];
        if (moments.x == 0 || moments.y == 0 || moments.z == 0) continue;
        if (moments.x == moments.y && moments.y == moments.z) {
          TurnBall(i, moments.x, step.dt);
        } else {
          Turn(i, {moments.x, moments.y, moments.z}, step.dt);
        }
      }
    });
  }

  /** Rotates a body whose three moments of inertia are equal, which is a simpler case of Turn. */
  void TurnBall(uint64_t i, double moment, double dt) const {
    const Vector spin = Wide(angular_velocity[i]) + Wide(torque[i]) * (dt / moment);
    angular_velocity[i] = Narrow<Real>(spin);
    orientation[i] =
        (RotationBy(spin * (dt / 2)) * Quaternion::Load(orientation[i])).template Stored<Real>();
  }

  void Turn(uint64_t i, const std::array<double, 3>& moments, double dt) const {
    Quaternion q = Quaternion::Load(orientation[i]).Normalised();
    // The angular momentum in the world frame is constant, because no torque acts here.
    const Vector spin = q.Inverse().Rotate(Wide(angular_velocity[i]));
    const Vector momentum =
        q.Rotate({spin.x * moments[0], spin.y * moments[1], spin.z * moments[2]}) +
        Wide(torque[i]) * dt;
    q = Drift(q, momentum, moments, dt).Normalised();
    const Vector in_body = q.Inverse().Rotate(momentum);
    angular_velocity[i] = Narrow<Real>(
        q.Rotate({in_body.x / moments[0], in_body.y / moments[1], in_body.z / moments[2]}));
    orientation[i] = q.template Stored<Real>();
  }
};

}  // namespace

VESPER_LAW_LIBRARY("angular_motion", AngularMotion)
