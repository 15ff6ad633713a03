// SPDX-License-Identifier: Apache-2.0
// Impulses at contacts, by Gauss-Seidel iterations in substeps that move the bodies.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "lanes.hpp"
#include "manifold.hpp"

namespace vesper::rigid {

/** A symmetric matrix. */
template <class Real>
struct Symmetric {
  Real xx{}, yy{}, zz{}, xy{}, xz{}, yz{};

  friend Vec3<Real> operator*(const Symmetric& m, const Vec3<Real>& v) {
    return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
            m.xz * v.x + m.yz * v.y + m.zz * v.z};
  }
};

/** Index that represents all immovable bodies. */
constexpr uint32_t kImmovable = UINT32_MAX;

/** Motion of a body during a step. */
template <class Real>
struct Motion {
  Vec3<Real> velocity, spin;        // [m/s], [rad/s]
  Vec3<Real> moved, turned;         // translation and rotation since the start of the step [m],
                                    // [rad]
  Real inverse_mass{};              // [1/kg]
  Symmetric<Real> inverse_inertia;  // tensor in the world frame [1/(kg m^2)]
  Vec3<Real> push;                  // acceleration by the forces of other laws [m/s^2]

  void Apply(const Vec3<Real>& impulse, const Vec3<Real>& arm) {
    velocity += impulse * inverse_mass;
    spin += inverse_inertia * Cross(arm, impulse);
  }
  Vec3<Real> VelocityAt(const Vec3<Real>& arm) const { return velocity + Cross(spin, arm); }
};

/** Constants of the solver for one step. */
template <class Real>
struct SolverStep {
  Real dt, substep;        // [s]
  Real push_rate;          // fraction of an overlap that is corrected per time [1/s]
  Real hardness;           // fraction of the required change of velocity that one iteration applies
                           // at an overlapping point
  Real yield;              // fraction of its impulse that an overlapping point loses in one
                           // iteration
  Real push_speed;         // greatest speed at which overlaps are corrected [m/s]
  Real restitution_speed;  // approach speed below which bodies do not bounce [m/s]
  uint32_t substeps;

  /** Returns the constants of a step; the section Limits of README.md explains the contact springs.
   *  */
  static SolverStep Of(Real dt, uint32_t count, Real push_speed, Real restitution_speed) {
    // Contacts yield like damped springs with kOscillations oscillations per step and kDamping
    // times the critical damping.
    constexpr double kOscillations = 0.5, kDamping = 10;
    constexpr double kTurn = 2 * 3.14159265358979323846;
    const double substep = double{dt} / count, angle = kTurn * kOscillations / count;
    const double damped = 2 * kDamping + angle, stiff = angle * damped;
    return {dt,
            static_cast<Real>(substep),
            static_cast<Real>(angle / (substep * damped)),
            static_cast<Real>(stiff / (1 + stiff)),
            static_cast<Real>(1 / (1 + stiff) / count),
            push_speed,
            restitution_speed,
            count};
  }
};

/** The part of a contact that its repeated corrections use: a manifold of points as constraints on
 *  the velocities of two bodies. `Number` is a single number, or Lanes with the numbers of several
 *  contacts that have equally many points. */
template <class Number>
struct ContactCore {
  using Vector = Vec3<Number>;

  struct Point {
    Vector arm_a, arm_b;  // lever arms from the centres of the bodies to the point [m]
    Number separation;    // separation at the start of the step [m]
    Number mass;          // effective mass along the normal [kg]
    Number across[3];     // inverse of the symmetric 2x2 matrix of responses perpendicular to the
                          // normal
    Number across_mass;   // smallest effective mass perpendicular to the normal [kg]
    Number press;         // impulse along the normal [N s]
    Number rub[2];        // friction impulses perpendicular to the normal [N s]
  };

  Vector normal, across[2];
  Number friction;
  Vector mean_arm_a, mean_arm_b;  // means of the arms over the points [m]
  Number mean_mass;               // effective mass at the mean of the points [kg]
  std::array<Point, Manifold::kMost> points;
  int count;

  /** Returns the inverse of a response, or 0 if the response is 0. */
  static Number Inverse(Number response) {
    return Select(response > Number(0), Number(1) / response, Number(0));
  }

  static Number MassAlong(const Vector& direction, const Vector& arm_a, const Vector& arm_b,
                          const Motion<Number>& body_a, const Motion<Number>& body_b) {
    const Vector turn_a = Cross(arm_a, direction), turn_b = Cross(arm_b, direction);
    return Inverse(body_a.inverse_mass + body_b.inverse_mass +
                   Dot(body_a.inverse_inertia * turn_a, turn_a) +
                   Dot(body_b.inverse_inertia * turn_b, turn_b));
  }

