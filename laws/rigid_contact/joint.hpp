// SPDX-License-Identifier: Apache-2.0
// Joints between two rigid bodies as constraints on their velocities.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "axis_loads.hpp"
#include "shape.hpp"
#include "six_axes.hpp"
#include "solver.hpp"

namespace vesper::rigid {

/** Codes of the column `jointType`. */
enum class JointType : int32_t {
  kNone = 0,
  kFixed = 1,
  kBall = 2,
  kHinge = 3,
  kSlider = 4,
  kDistance = 5,
  kRope = 6,
  kSixAxis = 7,
};

/** Returns whether a joint acts along the line between its two anchors only. */
inline bool IsLine(JointType type) {
  return type == JointType::kDistance || type == JointType::kRope;
}

/** Returns the angle [rad] whose tangent is y / x, from -pi to pi. It replaces atan2 of libm, whose
 *  results have other bits on other machines. */
inline double AngleOf(double y, double x) {
  constexpr double kPi = 3.14159265358979323846;
  const double high = std::max(std::abs(x), std::abs(y));
  if (!(high > 0)) return 0;
  double t = std::min(std::abs(x), std::abs(y)) / high;
  for (int i = 0; i < 3; ++i) t = t / (1 + std::sqrt(1 + t * t));  // halves the angle
  const double s = t * t;
  const double series =
      1 - s * (1. / 3 - s * (1. / 5 - s * (1. / 7 - s * (1. / 9 - s * (1. / 11 - s / 13)))));
  double angle = 8 * t * series;
  if (std::abs(y) > std::abs(x)) angle = kPi / 2 - angle;
  if (x < 0) angle = kPi - angle;
  return y < 0 ? -angle : angle;
}

/** Position and rotation of a body. */
struct Pose {
  Vector at;
  Quaternion rotation;
};

/** Up to three directions in which two bodies must not translate, or must not rotate, relative to
 *  each other. The impulses are sums over the step. */
class Block {
 public:
  /** Sets new orthogonal directions, and projects the impulses of the step so far on them. */
  void Set(const std::array<Vector, 3>& directions, int count) {
    const Vector kept = Impulse();
    directions_ = directions;
    count_ = count;
    for (int i = 0; i < count; ++i) impulses_[i] = Dot(kept, directions[i]);
  }
  int count() const { return count_; }
  const Vector& direction(int i) const { return directions_[i]; }

  void Start(const Vector& impulse) {
    for (int i = 0; i < count_; ++i) impulses_[i] = Dot(impulse, directions_[i]);
  }
  Vector Impulse() const {
    Vector sum;
    for (int i = 0; i < count_; ++i) sum += directions_[i] * impulses_[i];
    return sum;
  }

  /** Inverts the matrix of responses: `response(d)` is the relative velocity that a unit impulse
   *  along d causes. */
  template <class Response>
  void Prepare(Response&& response) {
    double k[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < count_; ++i) {
      const Vector moved = response(directions_[i]);
      for (int j = 0; j < count_; ++j) k[i][j] = Dot(moved, directions_[j]);
    }
    const double c00 = k[1][1] * k[2][2] - k[1][2] * k[2][1];
    const double c01 = k[1][2] * k[2][0] - k[1][0] * k[2][2];
    const double c02 = k[1][0] * k[2][1] - k[1][1] * k[2][0];
    const double determinant = k[0][0] * c00 + k[0][1] * c01 + k[0][2] * c02;
    const double scale = determinant > 0 ? 1 / determinant : 0;
    inverse_[0][0] = c00 * scale;
    inverse_[0][1] = inverse_[1][0] = c01 * scale;
    inverse_[0][2] = inverse_[2][0] = c02 * scale;
    inverse_[1][1] = (k[0][0] * k[2][2] - k[0][2] * k[2][0]) * scale;
    inverse_[1][2] = inverse_[2][1] = (k[0][1] * k[2][0] - k[0][0] * k[2][1]) * scale;
    inverse_[2][2] = (k[0][0] * k[1][1] - k[0][1] * k[1][0]) * scale;
  }

