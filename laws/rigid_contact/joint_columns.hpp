// SPDX-License-Identifier: Apache-2.0
// The columns of the kind `joint`, and the joints that they describe.
#pragma once

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>

#include "joint_solver.hpp"
#include "vesper/law.hpp"

namespace vesper::rigid {

constexpr vesper_unit kNewtonMetreSecond = VESPER_UNIT_INIT(2, 1, -1, 0, 0, 0, 0, 1.0, "N*m*s");

template <class Real>
struct JointColumns {
  using Vector3 = Vec3<Real>;

  OptionalRead<std::array<uint32_t, 2>> joined{"joined", "joint", units::one};
  OptionalRead<int32_t> joint_type{"jointType", "joint", units::one};
  OptionalRead<Vector3> anchor{"anchor", "joint", units::metre};
  OptionalRead<Vector3> axis{"axis", "joint", units::one};
  OptionalRead<std::array<Real, 2>> angle_limits{"angleLimits", "joint", units::one};
  OptionalRead<std::array<Real, 2>> travel_limits{"travelLimits", "joint", units::metre};
  OptionalRead<Real> motor_speed{"motorSpeed", "joint", units::radian_per_second};
  OptionalRead<Real> motor_torque{"motorTorque", "joint", units::newton_metre};
  OptionalRead<Real> drive_speed{"driveSpeed", "joint", units::metre_per_second};
  OptionalRead<Real> drive_force{"driveForce", "joint", units::newton};
  OptionalRead<Real> breaking_force{"breakingForce", "joint", units::newton};
  OptionalReadWrite<Vector3> other_anchor{"otherAnchor", "joint", units::metre};
  OptionalReadWrite<std::array<Real, 4>> other_turn{"otherTurn", "joint", units::one};
  OptionalReadWrite<Vector3> joint_force{"jointForce", "joint", units::newton};
  OptionalReadWrite<Vector3> joint_torque{"jointTorque", "joint", units::newton_metre};
  OptionalReadWrite<Real> joint_angle{"jointAngle", "joint", units::one};
  OptionalReadWrite<Real> joint_travel{"jointTravel", "joint", units::metre};
  OptionalReadWrite<int32_t> broken{"broken", "joint", units::one};
  OptionalRead<Real> angle_damping{"angleDamping", "joint", kNewtonMetreSecond};
  OptionalRead<Real> travel_damping{"travelDamping", "joint", units::newton_second_per_metre};
  OptionalRead<Real> angle_friction{"angleFriction", "joint", units::newton_metre};
  OptionalRead<Real> travel_friction{"travelFriction", "joint", units::newton};
  OptionalRead<Real> angle_stiffness{"angleStiffness", "joint", units::newton_metre};
  OptionalRead<Real> travel_stiffness{"travelStiffness", "joint", units::newton_per_metre};
  OptionalRead<Real> rest_angle{"restAngle", "joint", units::one};
  OptionalRead<Real> rest_travel{"restTravel", "joint", units::metre};
  OptionalRead<Real> rotor_inertia{"rotorInertia", "joint", units::kilogram_metre_squared};
  OptionalRead<Real> rotor_mass{"rotorMass", "joint", units::kilogram};
  OptionalRead<Real> motor_angle{"motorAngle", "joint", units::one};
  OptionalRead<Real> motor_stiffness{"motorStiffness", "joint", units::newton_metre};
  OptionalRead<Real> motor_damping{"motorDamping", "joint", kNewtonMetreSecond};
  OptionalRead<Real> drive_travel{"driveTravel", "joint", units::metre};
  OptionalRead<Real> drive_stiffness{"driveStiffness", "joint", units::newton_per_metre};
  OptionalRead<Real> drive_damping{"driveDamping", "joint", units::newton_second_per_metre};
  OptionalReadWrite<Real> angle_speed{"angleSpeed", "joint", units::radian_per_second};
  OptionalReadWrite<Real> travel_speed{"travelSpeed", "joint", units::metre_per_second};
  OptionalRead<Real> rope_length{"ropeLength", "joint", units::metre};
  OptionalRead<Vector3> offset_least{"offsetLeast", "joint", units::metre};
  OptionalRead<Vector3> offset_greatest{"offsetGreatest", "joint", units::metre};
  OptionalRead<Vector3> turn_least{"turnLeast", "joint", units::one};
  OptionalRead<Vector3> turn_greatest{"turnGreatest", "joint", units::one};