  /** Computes the effective masses at all points. */
  void FindMasses(const Motion<Number>& body_a, const Motion<Number>& body_b) {
    mean_mass = MassAlong(normal, mean_arm_a, mean_arm_b, body_a, body_b);
    for (int i = 0; i < count; ++i) {
      Point& p = points[i];
      const auto response = [&](const Vector& direction) {
        return direction * (body_a.inverse_mass + body_b.inverse_mass) +
               Cross(body_a.inverse_inertia * Cross(p.arm_a, direction), p.arm_a) +
               Cross(body_b.inverse_inertia * Cross(p.arm_b, direction), p.arm_b);
      };
      p.mass = MassAlong(normal, p.arm_a, p.arm_b, body_a, body_b);
      const Vector u = response(across[0]), v = response(across[1]);
      const Number uu = Dot(u, across[0]), uv = Dot(u, across[1]), vv = Dot(v, across[1]);
      const Number scale = Inverse(uu * vv - uv * uv);
      p.across[0] = vv * scale;
      p.across[1] = -uv * scale;
      p.across[2] = uu * scale;
      p.across_mass =
          Inverse((uu + vv) / Number(2) + Sqrt((uu - vv) * (uu - vv) / Number(4) + uv * uv));
    }
  }

  Vector Impulse(const Point& p) const {
    return normal * p.press + across[0] * p.rub[0] + across[1] * p.rub[1];
  }

  /** Applies the impulses of the last step as a first guess. */
  void WarmStart(Motion<Number>& body_a, Motion<Number>& body_b) const {
    for (int i = 0; i < count; ++i) {
      const Vector impulse = Impulse(points[i]);
      body_a.Apply(-impulse, points[i].arm_a);
      body_b.Apply(impulse, points[i].arm_b);
    }
  }

  Vector Relative(const Motion<Number>& body_a, const Motion<Number>& body_b,
                  const Point& p) const {
    return body_b.VelocityAt(p.arm_b) - body_a.VelocityAt(p.arm_a);
  }

  /** Returns the present separation of a point, to first order in the motion since the start of the
   *  step. */
  Number Separation(const Motion<Number>& body_a, const Motion<Number>& body_b,
                    const Point& p) const {
    return p.separation + Dot(body_b.moved + Cross(body_b.turned, p.arm_b) - body_a.moved -
                                  Cross(body_a.turned, p.arm_a),
                              normal);
  }

  /** Changes the friction impulses so that the surfaces do not slip. */
  void Rub(Motion<Number>& body_a, Motion<Number>& body_b) {
    for (int i = 0; i < count; ++i) {
      Point& p = points[i];
      const Number limit = friction * p.press;
      const Vector slip = Relative(body_a, body_b, p);
      const Number x = Dot(slip, across[0]), y = Dot(slip, across[1]);
      Number to_x = p.rub[0] - (p.across[0] * x + p.across[1] * y);
      Number to_y = p.rub[1] - (p.across[1] * x + p.across[2] * y);
      const auto slips = to_x * to_x + to_y * to_y > limit * limit;
      if (Any(slips)) {
        // The contact slips. The same effective mass is used for both directions, so that the
        // friction is opposite to the velocity.
        const Number even_x = p.rub[0] - p.across_mass * x, even_y = p.rub[1] - p.across_mass * y;
        const Number square = even_x * even_x + even_y * even_y;
        const Number scale = Select(square > limit * limit, limit / Sqrt(square), Number(1));
        to_x = Select(slips, even_x * scale, to_x);
        to_y = Select(slips, even_y * scale, to_y);
      }
      const Vector impulse = across[0] * (to_x - p.rub[0]) + across[1] * (to_y - p.rub[1]);
      p.rub[0] = to_x;
      p.rub[1] = to_y;
      body_a.Apply(-impulse, p.arm_a);
      body_b.Apply(impulse, p.arm_b);
    }
  }

  /** Changes the normal impulses so that the surfaces do not approach. With `push`, also corrects
   *  overlaps. */
  template <class Step>
  void PressApart(Motion<Number>& body_a, Motion<Number>& body_b, const Step& step, bool push) {
    std::array<Number, Manifold::kMost> allowed;
    for (int i = 0; i < count; ++i) {
      allowed[i] = Allowed(Separation(body_a, body_b, points[i]), step, push);
    }
    if (count > 1) PressTogether(body_a, body_b, allowed);
    for (int i = 0; i < count; ++i) {
      Point& p = points[i];
      const Number apart = Dot(Relative(body_a, body_b, p), normal);
      Number change = p.mass * (apart + allowed[i]);
      if (push) {
        const Number soft =
            Number(step.hardness) * p.mass * (apart + allowed[i]) + Number(step.yield) * p.press;
        change = Select(allowed[i] <= Number(0), soft, change);
      }
      Press(body_a, body_b, p, Larger(Number(0), p.press - change));
    }
  }

