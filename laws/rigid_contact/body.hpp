// SPDX-License-Identifier: Apache-2.0
// The rotation of a body during a step.
#pragma once

#include <array>

#include "shape.hpp"
#include "solver.hpp"

namespace vesper::rigid {

// Angle [rad] by which a body rotates before its inertia in the world frame is computed again.
inline constexpr double kTurned = 0.02;

/** The data of a body besides its motion. */
struct Body {
  Quaternion rotation;
  std::array<double, 3> moments;  // [kg m^2]
  double speed;                   // estimate of the speed of its fastest point [m/s]
  double reach;                   // distance from its centre to its farthest point [m]
  bool translates, rotates;
  bool gyrates;   // its moments of inertia differ, so its angular velocity changes without a torque
  bool broken;    // it has values that are not finite
  Vector turned;  // rotation since its inertia in the world frame was computed [rad]
  bool renewed;   // its inertia in the world frame was computed in this substep
  bool jointed;   // it has a joint, so its inertia in the world frame is computed in every substep
};

/** Returns the inverse inertia tensor of a body in the world frame. */
template <class Real>
Symmetric<Real> InverseInertia(const Body& body) {
  const auto inverse = [&](int i) { return body.moments[i] > 0 ? 1 / body.moments[i] : 0; };
  const double x = inverse(0), y = inverse(1), z = inverse(2);
  if (x == y && y == z) return {Real(x), Real(x), Real(x), 0, 0, 0};
  const Axes axes = Axes::Of(body.rotation);
  const Vector &a = axes.x, &b = axes.y, &c = axes.z;
  return {Real(x * a.x * a.x + y * b.x * b.x + z * c.x * c.x),
          Real(x * a.y * a.y + y * b.y * b.y + z * c.y * c.y),
          Real(x * a.z * a.z + y * b.z * b.z + z * c.z * c.z),
          Real(x * a.x * a.y + y * b.x * b.y + z * c.x * c.y),
          Real(x * a.x * a.z + y * b.x * b.z + z * c.x * c.z),
          Real(x * a.y * a.z + y * b.y * b.z + z * c.y * c.z)};
}

/** Rotates a body for a time h [s]. */
template <class Real>
void Turn(Body& body, Motion<Real>& motion, double h) {
  // Rotation [rad] below which the change of a gyrating body's angular velocity is neglected.
  constexpr double kStill = 1e-6;
  const Vector spin = Wide(motion.spin), angle = spin * h;
  if (!body.gyrates || Dot(angle, angle) < kStill * kStill) {
    body.rotation = RotationBy(angle * 0.5) * body.rotation;
  } else {
    Quaternion q = body.rotation.Normalised();
    const auto& [x, y, z] = body.moments;
    const Vector own = q.Inverse().Rotate(spin);
    const Vector momentum = q.Rotate({own.x * x, own.y * y, own.z * z});
    q = rigid::Drift(q, momentum, body.moments, h).Normalised();
    const Vector after = q.Inverse().Rotate(momentum);
    motion.spin = Narrow<Real>(q.Rotate({after.x / x, after.y / y, after.z / z}));
    body.rotation = q;
  }
  body.turned += angle;
  body.renewed = body.jointed || Dot(body.turned, body.turned) > kTurned * kTurned;
  if (!body.renewed) return;
  body.turned = {};
  motion.inverse_inertia = InverseInertia<Real>(body);
}

}  // namespace vesper::rigid