  auto Properties() {
    return std::tie(joined, joint_type, anchor, axis, angle_limits, travel_limits, motor_speed,
                    motor_torque, drive_speed, drive_force, breaking_force, other_anchor,
                    other_turn, joint_force, joint_torque, joint_angle, joint_travel, broken);
  }
  /** Returns the columns that only some worlds have. */
  auto LaterProperties() {
    return std::tie(angle_damping, travel_damping, angle_friction, travel_friction, angle_stiffness,
                    travel_stiffness, rest_angle, rest_travel, rotor_inertia, rotor_mass,
                    angle_speed, travel_speed, motor_angle, motor_stiffness, motor_damping,
                    drive_travel, drive_stiffness, drive_damping, rope_length, offset_least,
                    offset_greatest, turn_least, turn_greatest);
  }

  /** Fills `joints` with the joints that are not broken. `law` provides the data of the bodies. */
  template <class Law>
  void Gather(JointSolver<Real>& joints, Law& law, double dt) {
    joints.Reset(joined.present() ? law.rows() : 0);
    const bool complete = joined.present() && joint_type.present() && anchor.present() &&
                          axis.present() && other_anchor.present() && other_turn.present();
    if (!complete) return;
    for (uint64_t i = 0; i < joined.size(); ++i) GatherJoint(joints, law, i, dt);
    joints.Sort();
  }

  /** Writes the state of the joints. `law` provides the motions of the bodies. */
  template <class Law>
  void Scatter(const JointSolver<Real>& joints, const Law& law, double dt) {
    for (size_t k = 0; k < joints.count(); ++k) {
      const uint64_t i = joints.row(k);
      if (joints.Rests(k)) {
        if (angle_speed.present()) angle_speed[i] = 0;
        if (travel_speed.present()) travel_speed[i] = 0;
        continue;
      }
      const Joint<Real>& joint = joints[k];
      const Vector load = joint.Impulse() * (1 / dt);
      if (joint_force.present()) joint_force[i] = Narrow<Real>(load);
      if (joint_torque.present()) joint_torque[i] = Narrow<Real>(joint.Turn() * (1 / dt));
      if (joint_angle.present()) joint_angle[i] = static_cast<Real>(joint.angle());
      if (joint_travel.present()) joint_travel[i] = static_cast<Real>(joint.travel());
      const double speed = joint.Speed(law.MotionOf(joint.a), law.MotionOf(joint.b));
      if (angle_speed.present()) angle_speed[i] = Real(joint.IsHinge() ? speed : 0);
      if (travel_speed.present()) travel_speed[i] = Real(joint.IsHinge() ? 0 : speed);
      const double most = joint.settings.breaking_force;
      if (most > 0 && broken.present() && Dot(load, load) > most * most) {
        broken[i] = 1;
        if (joint_force.present()) joint_force[i] = {};
        if (joint_torque.present()) joint_torque[i] = {};
      }
    }
  }

 private:
  // Lower limit of the length of a rope [m]: a rope does not push.
  static constexpr double kSlack = -1e30;

  template <class Law>
  void GatherJoint(JointSolver<Real>& joints, Law& law, uint64_t i, double dt) {
    const auto type = static_cast<JointType>(joint_type[i]);
    const auto [a, b] = joined[i];
    if (type < JointType::kFixed || type > JointType::kSixAxis || a == b) return;
    if (broken.present() && broken[i] != 0) return;
    if (law.IsBroken(a) || law.IsBroken(b)) return;
    if (law.BodyOf(a) == kImmovable && law.BodyOf(b) == kImmovable) return;
    Joint<Real> joint;
    joint.row_a = a;
    joint.row_b = b;
    joint.a = law.BodyOf(a);
    joint.b = law.BodyOf(b);
    joint.settings = SettingsOf(i, type, law.PoseOf(a), law.PoseOf(b));
    SetLoads(joint.settings, i, dt);
    joint.StartFrom(law.StoredMotion(a), law.StoredMotion(b));
    const Vector load = joint_force.present() ? Wide(joint_force[i]) : Vector{};
    const Vector moment = joint_torque.present() ? Wide(joint_torque[i]) : Vector{};
    joint.StartWith(load * dt, moment * dt);
    for (const uint32_t body : {a, b}) law.MarkJointed(body);
    joints.Add(joint, i);
  }