  void Press(Motion<Number>& body_a, Motion<Number>& body_b, Point& p, Number to) const {
    const Vector impulse = normal * (to - p.press);
    p.press = to;
    body_a.Apply(-impulse, p.arm_a);
    body_b.Apply(impulse, p.arm_b);
  }

 private:
  /** Returns the maximum speed at which the surfaces may approach each other at a point. If it is
   *  negative, they must separate at least with its absolute value. */
  template <class Step>
  static Number Allowed(Number gap, const Step& step, bool push) {
    const Number overlapping =
        push ? Larger(Number(step.push_rate) * gap, Number(-step.push_speed)) : Number(0);
    return Select(gap > Number(0), gap / Number(step.substep), overlapping);
  }

  /** Changes the impulses of all points by the same amount, so that the mean velocity of the points
   *  becomes 0. Without this, a body with an even load would tilt, because the points are solved
   *  one after the other. */
  void PressTogether(Motion<Number>& body_a, Motion<Number>& body_b,
                     const std::array<Number, Manifold::kMost>& allowed) {
    Number least = points[0].press, mean(0);
    for (int i = 0; i < count; ++i) {
      least = Smaller(least, points[i].press);
      mean += Dot(Relative(body_a, body_b, points[i]), normal) + allowed[i];
    }
    const Number all(count), share = Number(1) / all;
    const Number change = Larger(-least, -mean * share * mean_mass * share);
    const Vector impulse = normal * (change * all);
    for (int i = 0; i < count; ++i) points[i].press += change;
    body_a.Apply(-impulse, mean_arm_a);
    body_b.Apply(impulse, mean_arm_b);
  }
};

/** The contact of two bodies. */
template <class Real>
struct Contact : ContactCore<Real> {
  using Core = ContactCore<Real>;
  using Core::across, Core::count, Core::friction, Core::mean_arm_a, Core::mean_arm_b;
  using Core::normal, Core::points;
  using typename Core::Point;
  using typename Core::Vector;

  /** The approach of two surfaces at a point, for the restitution. */
  struct Approaching {
    Real speed;    // relative velocity along the normal before a substep [m/s]
    Real elapsed;  // time of the impact, as a fraction of the step
  };

  uint32_t a, b;  // rows of the bodies; kImmovable if immovable
  Real restitution;
  Real rolling;                // rolling friction: torque per normal force [m]
  Real roll[2], roll_mass[2];  // torque impulses about across[] [N m s], effective inertia
  Real spinning;               // friction against spin: torque per normal force [m]
  Real spin, spin_mass;        // torque impulse about the normal [N m s], effective inertia
  std::array<Approaching, Manifold::kMost> approaching;  // one per point
  Vector spent;  // impulses of points that have bounced in this step, on body b [N s]

  /** Returns whether only the functions of ContactCore correct this contact. */
  bool IsPlain() const { return !(restitution > 0 || rolling > 0 || spinning > 0); }

  /** Computes the directions perpendicular to the normal, and the means of the arms. */
  void FindDirections() {
    // Two unit vectors perpendicular to the normal (Duff et al. 2017).
    const Real sign = normal.z < 0 ? Real(-1) : Real(1);
    const Real s = -1 / (sign + normal.z), t = normal.x * normal.y * s;
    across[0] = {1 + sign * normal.x * normal.x * s, sign * t, -sign * normal.x};
    across[1] = {t, sign + normal.y * normal.y * s, -normal.y};
    mean_arm_a = mean_arm_b = {};
    for (int i = 0; i < count; ++i) {
      mean_arm_a += points[i].arm_a * (Real(1) / Real(count));
      mean_arm_b += points[i].arm_b * (Real(1) / Real(count));
    }
  }

  /** Computes all effective masses and moments of inertia. */
  void FindMasses(const Motion<Real>& body_a, const Motion<Real>& body_b) {
    Core::FindMasses(body_a, body_b);
    const auto moment = [&](const Vector& axis) {
      return Core::Inverse(Dot(body_a.inverse_inertia * axis, axis) +
                           Dot(body_b.inverse_inertia * axis, axis));
    };
    for (int k = 0; rolling > 0 && k < 2; ++k) roll_mass[k] = moment(across[k]);
    if (spinning > 0) spin_mass = moment(normal);
  }

