// SPDX-License-Identifier: Apache-2.0
// Rotations of rigid bodies. They are computed in double for both precisions. In float, a rounding
// error that is equal in every step would add up to a drift.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "vesper/law_columns.hpp"

namespace vesper::rigid {

using Vector = Vec3<double>;

template <class Real>
Vector Wide(const Vec3<Real>& x) {
  return {x.x, x.y, x.z};
}
template <class Real>
Vec3<Real> Narrow(const Vector& x) {
  return {static_cast<Real>(x.x), static_cast<Real>(x.y), static_cast<Real>(x.z)};
}

/** A rotation by the angle a about a unit axis, or a product of rotations that is not normalised
 *  yet. The vector part is the axis times sin(a/2), and the scalar part is cos(a/2). */
struct Quaternion {
  Vector v;
  double w = 1;

  /** Returns the rotation that a column stores as xyzw. */
  template <class Real>
  static Quaternion Load(const std::array<Real, 4>& stored) {
    return {{stored[0], stored[1], stored[2]}, stored[3]};
  }
  /** Returns the normalised rotation as a column stores it, xyzw. */
  template <class Real>
  std::array<Real, 4> Stored() const {
    const Quaternion q = Normalised();
    return {static_cast<Real>(q.v.x), static_cast<Real>(q.v.y), static_cast<Real>(q.v.z),
            static_cast<Real>(q.w)};
  }

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
 *  computed by its Pade approximant of order [3/2], which is accurate to 1e-7 up to 0.5 rad. A
 *  function of libm is not used, because its bits differ between machines. */
inline Quaternion RotationBy(const Vector& half) {
  const double square = Dot(half, half);
  return Quaternion{half * (15 - square), 15 - 6 * square}.Normalised();
}

/** Rotates q about one of the body's own axes; the angle is the momentum about this axis times
 *  `angle_per_momentum`. */
inline Quaternion TurnAboutOwnAxis(const Quaternion& q, const Vector& momentum, int axis,
                                   double angle_per_momentum) {
  const Vector in_body = q.Inverse().Rotate(momentum);
  const double half = angle_per_momentum / 2;
  const Vector turn = axis == 0   ? Vector{in_body.x * half, 0, 0}
                      : axis == 1 ? Vector{0, in_body.y * half, 0}
                                  : Vector{0, 0, in_body.z * half};
  return q * RotationBy(turn);
}

/** Returns the rotation of a free body after `dt` as a product of exact rotations. The first
 *  rotation is about the angular momentum, as if all moments of inertia were the middle moment.
 *  Further rotations, about the axes of the lowest and of the highest moment, account for the
 *  differences from the middle moment. If two moments are equal, one difference is zero and the
 *  product is exact. */
inline Quaternion Drift(Quaternion q, const Vector& momentum, const std::array<double, 3>& moments,
                        double dt) {
  std::array<int, 3> axis = {0, 1, 2};
  std::sort(axis.begin(), axis.end(), [&](int a, int b) { return moments[a] < moments[b]; });
  const double middle = 1 / moments[axis[1]];
  const double low = 1 / moments[axis[0]] - middle, high = 1 / moments[axis[2]] - middle;
  q = TurnAboutOwnAxis(q, momentum, axis[0], low * dt / 2);
  q = TurnAboutOwnAxis(q, momentum, axis[2], high * dt);
  q = TurnAboutOwnAxis(q, momentum, axis[0], low * dt / 2);
  return RotationBy(momentum * (middle * dt / 2)) * q;
}

}  // namespace vesper::rigid