  JointSettings SettingsOf(uint64_t i, JointType type, const Pose& a, const Pose& b) {
    JointSettings settings;
    settings.type = type;
    settings.anchor_a = Wide(anchor[i]);
    const Vector given = Wide(axis[i]);
    const double length = Length(given);
    settings.axis = length > 0 ? given * (1 / length) : Vector{0, 1, 0};
    if (other_turn[i] == std::array<Real, 4>{}) Join(i, type, a, b);
    settings.anchor_b = Wide(other_anchor[i]);
    settings.rest = Quaternion::Load(other_turn[i]).Normalised();
    const auto number = [&](const auto& column) { return Number(column, i); };
    const auto limit = [&](const auto& column, int side) {
      return column.present() ? double{column[i][side]} : 0;
    };
    settings.angle_low = limit(angle_limits, 0);
    settings.angle_high = limit(angle_limits, 1);
    settings.travel_low = limit(travel_limits, 0);
    settings.travel_high = limit(travel_limits, 1);
    if (type == JointType::kRope) {
      settings.travel_low = kSlack;
      settings.travel_high = number(rope_length);
    }
    if (type == JointType::kSixAxis) SetAxes(settings.six, i);
    settings.motor_speed = number(motor_speed);
    settings.motor_torque = number(motor_torque);
    settings.drive_speed = number(drive_speed);
    settings.drive_force = number(drive_force);
    settings.breaking_force = number(breaking_force);
    const double sum = Dot(settings.anchor_a, settings.anchor_a) + length +
                       Dot(settings.anchor_b, settings.anchor_b) + settings.rest.w +
                       settings.angle_low + settings.angle_high + settings.travel_low +
                       settings.travel_high + settings.motor_speed + settings.motor_torque +
                       settings.drive_speed + settings.drive_force + settings.breaking_force;
    CheckFinite(sum, i);
    return settings;
  }

  void SetAxes(SixAxisSettings& six, uint64_t i) const {
    const auto vector = [&](const auto& column) {
      return column.present() ? Wide(column[i]) : Vector{};
    };
    six.offset_least = vector(offset_least);
    six.offset_greatest = vector(offset_greatest);
    six.turn_least = vector(turn_least);
    six.turn_greatest = vector(turn_greatest);
    six.offset_stiffness = Number(travel_stiffness, i);
    six.offset_damping = Number(travel_damping, i);
    six.turn_stiffness = Number(angle_stiffness, i);
    six.turn_damping = Number(angle_damping, i);
    CheckFinite(six.Sum(), i);
  }

  template <class Column>
  static double Number(const Column& column, uint64_t i) {
    return column.present() ? double{column[i]} : 0;
  }
  static void CheckFinite(double sum, uint64_t i) {
    if (std::isfinite(sum)) return;
    throw std::runtime_error("joint row " + std::to_string(i) + " has values that are not finite");
  }

  /** Reads the loads along the axis of a hinge or slider, and the damping of a ball joint. */
  void SetLoads(JointSettings& settings, uint64_t i, double dt) const {
    const bool slides = settings.type == JointType::kSlider;
    AxisSettings& loads = settings.loads;
    const auto number = [&](const auto& turning, const auto& sliding) {
      return slides ? Number(sliding, i) : Number(turning, i);
    };
    loads.stiffness = number(angle_stiffness, travel_stiffness);
    loads.rest = number(rest_angle, rest_travel);
    loads.damping = number(angle_damping, travel_damping);
    loads.friction = number(angle_friction, travel_friction);
    loads.rotor = number(rotor_inertia, rotor_mass);
    loads.motor_speed = slides ? settings.drive_speed : settings.motor_speed;
    loads.motor_most = slides ? settings.drive_force : settings.motor_torque;
    loads.place = number(motor_angle, drive_travel);
    loads.servo_stiffness = number(motor_stiffness, drive_stiffness);
    loads.servo_damping = number(motor_damping, drive_damping);
    CheckFinite(loads.Sum(), i);
    settings.ball_damping = loads.damping * dt;
  }

  /** Stores the present anchor and rotation of the second body. The joint is at rest in this
   *  position. */
  void Join(uint64_t i, JointType type, const Pose& a, const Pose& b) {
    const Quaternion of_a = a.rotation.Normalised(), of_b = b.rotation.Normalised();
    if (!IsLine(type) && other_anchor[i] == Vector3{}) {
      const Vector at = a.at + of_a.Rotate(Wide(anchor[i]));
      other_anchor[i] = Narrow<Real>(of_b.Inverse().Rotate(at - b.at));
    }
    other_turn[i] = (of_a.Inverse() * of_b).template Stored<Real>();
  }
};

}  // namespace vesper::rigid