  /** Returns the impulse of this step on body b, at all points [N s]. */
  Vector TotalImpulse() const {
    Vector total = spent;
    for (int i = 0; i < count; ++i) total += Core::Impulse(points[i]);
    return total;
  }

  /** Records the velocities before a substep, for the restitution. */
  void Approach(const Motion<Real>& body_a, const Motion<Real>& body_b,
                const SolverStep<Real>& step, uint32_t index) {
    for (int i = 0; i < count; ++i) {
      const Point& p = points[i];
      Approaching& to = approaching[i];
      to.speed = Dot(Core::Relative(body_a, body_b, p), normal);
      const Real gap = Core::Separation(body_a, body_b, p), way = -to.speed * step.substep;
      const Real part = gap > 0 && way > 0 ? std::min(Real(1), gap / way) : Real(0);
      to.elapsed = (Real(index) + part) / Real(step.substeps);
    }
  }

  /** Changes the impulses so that the surfaces neither approach nor slip. With `push`, also
   *  corrects overlaps. */
  void Solve(Motion<Real>& body_a, Motion<Real>& body_b, const SolverStep<Real>& step, bool push) {
    Core::Rub(body_a, body_b);
    if (rolling > 0) Roll(body_a, body_b);
    if (spinning > 0) Spin(body_a, body_b);
    Core::PressApart(body_a, body_b, step, push);
  }

  /** Changes the impulses so that points that have collided separate with `restitution` times their
   *  approach speed. The velocities of a step belong to the middle of the step. `late` corrects for
   *  the forces between the middle and the time of the impact. */
  void Restitute(Motion<Real>& body_a, Motion<Real>& body_b, const SolverStep<Real>& step) {
    const Real pull = Dot(body_b.push - body_a.push, normal) * step.dt;
    for (int i = 0; i < count; ++i) {
      Point& p = points[i];
      if (!HasBounced(i, step)) continue;
      const Real apart = Dot(Core::Relative(body_a, body_b, p), normal);
      const Real late =
          (1 + restitution) * (Real(0.5) - approaching[i].elapsed) * std::min(Real(0), pull);
      const Real wanted = std::max(Real(0), -restitution * approaching[i].speed + late);
      Core::Press(body_a, body_b, p, std::max(p.press, p.press + p.mass * (wanted - apart)));
    }
    // The surfaces separate, so later substeps and the next step must not start with these
    // impulses.
    for (int i = 0; i < count; ++i) {
      Point& p = points[i];
      if (!HasBounced(i, step)) continue;
      spent += Core::Impulse(p);
      p.press = p.rub[0] = p.rub[1] = roll[0] = roll[1] = spin = 0;
    }
  }

 private:
  bool HasBounced(int point, const SolverStep<Real>& step) const {
    return approaching[point].speed <= -step.restitution_speed && points[point].press != 0;
  }

  /** Changes the torques so that the bodies do not roll, as far as rolling friction permits. */
  void Roll(Motion<Real>& body_a, Motion<Real>& body_b) {
    Real limit = 0;
    for (int i = 0; i < count; ++i) limit += rolling * points[i].press;
    const Vector turns = body_b.spin - body_a.spin;
    Real to[2];
    for (int k = 0; k < 2; ++k) to[k] = roll[k] - roll_mass[k] * Dot(turns, across[k]);
    const Real square = to[0] * to[0] + to[1] * to[1];
    const Real scale = square > limit * limit ? limit / std::sqrt(square) : Real(1);
    Vector torque;
    for (int k = 0; k < 2; ++k) {
      torque += across[k] * (to[k] * scale - roll[k]);
      roll[k] = to[k] * scale;
    }
    body_a.spin += body_a.inverse_inertia * -torque;
    body_b.spin += body_b.inverse_inertia * torque;
  }

  /** Changes the torque about the normal so that the bodies do not spin against each other, as far
   * as the friction against spin permits. */
  void Spin(Motion<Real>& body_a, Motion<Real>& body_b) {
    Real limit = 0;
    for (int i = 0; i < count; ++i) limit += spinning * points[i].press;
    const Real wanted = spin - spin_mass * Dot(body_b.spin - body_a.spin, normal);
    const Real to = std::max(-limit, std::min(limit, wanted));
    const Vector torque = normal * (to - spin);
    spin = to;
    body_a.spin += body_a.inverse_inertia * -torque;
    body_b.spin += body_b.inverse_inertia * torque;
  }
};

}  // namespace vesper::rigid
