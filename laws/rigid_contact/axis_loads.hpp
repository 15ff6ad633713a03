// SPDX-License-Identifier: Apache-2.0
// The loads along the free axis of a hinge or slider: spring, damping, friction, rotor and motor.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vesper::rigid {

/** The loads of an axis, read from the columns of the joint. The units are those of a hinge; the
 *  units of a slider are m, N/m, N s/m, N and kg. */
struct AxisSettings {
  double stiffness = 0, rest = 0;  // [N m] per radian, [rad]
  double damping = 0;              // [N m s]
  double friction = 0;             // largest torque [N m]
  double rotor = 0;                // moment of inertia [kg m^2]
  // The motor. With a servo, its torque is servo_stiffness * (place - angle) + servo_damping *
  // (motor_speed - speed), up to motor_most. Without a servo, its torque is as large as needed to
  // reach motor_speed, up to motor_most.
  double motor_speed = 0, motor_most = 0;         // [rad/s], [N m]
  double place = 0;                               // [rad]
  double servo_stiffness = 0, servo_damping = 0;  // [N m] per radian, [N m s]

  bool HasServo() const { return servo_stiffness > 0 || servo_damping > 0; }
  bool Any() const {
    return stiffness > 0 || damping > 0 || friction > 0 || rotor > 0 || HasServo();
  }
  double Sum() const {
    return stiffness + rest + damping + friction + rotor + place + servo_stiffness + servo_damping;
  }
};

/** The impulse of the loads in a step as a function of the speed at the end of the step. The speed
 *  at the end is used because it makes any damping and stiffness stable. The function falls with
 *  the speed and consists of straight lines. It has a step down at the speed 0 (friction) and at
 *  the speed of a motor without a servo. */
class AxisLoads {
 public:
  /** @param away angle or travel from the rest position of the spring, at the start of the step
   *  @param missing angle or travel to the place of the servo, at the start of the step
   *  @param speed at the start of the step, without the forces of this step
   *  @param mass effective mass or moment of inertia of the two bodies along the axis */
  AxisLoads(const AxisSettings& settings, double away, double missing, double speed, double mass,
            double dt) {
    // Spring and servo act with their lengths after the fraction `late` of the step. This fraction
    // is small for soft springs, so that they keep their energy, and nearly 1 for stiff springs.
    const double all = settings.stiffness + settings.servo_stiffness;
    const double turned = mass > 0 ? all * dt * dt / mass : 0;
    const double late = turned / (1 + turned);
    offset_ = -dt * settings.stiffness * away + settings.rotor * speed;
    slope_ = dt * (settings.damping + settings.stiffness * late * dt) + settings.rotor;
    friction_ = settings.friction * dt;
    motor_speed_ = settings.motor_speed;
    motor_most_ = settings.motor_most * dt;
    has_servo_ = settings.HasServo();
    servo_offset_ =
        dt * (settings.servo_stiffness * missing + settings.servo_damping * settings.motor_speed);
    servo_slope_ = dt * (settings.servo_damping + settings.servo_stiffness * late * dt);
  }
  AxisLoads() = default;

  /** Returns the first guess for the impulse: the impulse of the last step, limited to the possible
   *  impulses of this step. */
  double Guess(double before) const {
    const double most = friction_ + motor_most_;
    return slope_ > 0 || offset_ != 0 ? before : std::clamp(before, -most, most);
  }

  /** Returns the speed at the end of the step, for which mass * (speed - free) is the impulse of
   *  the loads.
   *  @param free speed without the loads */
  double Speed(double free, double mass) const {
    std::array<double, 3> knots;
    int count = 0;
    if (friction_ > 0) knots[count++] = 0;
    if (motor_most_ > 0 && !has_servo_) knots[count++] = motor_speed_;
    if (has_servo_ && servo_slope_ > 0) {  // speeds at which the servo is at its limit
      knots[count++] = (servo_offset_ - motor_most_) / servo_slope_;
      knots[count++] = (servo_offset_ + motor_most_) / servo_slope_;
    }
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
  /** Returns the impulse at a speed just above (side 1) or just below (side -1) the given speed. */
  double Impulse(double speed, double side) const {
    const auto sign = [&](double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : side; };
    const double motor = has_servo_ ? std::clamp(Servo(speed), -motor_most_, motor_most_)
                                    : -motor_most_ * sign(speed - motor_speed_);
    return offset_ - slope_ * speed - friction_ * sign(speed) + motor;
  }
  double Servo(double speed) const { return servo_offset_ - servo_slope_ * speed; }
  double SpeedBetween(double from, double to, double free, double mass) const {
    const double within = std::isinf(from) ? (std::isinf(to) ? 0 : to - 1 - std::abs(to))
                          : std::isinf(to) ? from + 1 + std::abs(from)
                                           : 0.5 * (from + to);
    const bool yields = has_servo_ && std::abs(Servo(within)) < motor_most_;
    const double slope = slope_ + (yields ? servo_slope_ : 0);
    const double speed = (mass * free + Impulse(within, 1) + slope * within) / (mass + slope);
    return std::clamp(speed, from, to);
  }

  double offset_ = 0, slope_ = 0;  // impulse of spring, damping and rotor: offset - slope * speed
  double friction_ = 0;            // largest impulse of the friction
  double motor_speed_ = 0, motor_most_ = 0;
  double servo_offset_ = 0, servo_slope_ = 0;  // impulse below its limit: offset - slope * speed
  bool has_servo_ = false;
};

}  // namespace vesper::rigid