  /** Returns the impulse that stops a relative velocity along the directions. */
  Vector Stop(const Vector& velocity) {
    Vector applied;
    for (int i = 0; i < count_; ++i) {
      double change = 0;
      for (int j = 0; j < count_; ++j) change -= inverse_[i][j] * Dot(velocity, directions_[j]);
      impulses_[i] += change;
      applied += directions_[i] * change;
    }
    return applied;
  }

 private:
  std::array<Vector, 3> directions_;
  std::array<double, 3> impulses_{};
  double inverse_[3][3] = {};
  int count_ = 0;
};

/** The properties of a joint, from its columns. */
struct JointSettings {
  JointType type = JointType::kNone;
  Vector anchor_a, anchor_b;                 // anchors in the frames of the two bodies [m]
  Vector axis;                               // unit vector in the frame of the first body
  Quaternion rest;                           // rotation of the second body in the frame of the
                                             // first, when they were joined
  double angle_low = 0, angle_high = 0;      // [rad]; equal: no limits
  double travel_low = 0, travel_high = 0;    // [m]; equal: no limits, except for a distance joint
                                             // or rope
  double motor_speed = 0, motor_torque = 0;  // [rad/s], [N m]
  double drive_speed = 0, drive_force = 0;   // [m/s], [N]
  AxisSettings loads;                        // loads of a hinge or slider
  double ball_damping = 0;                   // damping of a ball times the step [N m s^2]
  double breaking_force = 0;                 // load above which it breaks [N]; 0: never
  SixAxisSettings six;                       // of a six-axis joint
};

/** A joint during a step. */
template <class Real>
class Joint {
 public:
  uint32_t a = kImmovable, b = kImmovable;  // rows of the bodies; kImmovable if immovable
  uint32_t row_a = 0, row_b = 0;
  JointSettings settings;

  /** Computes directions, masses and errors for the present poses. */
  void Refresh(const Pose& pose_a, const Pose& pose_b, const Motion<Real>& motion_a,
               const Motion<Real>& motion_b) {
    const Vector to_a = pose_a.rotation.Rotate(settings.anchor_a);
    arm_b_ = pose_b.rotation.Rotate(settings.anchor_b);
    apart_ = pose_b.at + arm_b_ - pose_a.at - to_a;
    // The joint acts on both bodies at the anchor of the second body.
    arm_a_ = pose_b.at + arm_b_ - pose_a.at;
    axis_ = pose_a.rotation.Rotate(settings.axis);
    const Quaternion expected = (pose_a.rotation * settings.rest).Normalised();
    const Quaternion turned = pose_b.rotation.Normalised() * expected.Inverse();
    if (HasSixAxes()) SetAxes(pose_a.rotation.Normalised(), turned);
    SetDirections();
    const double sign = turned.w < 0 ? -1 : 1;
    turned_ = turned.v * (2 * sign);
    if (settings.type == JointType::kHinge) {
      const Vector of_b =
          pose_b.rotation.Normalised().Rotate(settings.rest.Inverse().Rotate(settings.axis));
      turned_ = Cross(axis_, of_b);
    }
    angle_ = 2 * AngleOf(Dot(turned.v, axis_) * sign, turned.w * sign);
    travel_ = IsLine(settings.type) || HasSixAxes() ? Length(apart_) : Dot(apart_, axis_);
    misplaced_ = apart_;
    if (HasSixAxes()) {
      angle_ = angle_of_axes_;
      misplaced_ = {};
      for (int i = 0; i < 3; ++i) {
        if (axes_[i].IsLocked()) {
          misplaced_ += axes_[i].direction * (axes_[i].value - axes_[i].least);
        }
      }
    }
    const auto at_anchor = [&](const Vector& d) {
      const auto of = [&](const Motion<Real>& motion, const Vector& arm) {
        return Cross(Wide(motion.inverse_inertia * Narrow<Real>(Cross(arm, d))), arm);
      };
      return d * double(motion_a.inverse_mass + motion_b.inverse_mass) + of(motion_a, arm_a_) +
             of(motion_b, arm_b_);
    };
    const auto turning = [&](const Vector& d) {
      return Wide(motion_a.inverse_inertia * Narrow<Real>(d)) +
             Wide(motion_b.inverse_inertia * Narrow<Real>(d));
    };
    linear_.Prepare(at_anchor);
    angular_.Prepare([&](const Vector& d) {
      return IsDampedBall() ? turning(d) + d * (1 / settings.ball_damping) : turning(d);
    });
    along_mass_ = Inverse(Dot(at_anchor(Along()), Along()));
    about_mass_ = Inverse(Dot(turning(axis_), axis_));
    for (int i = 0; i < AxisCount(); ++i) {
      const Vector& d = axes_[i].direction;
      axes_[i].mass = Inverse(Dot(i < 3 ? at_anchor(d) : turning(d), d));
    }
  }

