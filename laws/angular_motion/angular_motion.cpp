// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Bodies per chunk of a thread: about half a megabyte of columns.
constexpr uint64_t kGrain = 4096;

// Rotations are computed in double for both precisions: in float, a rounding error that is equal in
// every step would cause drift.
using Vector = Vec3<double>;

/** A rotation, or a product of rotations that is not normalised yet: v sin(a/2), cos(a/2). */
struct Quaternion {
  Vector v;
  double w = 1;

  friend Quaternion operator*(const Quaternion& a, const Quaternion& b) {
    return {a.v * b.w + b.v * a.w + Cross(a.v, b.v), a.w * b.w - Dot(a.v, b.v)};
  }
  Quaternion Inverse() const { return {-v, w}; }
  Quaternion Normalised() const {
    const double scale = 1 / std::sqrt(Dot(v, v) + w * w);
    return {v * scale, w * scale};
  }
  Vector Rotate(const Vector& x) const {
    const Vector t = Cross(v, x) * 2.0;
    return x + t * w + Cross(v, t);
  }
};

/** Returns the rotation by twice the vector `half` [rad]. The tangent of the half angle is
 *  computed by its Pade approximant of order [3/2], accurate to 1e-7 up to 0.5 rad, because the
 *  bits of libm functions differ between machines. */
Quaternion RotationBy(const Vector& half) {
  const double square = Dot(half, half);
  return Quaternion{half * (15 - square), 15 - 6 * square}.Normalised();
}

template <class Real>
Vector Wide(const Vec3<Real>& x) {
  return {x.x, x.y, x.z};
}
template <class Real>
Vec3<Real> Narrow(const Vector& x) {
  return {static_cast<Real>(x.x), static_cast<Real>(x.y), static_cast<Real>(x.z)};
}

/** Euler's equations of a rigid body: the torque changes the angular velocity, then the body
 *  rotates freely for a step. */
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

  /** Rotates a body with three equal moments, a special case of Turn. */
  void TurnBall(uint64_t i, double moment, double dt) const {
    const Vector spin = Wide(angular_velocity[i]) + Wide(torque[i]) * (dt / moment);
    angular_velocity[i] = Narrow<Real>(spin);
    Store(i, RotationBy(spin * (dt / 2)) * Load(i));
  }

  void Turn(uint64_t i, const std::array<double, 3>& moments, double dt) const {
    Quaternion q = Load(i).Normalised();
    // Angular momentum in the world frame, which free motion conserves.
    const Vector spin = q.Inverse().Rotate(Wide(angular_velocity[i]));
    const Vector momentum =
        q.Rotate({spin.x * moments[0], spin.y * moments[1], spin.z * moments[2]}) +
        Wide(torque[i]) * dt;
    q = Drift(q, momentum, moments, dt).Normalised();
    const Vector in_body = q.Inverse().Rotate(momentum);
    angular_velocity[i] = Narrow<Real>(
        q.Rotate({in_body.x / moments[0], in_body.y / moments[1], in_body.z / moments[2]}));
    Store(i, q);
  }

  Quaternion Load(uint64_t i) const {
    const auto [x, y, z, w] = orientation[i];
    return {{x, y, z}, w};
  }
  void Store(uint64_t i, const Quaternion& turned) const {
    const Quaternion q = turned.Normalised();
    orientation[i] = {static_cast<Real>(q.v.x), static_cast<Real>(q.v.y), static_cast<Real>(q.v.z),
                      static_cast<Real>(q.w)};
  }

  /** Returns the rotation of a free body as a product of exact rotations: about the angular
   *  momentum, as a sphere of the middle moment rotates, and about the two other axes by the
   *  differences. With two equal moments one of these is zero, and the product is exact. */
  static Quaternion Drift(Quaternion q, const Vector& momentum,
                          const std::array<double, 3>& moments, double dt) {
    std::array<int, 3> axis = {0, 1, 2};
    std::sort(axis.begin(), axis.end(), [&](int a, int b) { return moments[a] < moments[b]; });
    const double middle = 1 / moments[axis[1]];
    const double low = 1 / moments[axis[0]] - middle, high = 1 / moments[axis[2]] - middle;
    q = TurnAboutOwnAxis(q, momentum, axis[0], low * dt / 2);
    q = TurnAboutOwnAxis(q, momentum, axis[2], high * dt);
    q = TurnAboutOwnAxis(q, momentum, axis[0], low * dt / 2);
    return RotationBy(momentum * (middle * dt / 2)) * q;
  }

  /** Rotates about one of the body's axes by its momentum about that axis times
   *  `angle_per_momentum`. */
  static Quaternion TurnAboutOwnAxis(const Quaternion& q, const Vector& momentum, int axis,
                                     double angle_per_momentum) {
    const Vector in_body = q.Inverse().Rotate(momentum);
    const double half = angle_per_momentum / 2;
    const Vector turn = axis == 0   ? Vector{in_body.x * half, 0, 0}
                        : axis == 1 ? Vector{0, in_body.y * half, 0}
                                    : Vector{0, 0, in_body.z * half};
    return q * RotationBy(turn);
  }
};

}  // namespace

VESPER_LAW_LIBRARY("angular_motion", AngularMotion)
