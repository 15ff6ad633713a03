// SPDX-License-Identifier: Apache-2.0
// The axes of a joint of the type six-axis: three offsets and three angles.
#pragma once

#include <array>
#include <cmath>

#include "rigid/rotation.hpp"

namespace vesper::rigid {

/** Limits and springs of a six-axis joint, in the axes of the first body. An axis is locked if its
 *  two limits are equal, and has no limits if the least value is above the greatest one. */
struct SixAxisSettings {
  Vector offset_least, offset_greatest;             // [m]
  Vector turn_least, turn_greatest;                 // [rad]
  double offset_stiffness = 0, offset_damping = 0;  // [N/m], [N s/m]
  double turn_stiffness = 0, turn_damping = 0;      // [N m] per radian, [N m s]

  double Sum() const {
    const Vector sum = offset_least + offset_greatest + turn_least + turn_greatest;
    return sum.x + sum.y + sum.z + offset_stiffness + offset_damping + turn_stiffness +
           turn_damping;
  }
};

/** One axis of a six-axis joint during a step. */
struct JointAxis {
  Vector direction;  // dot product with the relative velocity: rate of the value
  double value = 0;  // [m] or [rad]
  double begin = 0;  // value at the start of the step
  double least = 0, greatest = 0;
  double mass = 0;           // effective mass or moment of inertia along the direction
  double low = 0, high = 0;  // impulses of the two limits; `low` holds a locked axis
  double spring = 0;         // impulse of spring and damping

  bool IsLocked() const { return least == greatest; }
  bool IsLimited() const { return least < greatest; }
  double Impulse() const { return low + high + spring; }
};

/** The rotation vector of a rotation: the axis times the angle [rad], which is at most pi. Its
 *  components are the three angles of a six-axis joint. */
class RotationVector {
 public:
  /** @param angle_of returns the angle whose tangent is the quotient of its two arguments */
  template <class AngleOf>
  RotationVector(const Quaternion& rotation, AngleOf&& angle_of) {
    const double sign = rotation.w < 0 ? -1 : 1;
    const Vector v = rotation.v * sign;
    const double sine = Length(v), cosine = rotation.w * sign;
    angle_ = 2 * angle_of(sine, cosine);
    vector_ = v * (sine > 0 ? angle_ / sine : 2);
    // The first term of the series replaces a difference of nearly equal numbers.
    curvature_ = sine < 1e-3 ? 1.0 / 12 : (1 - angle_ / 2 * (cosine / sine)) / (angle_ * angle_);
  }

  const Vector& vector() const { return vector_; }
  double angle() const { return angle_; }

  /** Returns the vector whose dot product with the angular velocity is the rate of the component
   *  along an axis e: e^T J^-1, where J is the left Jacobian of the rotation group (Sola et al., A
   *  micro Lie theory for state estimation in robotics, 2018, equation 146). */
  Vector RateOf(const Vector& e) const {
    const Vector once = Cross(vector_, e);
    return e + once * 0.5 + Cross(vector_, once) * curvature_;
  }

 private:
  Vector vector_;
  double angle_ = 0;
  double curvature_ = 0;  // factor of the square of the cross product [1/rad^2]
};

}  // namespace vesper::rigid