  /** Sets the impulses of the last step as a first guess for this step [N s], [N m s]. */
  void StartWith(const Vector& impulse, const Vector& turn) {
    start_ = impulse;
    start_turn_ = turn;
  }
  /** Sets the motions of the bodies without the forces of this step. */
  void StartFrom(const Motion<Real>& motion_a, const Motion<Real>& motion_b) {
    earlier_ = {Wide(motion_a.velocity), Wide(motion_a.spin), Wide(motion_b.velocity),
                Wide(motion_b.spin)};
  }
  /** Projects the guess of StartWith on the directions in which the joint can act. Call it after
   *  Refresh. */
  void Start(double dt) {
    linear_.Start(start_);
    angular_.Start(start_turn_);
    for (int i = 0; i < AxisCount(); ++i) {
      JointAxis& axis = axes_[i];
      axis.begin = axis.value;
      if (IsHeldAlone(i)) {
        axis.low = Dot(start_turn_, axis.direction) / Dot(axis.direction, axis.direction);
      }
    }
    if (HasLoads()) return StartLoads(dt);
    const double turn = settings.motor_torque * dt, push = settings.drive_force * dt;
    if (HasMotor()) motor_ = std::clamp(Dot(start_turn_, axis_), -turn, turn);
    if (HasDrive()) drive_ = std::clamp(Dot(start_, axis_), -push, push);
  }
  /** Applies the first guess to the two bodies. */
  void ApplyStart(Motion<Real>& motion_a, Motion<Real>& motion_b) const {
    Apply(linear_.Impulse() + axis_ * GuessedDrive(), GuessedTurn(), motion_a, motion_b);
  }
  /** Applies the first guess of the loads of the axis. Work and Reduce do not include these
   *  loads. */
  void ApplyLoads(Motion<Real>& motion_a, Motion<Real>& motion_b) const {
    if (HasLoads()) Apply(axis_ * drive_, axis_ * motor_, motion_a, motion_b);
  }
  /** Returns the row of a movable body of the joint: the first body, or the second body if the
   *  first is immovable. */
  uint32_t MovableRow() const { return a == kImmovable ? row_b : row_a; }

  /** Returns the dot product of the first guess of the impulses and the relative velocities [J]. */
  double Work(const Motion<Real>& motion_a, const Motion<Real>& motion_b) const {
    return Dot(linear_.Impulse() + axis_ * GuessedDrive(), Relative(motion_a, motion_b)) +
           Dot(GuessedTurn(), Turning(motion_a, motion_b));
  }

  /** Scales the first guess by a factor below 1, and corrects the motions accordingly. */
  void Reduce(double part, Motion<Real>& motion_a, Motion<Real>& motion_b) {
    const Vector impulse = linear_.Impulse(), turn = angular_.Impulse();
    Apply((impulse + axis_ * GuessedDrive()) * (part - 1), GuessedTurn() * (part - 1), motion_a,
          motion_b);
    linear_.Start(impulse * part);
    angular_.Start(turn * part);
    for (int i = 0; i < AxisCount(); ++i) axes_[i].low *= part;
    if (HasLoads()) return;
    drive_ *= part;
    motor_ *= part;
  }

