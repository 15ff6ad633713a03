// SPDX-License-Identifier: Apache-2.0
// What acts along the free axis of a hinge or slider: spring, damping, friction, rotor and motor.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vesper::rigid {

/** The loads of an axis, from the columns of the joint. Units are those of a hinge; a slider has m,
 *  N/m, N s/m, N and kg. */
struct AxisSettings {
  double stiffness = 0, rest = 0;  // [N m] per radian, [rad]
  double damping = 0;              // [N m s]
  double friction = 0;             // largest torque [N m]
  double rotor = 0;                // moment of inertia [kg m^2]

  bool Any() const { return stiffness > 0 || damping > 0 || friction > 0 || rotor > 0; }
  double Sum() const { return stiffness + rest + damping + friction + rotor; }
};

/** The impulse of the loads in a step as a function of the speed at its end. The function falls
 *  with the speed and consists of straight lines, with a step down at the speed 0 (friction) and at
 *  the speed of the motor. It depends on the speed at the end of the step, so that the largest
 *  damping and stiffness are stable. */
class AxisLoads {
 public:
  /** @param away angle or travel from the rest position of the spring, at the start of the step
   *  @param speed at the start of the step, without the forces of this step
   *  @param mass effective mass or moment of inertia of the two bodies along the axis */
  AxisLoads(const AxisSettings& settings, double away, double speed, double mass, double dt,
            double motor_speed, double motor_most) {
    // The spring acts with its length after the share `late` of the step. The share is small for
    // soft springs, which then keep their energy, and nearly 1 for stiff ones.
    const double turned = mass > 0 ? settings.stiffness * dt * dt / mass : 0;
    const double late = turned / (1 + turned);
    offset_ = -dt * settings.stiffness * away + settings.rotor * speed;
    slope_ = dt * (settings.damping + settings.stiffness * late * dt) + settings.rotor;
    friction_ = settings.friction * dt;
    motor_speed_ = motor_speed;
    motor_most_ = motor_most * dt;
  }
  AxisLoads() = default;

  /** Returns the first guess for the impulse: that of the last step, as far as it is possible. */
  double Guess(double before) const {
    const double most = friction_ + motor_most_;
    return slope_ > 0 || offset_ != 0 ? before : std::clamp(before, -most, most);
  }

  /** Returns the speed at the end of the step: mass * (speed - free) is the impulse of the loads.
   *  @param free speed without the loads */
  double Speed(double free, double mass) const {
    std::array<double, 2> knots;
    int count = 0;
    if (friction_ > 0) knots[count++] = 0;
    if (motor_most_ > 0) knots[count++] = motor_speed_;
    std::sort(knots.begin(), knots.begin() + count);
    double from = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
      const double needed = mass * (knots[i] - free);
      if (needed >= Impulse(knots[i], 1)) {
        return needed <= Impulse(knots[i], -1) ? knots[i]
                                               : SpeedBetween(from, knots[i], free, mass);
      }
      from = knots[i];
    }
    return SpeedBetween(from, std::numeric_limits<double>::infinity(), free, mass);
  }

 private:
  /** Returns the impulse at a speed just above (side 1) or just below (-1) the given one. */
  double Impulse(double speed, double side) const { return Constant(speed, side) - slope_ * speed; }
  /** Returns the part of the impulse that does not change near a speed. */
  double Constant(double speed, double side) const {
    const auto sign = [&](double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : side; };
    return offset_ - friction_ * sign(speed) - motor_most_ * sign(speed - motor_speed_);
  }
  double SpeedBetween(double from, double to, double free, double mass) const {
    const double within = std::isinf(from) ? (std::isinf(to) ? 0 : to - 1 - std::abs(to))
                          : std::isinf(to) ? from + 1 + std::abs(from)
                                           : 0.5 * (from + to);
    const double speed = (mass * free + Constant(within, 1)) / (mass + slope_);
    return std::clamp(speed, from, to);
  }

  double offset_ = 0, slope_ = 0;  // impulse of spring, damping and rotor: offset - slope * speed
  double friction_ = 0;            // largest impulse of the friction
  double motor_speed_ = 0, motor_most_ = 0;
};

}  // namespace vesper::rigid
