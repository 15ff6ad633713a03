// SPDX-License-Identifier: Apache-2.0
// The columns of the kind `gear`, and the gears that they describe.
#pragma once

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>

#include "joint_solver.hpp"
#include "vesper/law.hpp"

namespace vesper::rigid {

template <class Real>
struct GearColumns {
  OptionalRead<std::array<uint32_t, 2>> geared{"geared", "gear", units::one};
  OptionalRead<Real> ratio{"gearRatio", "gear", units::one};
  OptionalRead<Real> offset_angle{"offsetAngle", "gear", units::one};
  OptionalRead<Real> offset_travel{"offsetTravel", "gear", units::metre};
  OptionalReadWrite<Real> torque{"gearTorque", "gear", units::newton_metre};
  OptionalReadWrite<Real> force{"gearForce", "gear", units::newton};
  OptionalReadWrite<std::array<Real, 2>> places{"gearPlaces", "gear", units::one};

  auto Properties() {
    return std::tie(geared, ratio, offset_angle, offset_travel, torque, force, places);
  }

  /** Adds the gears whose joints act in this step. Call it after the joints are gathered. */
  void Gather(JointSolver<Real>& joints, double dt) {
    if (!geared.present()) return;
    for (uint64_t i = 0; i < geared.size(); ++i) {
      Gear<Real> gear;
      gear.first = joints.Find(geared[i][0]);
      gear.second = joints.Find(geared[i][1]);
      if (!Acts(joints, gear)) continue;
      const bool turns = joints[gear.first].IsHinge();
      gear.ratio = Number(ratio, i);
      gear.offset = turns ? Number(offset_angle, i) : Number(offset_travel, i);
      const double load = turns ? Number(torque, i) : Number(force, i);
      if (places.present()) gear.places = {double{places[i][0]}, double{places[i][1]}};
      if (!std::isfinite(gear.ratio + gear.offset + load + gear.places[0] + gear.places[1])) {
        throw std::runtime_error("gear row " + std::to_string(i) +
                                 " has values that are not finite");
      }
      gear.StartWith(load * dt);
      joints.AddGear(gear, i);
    }
  }

  /** Writes the loads and places of the gears. */
  void Scatter(const JointSolver<Real>& joints, double dt) const {
    if (!geared.present()) return;
    size_t k = 0;
    for (uint64_t i = 0; i < geared.size(); ++i) {
      const bool acts = k < joints.gears().size() && joints.gear_row(k) == i;
      if (acts && joints.GearRests(k++)) continue;
      if (torque.present()) torque[i] = 0;
      if (force.present()) force[i] = 0;
      if (!acts) continue;
      const Gear<Real>& gear = joints.gears()[k - 1];
      const Real load = Real(gear.impulse() / dt);
      const bool turns = joints[gear.first].IsHinge();
      if (turns && torque.present()) torque[i] = load;
      if (!turns && force.present()) force[i] = load;
      if (places.present()) places[i] = {Real(gear.places[0]), Real(gear.places[1])};
    }
  }

 private:
  static bool Acts(const JointSolver<Real>& joints, const Gear<Real>& gear) {
    return gear.first < joints.count() && gear.second < joints.count() &&
           gear.first != gear.second && Gear<Real>::Connects(joints[gear.first]) &&
           Gear<Real>::Connects(joints[gear.second]);
  }

  template <class Column>
  static double Number(const Column& column, uint64_t i) {
    return column.present() ? double{column[i]} : 0;
  }
};

}  // namespace vesper::rigid