  /** Changes the impulses so that the joint permits the velocities. With `push`, also corrects
   *  position errors. */
  void Solve(Motion<Real>& motion_a, Motion<Real>& motion_b, const SolverStep<Real>& step,
             bool push) {
    const double h = double{step.substep};
    Drive(motion_a, motion_b, double{step.dt});
    if (HasTravelLimits()) {
      const double rate = Dot(Relative(motion_a, motion_b), Along());
      const auto [low, high] = Limited(travel_, settings.travel_low, settings.travel_high, rate,
                                       along_mass_, h, push, low_push_, high_push_);
      Apply(Along() * (low + high), {}, motion_a, motion_b);
    }
    if (HasAngleLimits()) {
      const double rate = Dot(Turning(motion_a, motion_b), axis_);
      const auto [low, high] = Limited(angle_, settings.angle_low, settings.angle_high, rate,
                                       about_mass_, h, push, low_turn_, high_turn_);
      Apply({}, axis_ * (low + high), motion_a, motion_b);
    }
    for (int i = 0; i < AxisCount(); ++i) SolveAxis(i, motion_a, motion_b, step, push);
    const double undo = push ? kUndone / h : 0;
    if (IsDampedBall()) {
      const Vector yielding = angular_.Impulse() * (1 / settings.ball_damping);
      Apply({}, angular_.Stop(Turning(motion_a, motion_b) + yielding), motion_a, motion_b);
    } else if (angular_.count() > 0) {
      const Vector turn =
          angular_.Stop(Turning(motion_a, motion_b) + AtMost(turned_ * undo, step.push_speed));
      Apply({}, turn, motion_a, motion_b);
    }
    if (linear_.count() > 0) {
      const Vector impulse =
          linear_.Stop(Relative(motion_a, motion_b) + AtMost(misplaced_ * undo, step.push_speed));
      Apply(impulse, {}, motion_a, motion_b);
    }
  }

  /** Returns the joint's impulse of this step on the second body, at its anchor [N s]. */
  Vector Impulse() const {
    return linear_.Impulse() + Along() * (drive_ + low_push_ + high_push_) + OfAxes(0);
  }
  /** Returns the joint's angular impulse of this step on the second body [N m s]. */
  Vector Turn() const {
    return angular_.Impulse() + axis_ * (motor_ + low_turn_ + high_turn_) + OfAxes(3);
  }
  double angle() const { return angle_; }
  double travel() const { return travel_; }
  bool HasRotor() const { return HasLoads() && settings.loads.rotor > 0; }
  bool IsHinge() const { return settings.type == JointType::kHinge; }
  bool IsSlider() const { return settings.type == JointType::kSlider; }
  /** Returns the axis of a hinge or slider in the axes of the world. */
  const Vector& axis() const { return axis_; }
  /** Return the lever arms from the centres of the bodies to the point at which the joint acts
   *  [m]. */
  const Vector& arm_a() const { return arm_a_; }
  const Vector& arm_b() const { return arm_b_; }
  /** Returns the rate of the angle of a hinge [rad/s], of the travel of a slider [m/s], or of the
   *  length of a distance joint or rope [m/s]; 0 for other types. */
  double Speed(const Motion<Real>& motion_a, const Motion<Real>& motion_b) const {
    switch (settings.type) {
      case JointType::kHinge:
        return Dot(Turning(motion_a, motion_b), axis_);
      case JointType::kSlider:
      case JointType::kDistance:
      case JointType::kRope:
        return Dot(Relative(motion_a, motion_b), Along());
      default:
        return 0;
    }
  }

 private:
  // Fraction of a position error that a substep corrects.
  static constexpr double kUndone = 0.5;

  /** Returns the vector, shortened to length `most` if it is longer. */
  static Vector AtMost(const Vector& v, Real most) {
    const double square = Dot(v, v), limit = double{most};
    return square > limit * limit ? v * (limit / std::sqrt(square)) : v;
  }
  static double Inverse(double k) { return k > 0 ? 1 / k : 0; }

