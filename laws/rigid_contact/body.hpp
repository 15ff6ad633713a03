// SPDX-License-Identifier: Apache-2.0
// The rotation of a body during a step.
#pragma once

#include <array>

#include "shape.hpp"
#include "solver.hpp"

namespace vesper::rigid {

// Rotation after which the inertia of a body in the world is computed again [rad].
inline constexpr double kTurned = 0.02;

/** A body besides its motion. */
struct Body {
  Quaternion rotation;
  std::array<double, 3> moments;  // [kg m^2]
  double speed;                   // of its fastest point, about [m/s]
  bool translates, rotates;
  bool gyrates;   // its moments differ, so that its spin changes without a torque
  bool broken;    // has values that are not finite
  Vector turned;  // since its inertia in the world was computed [rad]
  bool renewed;   // its inertia in the world was computed in this substep
  bool jointed;   // its inertia in the world is computed in every substep
};

/** Returns the inverse of the inertia of a body in the world frame. */
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
  // Below this angle [rad], a rotation does not change the spin of a body without a torque.
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