  bool HasMotor() const { return settings.type == JointType::kHinge && settings.motor_torque > 0; }
  bool HasDrive() const { return settings.type == JointType::kSlider && settings.drive_force > 0; }
  double GuessedMotor() const { return HasLoads() ? 0 : motor_; }
  double GuessedDrive() const { return HasLoads() ? 0 : drive_; }
  Vector GuessedTurn() const {
    Vector sum = angular_.Impulse() + axis_ * GuessedMotor();
    for (int i = 3; i < AxisCount(); ++i) {
      if (IsHeldAlone(i)) sum += axes_[i].direction * axes_[i].low;
    }
    return sum;
  }
  bool HasSixAxes() const { return settings.type == JointType::kSixAxis; }
  int AxisCount() const { return HasSixAxes() ? 6 : 0; }
  /** Returns whether all rotations of a six-axis joint are locked in the orientation of the
   *  beginning. The block `angular_` holds them then. */
  bool HoldsOrientation() const {
    const SixAxisSettings& six = settings.six;
    return six.turn_least == Vector{} && six.turn_greatest == Vector{};
  }
  /** Returns whether an axis is locked, and no block holds it. The block `linear_` holds the locked
   *  offsets. */
  bool IsHeldAlone(int i) const { return i >= 3 && axes_[i].IsLocked() && !HoldsOrientation(); }
  /** Returns the sum of the impulses along three axes, from the index `from` on. */
  Vector OfAxes(int from) const {
    Vector sum;
    for (int i = from; i < std::min(from + 3, AxisCount()); ++i) {
      sum += axes_[i].direction * axes_[i].Impulse();
    }
    return sum;
  }
  bool HasLoads() const {
    return (IsSlider() || settings.type == JointType::kHinge) && settings.loads.Any();
  }
  bool IsDampedBall() const {
    return settings.type == JointType::kBall && settings.ball_damping > 0;
  }
  bool HasAngleLimits() const {
    return settings.type == JointType::kHinge && settings.angle_low < settings.angle_high;
  }
  bool HasTravelLimits() const {
    return IsLine(settings.type) ||
           (settings.type == JointType::kSlider && settings.travel_low < settings.travel_high);
  }

  /** Returns the direction in which the joint's travel is measured. */
  Vector Along() const {
    if (!IsLine(settings.type)) return axis_;
    const double length = Length(apart_);
    return length > 0 ? apart_ * (1 / length) : Vector{0, 1, 0};
  }

  /** Sets directions, values and limits of the axes of a six-axis joint.
   *  @param turned rotation of the second body from its place at the beginning, in the axes of the
   *      world */
  void SetAxes(const Quaternion& of_a, const Quaternion& turned) {
    const SixAxisSettings& six = settings.six;
    const RotationVector angles({of_a.Inverse().Rotate(turned.v), turned.w}, AngleOf);
    const Vector offset = of_a.Inverse().Rotate(apart_);
    const std::array<Vector, 3> units = {Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}};
    for (int i = 0; i < 3; ++i) {
      const auto set = [&](JointAxis& axis, const Vector& direction, const Vector& value,
                           const Vector& least, const Vector& greatest) {
        axis.direction = of_a.Rotate(direction);
        axis.value = Dot(value, units[i]);
        axis.least = Dot(least, units[i]);
        axis.greatest = Dot(greatest, units[i]);
      };
      set(axes_[i], units[i], offset, six.offset_least, six.offset_greatest);
      set(axes_[i + 3], angles.RateOf(units[i]), angles.vector(), six.turn_least,
          six.turn_greatest);
    }
    angle_of_axes_ = angles.angle();
  }

  void SetDirections() {
    const std::array<Vector, 3> world = {Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}};
    std::array<Vector, 3> across = world;
    const Vector smallest = std::abs(axis_.x) < 0.6 ? world[0] : world[1];
    const Vector u = Cross(axis_, smallest);
    const double length = Length(u);
    across[0] = length > 0 ? u * (1 / length) : world[0];
    across[1] = Cross(axis_, across[0]);
    switch (settings.type) {
      case JointType::kFixed:
        linear_.Set(world, 3);
        angular_.Set(world, 3);
        break;
      case JointType::kBall:
        linear_.Set(world, 3);
        angular_.Set(world, IsDampedBall() ? 3 : 0);
        break;
      case JointType::kHinge:
        linear_.Set(world, 3);
        angular_.Set(across, 2);
        break;
      case JointType::kSlider:
        linear_.Set(across, 2);
        angular_.Set(world, 3);
        break;
      case JointType::kSixAxis: {
        std::array<Vector, 3> locked = world;
        int count = 0;
        for (int i = 0; i < 3; ++i) {
          if (axes_[i].IsLocked()) locked[count++] = axes_[i].direction;
        }
        linear_.Set(locked, count);
        angular_.Set(world, HoldsOrientation() ? 3 : 0);
        break;
      }
      default:
        linear_.Set(world, 0);
        angular_.Set(world, 0);
    }
  }

  Vector Relative(const Motion<Real>& motion_a, const Motion<Real>& motion_b) const {
    return Wide(motion_b.velocity) + Cross(Wide(motion_b.spin), arm_b_) - Wide(motion_a.velocity) -
           Cross(Wide(motion_a.spin), arm_a_);
  }
  static Vector Turning(const Motion<Real>& motion_a, const Motion<Real>& motion_b) {
    return Wide(motion_b.spin) - Wide(motion_a.spin);
  }

  void Apply(const Vector& impulse, const Vector& turn, Motion<Real>& motion_a,
             Motion<Real>& motion_b) const {
    const auto apply = [&](Motion<Real>& motion, const Vector& arm, double sign) {
      motion.velocity += Narrow<Real>(impulse * sign) * motion.inverse_mass;
      motion.spin += motion.inverse_inertia * Narrow<Real>((Cross(arm, impulse) + turn) * sign);
    };
    apply(motion_a, arm_a_, -1);
    apply(motion_b, arm_b_, 1);
  }

  /** Changes the relative velocity towards the speeds of the motor and the drive. Torque and force
   *  do not exceed those of the motor and the drive. */
  void Drive(Motion<Real>& motion_a, Motion<Real>& motion_b, double dt) {
    if (HasLoads()) return SolveLoads(motion_a, motion_b);
    if (HasMotor()) {
      const double off = settings.motor_speed - Dot(Turning(motion_a, motion_b), axis_);
      const double most = settings.motor_torque * dt;
      const double to = std::clamp(motor_ + off * about_mass_, -most, most);
      Apply({}, axis_ * (to - motor_), motion_a, motion_b);
      motor_ = to;
    }
    if (HasDrive()) {
      const double off = settings.drive_speed - Dot(Relative(motion_a, motion_b), axis_);
      const double most = settings.drive_force * dt;
      const double to = std::clamp(drive_ + off * along_mass_, -most, most);
      Apply(axis_ * (to - drive_), {}, motion_a, motion_b);
      drive_ = to;
    }
  }

  /** Sets the loads of this step, and the first guess for their impulse. */
  void StartLoads(double dt) {
    const bool slides = IsSlider();
    const Vector relative =
        earlier_[2] + Cross(earlier_[3], arm_b_) - earlier_[0] - Cross(earlier_[1], arm_a_);
    const double speed = Dot(slides ? relative : earlier_[3] - earlier_[1], axis_);
    const double value = slides ? travel_ : angle_;
    loads_ = AxisLoads(settings.loads, Away(value, settings.loads.rest),
                       -Away(value, settings.loads.place), speed, AxisMass(), dt);
    AxisImpulse() = loads_.Guess(Dot(slides ? start_ : start_turn_, axis_));
  }
  /** Returns the difference between the present angle or travel and a place. For a hinge without
   *  limits, returns the shorter of the two possible angles. */
  double Away(double value, double place) const {
    double away = value - place;
    if (IsSlider() || HasAngleLimits()) return away;
    constexpr double kTurn = 2 * 3.14159265358979323846;
    away -= kTurn * std::floor(away / kTurn + 0.5);
    return away;
  }
  double AxisMass() const { return IsSlider() ? along_mass_ : about_mass_; }
  double& AxisImpulse() { return IsSlider() ? drive_ : motor_; }

  /** Changes the relative velocity along the axis to the speed at which the loads of the axis and
   *  the inertia of the bodies are in balance. */
  void SolveLoads(Motion<Real>& motion_a, Motion<Real>& motion_b) {
    const double mass = AxisMass();
    if (!(mass > 0)) return;
    double& impulse = AxisImpulse();
    const double rate =
        Dot(IsSlider() ? Relative(motion_a, motion_b) : Turning(motion_a, motion_b), axis_);
    const double free = rate - impulse / mass;
    const double to = mass * (loads_.Speed(free, mass) - free);
    const Vector change = axis_ * (to - impulse);
    impulse = to;
    if (IsSlider()) return Apply(change, {}, motion_a, motion_b);
    Apply({}, change, motion_a, motion_b);
  }

  /** Changes the impulses of an axis of a six-axis joint. */
  void SolveAxis(int i, Motion<Real>& motion_a, Motion<Real>& motion_b,
                 const SolverStep<Real>& step, bool push) {
    JointAxis& axis = axes_[i];
    const double h = double{step.substep}, dt = double{step.dt};
    const auto rate = [&] {
      return Dot(i < 3 ? Relative(motion_a, motion_b) : Turning(motion_a, motion_b),
                 axis.direction);
    };
    const auto act = [&](double impulse) {
      const Vector along = axis.direction * impulse;
      if (i < 3) return Apply(along, {}, motion_a, motion_b);
      Apply({}, along, motion_a, motion_b);
    };
    if (axis.IsLocked()) {
      if (!IsHeldAlone(i)) return;
      const double most = double{step.push_speed};
      const double back =
          push ? std::clamp(kUndone / h * (axis.least - axis.value), -most, most) : 0;
      const double change = axis.mass * (back - rate());
      axis.low += change;
      return act(change);
    }
    const SixAxisSettings& six = settings.six;
    const double stiffness = i < 3 ? six.offset_stiffness : six.turn_stiffness;
    const double damping = i < 3 ? six.offset_damping : six.turn_damping;
    const double slope = dt * (damping + stiffness * dt);
    if (slope > 0 && axis.mass > 0) {
      // The impulse of the spring is -dt (stiffness (begin + dt rate) + damping rate).
      const double free = rate() - axis.spring / axis.mass;
      const double to = -(dt * stiffness * axis.begin + slope * free) / (1 + slope / axis.mass);
      act(to - axis.spring);
      axis.spring = to;
    }
    if (!axis.IsLimited()) return;
    const auto [low, high] = Limited(axis.value, axis.least, axis.greatest, rate(), axis.mass, h,
                                     push, axis.low, axis.high);
    act(low + high);
  }

  /** Changes the impulses of the lower and the upper limit so that `value` stays between them.
   *  Returns the two changes.
   */
  static std::pair<double, double> Limited(double value, double low, double high, double rate,
                                           double mass, double h, bool push, double& low_impulse,
                                           double& high_impulse) {
    const auto allowed = [&](double gap) {
      return gap > 0 ? gap / h : push ? kUndone * gap / h : 0;
    };
    const double to_low = std::max(0.0, low_impulse - mass * (rate + allowed(value - low)));
    const double change = to_low - low_impulse;
    low_impulse = to_low;
    rate += mass > 0 ? change / mass : 0;
    const double to_high = std::min(0.0, high_impulse - mass * (rate - allowed(high - value)));
    const double other = to_high - high_impulse;
    high_impulse = to_high;
    return {change, other};
  }

  Block linear_, angular_;
  Vector start_, start_turn_;
  std::array<Vector, 4> earlier_;  // velocity and spin of the first, then of the second body
  AxisLoads loads_;
  Vector arm_a_, arm_b_, apart_, turned_, axis_;
  Vector misplaced_;  // offset that a block must undo
  std::array<JointAxis, 6> axes_;
  double angle_of_axes_ = 0;
  double angle_ = 0, travel_ = 0, along_mass_ = 0, about_mass_ = 0;
  double motor_ = 0, drive_ = 0, low_push_ = 0, high_push_ = 0, low_turn_ = 0, high_turn_ = 0;
};

}  // namespace vesper::rigid
