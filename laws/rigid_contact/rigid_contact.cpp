// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "body.hpp"
#include "broad_phase.hpp"
#include "colours.hpp"
#include "contact_memory.hpp"
#include "joint_solver.hpp"
#include "manifold.hpp"
#include "solver.hpp"
#include "vesper/law.hpp"

namespace {

using namespace vesper;
using namespace vesper::rigid;

// Rows, pairs and contacts per chunk of a thread.
constexpr uint64_t kBodyGrain = 256, kPairGrain = 64, kContactGrain = 128;
// Number of contacts of a colour above which several threads are faster than one.
constexpr uint32_t kManyContacts = 512;
// Separation up to which two shapes form a contact, as a fraction of their thickness.
constexpr double kSlop = 0.02;
// Contacts yield like damped springs: kOscillations oscillations per step, at kDamping times the
// critical damping.
constexpr double kOscillations = 0.5, kDamping = 10;
// Distance up to which a contact point is identified with one of the last step, as a fraction of
// the thickness.
constexpr double kNear = 0.2;

/** Motion of rigid bodies that touch: their shapes resist overlap, rub and bounce. */
template <class Real>
struct RigidContact {
  using Vector3 = Vec3<Real>;
  static constexpr auto kName = "rigid_contact", kVersion = "1.0.0";
  static constexpr auto kDoc = "Moves rigid bodies, whose shapes touch, rub and bounce.";
  static constexpr auto kPhase = Phase::kIntegrate;
  static constexpr uint32_t kFirstStage = 1;

  Parameter substeps{"substeps", "Parts of a step in which contacts are solved.", units::one, 4, 1,
                     256};
  Parameter friction{"friction", "Friction of bodies without one of their own.", units::one, 0.5, 0,
                     100};
  Parameter restitution{
      "restitution", "Restitution of bodies without one of their own.", units::one, 0, 0, 1};
  Parameter restitution_speed{"restitutionSpeed",
                              "Speed below which nothing bounces.",
                              units::metre_per_second,
                              0.5,
                              0,
                              1e6};
  Parameter push_speed{
      "pushSpeed", "Greatest speed at which overlaps are undone.", units::metre_per_second, 3, 0,
      1e6};

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vector3> force{"externalForce", "body", units::newton};
  OptionalRead<Vector3> torque{"torque", "body", units::newton_metre};
  OptionalRead<Vector3> inertia{"inertia", "body", units::kilogram_metre_squared};
  ReadWrite<Vector3> velocity{"velocity", "body", units::metre_per_second};
  ReadWrite<Vector3> position{"position", "body", units::metre};
  ReadWrite<Vector3> spin{"angularVelocity", "body", units::radian_per_second};
  ReadWrite<std::array<Real, 4>> orientation{"orientation", "body", units::one};
  OptionalWrite<Vector3> acceleration{"acceleration", "body", units::metre_per_second_squared};
  Read<int32_t> shape{"shape", "body", units::one};
  Read<Vec3<double>> size{"size", "body", units::metre};
  OptionalRead<int32_t> carrier{"carrier", "body", units::one};
  OptionalRead<Real> own_friction{"friction", "body", units::one};
  OptionalRead<Real> own_restitution{"restitution", "body", units::one};
  OptionalRead<Vector3> scenery_position{"sceneryPosition", "scenery", units::metre};
  OptionalRead<std::array<Real, 4>> scenery_orientation{"sceneryOrientation", "scenery",
                                                        units::one};
  OptionalRead<int32_t> scenery_shape{"sceneryShape", "scenery", units::one};
  OptionalRead<Vec3<double>> scenery_size{"scenerySize", "scenery", units::metre};
  OptionalRead<int32_t> scenery_carrier{"sceneryCarrier", "scenery", units::one};
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
  // The contacts of the last step, see contact_memory.hpp.
  Scratch<SlotPartners> partners{"partners", "body", units::one};
  Scratch<SlotVectors<Real>> places{"places", "body", units::metre};
  Scratch<SlotVectors<Real>> impulses{"impulses", "body", kImpulseUnit};

  auto Parameters() {
    return std::tie(substeps, friction, restitution, restitution_speed, push_speed);
  }
  auto Properties() {
    return std::tie(mass, force, torque, inertia, velocity, position, spin, orientation,
                    acceleration, shape, size, carrier, own_friction, own_restitution,
                    scenery_position, scenery_orientation, scenery_shape, scenery_size,
                    scenery_carrier, joined, joint_type, anchor, axis, angle_limits, travel_limits,
                    motor_speed, motor_torque, drive_speed, drive_force, breaking_force,
                    other_anchor, other_turn, joint_force, joint_torque, joint_angle, joint_travel,
                    broken, partners, places, impulses);
  }

  void Advance(const Step& step) {
    const auto count = static_cast<uint32_t>(std::lround(substeps.value()));
    const auto dt = static_cast<Real>(step.dt);
    const SolverStep<Real> solver = SolverFor(dt, count);
    Gather(step);
    GatherJoints(step.dt);
    FindContacts(step);
    Solve(step, solver);
    Remember();
    ScatterJoints(step.dt);
    Scatter(step);
  }

 private:
  /** Returns the constants of a step; the section Limits of README.md explains the contact springs.
   *  */
  SolverStep<Real> SolverFor(Real dt, uint32_t count) const {
    constexpr double kTurn = 2 * 3.14159265358979323846;
    const double substep = double{dt} / count, angle = kTurn * kOscillations / count;
    const double damped = 2 * kDamping + angle, stiff = angle * damped;
    return {dt,
            static_cast<Real>(substep),
            static_cast<Real>(angle / (substep * damped)),
            static_cast<Real>(stiff / (1 + stiff)),
            static_cast<Real>(1 / (1 + stiff) / count),
            Real(push_speed),
            Real(restitution_speed),
            count};
  }

  static constexpr vesper_unit kImpulseUnit = VESPER_UNIT_INIT(1, 1, -1, 0, 0, 0, 0, 1.0, "N*s");

  uint64_t rows() const { return mass.size(); }
  bool Movable(uint32_t body) const { return bodies_[body].translates || bodies_[body].rotates; }

  // --- reading the columns

  void Gather(const Step& step) {
    const uint64_t scenery = scenery_shape.present() ? scenery_shape.size() : 0;
    bodies_.resize(rows());
    motions_.resize(rows());
    shapes_.resize(rows() + scenery);
    bounds_.resize(rows() + scenery);
    step.ParallelFor(rows(), kBodyGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) GatherBody(i, step.dt);
    });
    for (uint64_t i = 0; i < scenery; ++i) GatherScenery(i);
  }

  void GatherBody(uint64_t i, double dt) {
    Body& body = bodies_[i];
    Motion<Real>& motion = motions_[i];
    const Vector at = Wide(position[i]);
    body.rotation = Quaternion::Load(orientation[i]);
    body.broken = !IsFinite(i);
    if (body.broken) {
      body.translates = body.rotates = body.gyrates = false;
      shapes_[i] = {};
      motion = {};
      return;
    }
    body.rotation = body.rotation.Normalised();
    const double weight = mass[i];
    const bool carried = carrier.present() && carrier[i] >= 0;
    const int32_t code = weight > 0 && shape[i] == int32_t(ShapeCode::kPlane)
                             ? int32_t(ShapeCode::kBox)  // a plane of the columns is a thin box
                             : shape[i];
    shapes_[i] = carried ? Shape{} : Shape::Of(code, size[i], at, body.rotation);
    Vector moments = inertia.present() ? Wide(inertia[i]) : Vector{};
    if (moments == Vector{}) moments = shapes_[i].Moments(weight);
    body.moments = {moments.x, moments.y, moments.z};
    body.turned = {};
    body.renewed = body.jointed = false;
    body.translates = weight > 0;
    body.rotates = moments.x > 0 || moments.y > 0 || moments.z > 0;
    body.gyrates = moments.x > 0 && moments.y > 0 && moments.z > 0 &&
                   !(moments.x == moments.y && moments.y == moments.z);
    motion.inverse_mass = weight > 0 ? static_cast<Real>(1 / weight) : Real(0);
    motion.inverse_inertia = InverseInertia<Real>(body);
    motion.push = force[i] * motion.inverse_mass;
    motion.moved = motion.turned = {};
    motion.velocity = body.translates ? velocity[i] + motion.push * Real(dt) : Vector3{};
    motion.spin = body.rotates ? spin[i] : Vector3{};
    if (body.rotates && torque.present()) {
      motion.spin += motion.inverse_inertia * torque[i] * Real(dt);
    }
    const double bound = shapes_[i].Bound();
    body.speed = Length(Wide(motion.velocity)) + Length(Wide(motion.spin)) * bound;
    Bound(i, Movable(uint32_t(i)), body.speed * dt);
  }

  void GatherScenery(uint64_t i) {
    const uint64_t row = rows() + i;
    const Vector at = Wide(scenery_position[i]);
    const Quaternion q = Quaternion::Load(scenery_orientation[i]);
    const double norm = Dot(q.v, q.v) + q.w * q.w;
    if (!std::isfinite(Dot(at, at) + norm + Dot(scenery_size[i], scenery_size[i]))) {
      throw std::runtime_error("scenery row " + std::to_string(i) +
                               " has a place or size that is not finite");
    }
    const bool carried = scenery_carrier.present() && scenery_carrier[i] >= 0;
    shapes_[row] = carried || !(norm > 0)
                       ? Shape{}
                       : Shape::Of(scenery_shape[i], scenery_size[i], at, q.Normalised());
    Bound(row, false, 0);
  }

  bool IsFinite(uint64_t i) const {
    const auto square = [](const auto& v) { return double(Dot(v, v)); };
    const Quaternion q = Quaternion::Load(orientation[i]);
    const double norm = Dot(q.v, q.v) + q.w * q.w;
    double sum = double{mass[i]} + square(Wide(position[i])) + square(Wide(velocity[i])) +
                 square(Wide(spin[i])) + square(Wide(force[i])) + square(size[i]) + norm;
    if (torque.present()) sum += square(Wide(torque[i]));
    if (inertia.present()) sum += square(Wide(inertia[i]));
    if (own_friction.present()) sum += double{own_friction[i]};
    if (own_restitution.present()) sum += double{own_restitution[i]};
    return std::isfinite(sum) && norm > 0;
  }

  /** Computes the bounding box of a shape, enlarged by the distance `way` that it may move in this
   *  step. */
  void Bound(uint64_t row, bool movable, double way) {
    const Shape& one = shapes_[row];
    Bounds& bounds = bounds_[row];
    if (one.code == ShapeCode::kNone || (one.Thickness() < 0)) {
      shapes_[row].code = ShapeCode::kNone;
      bounds = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, false};
      return;
    }
    const double more = kSlop * one.Thickness() + way;
    const Vector reach{one.Reach({1, 0, 0}) + more, one.Reach({0, 1, 0}) + more,
                       one.Reach({0, 0, 1}) + more};
    bounds = {one.position - reach, one.position + reach, movable};
  }

  // --- joints

  void GatherJoints(double dt) {
    joints_.Reset(joined.present() ? rows() : 0);
    const bool complete = joined.present() && joint_type.present() && anchor.present() &&
                          axis.present() && other_anchor.present() && other_turn.present();
    if (!complete) return;
    for (uint64_t i = 0; i < joined.size(); ++i) GatherJoint(i, dt);
    joints_.Sort();
  }

  void GatherJoint(uint64_t i, double dt) {
    const auto type = static_cast<JointType>(joint_type[i]);
    const auto [a, b] = joined[i];
    if (type < JointType::kFixed || type > JointType::kDistance || a == b) return;
    if (broken.present() && broken[i] != 0) return;
    if (bodies_[a].broken || bodies_[b].broken || (!Movable(a) && !Movable(b))) return;
    Joint<Real> joint;
    joint.row_a = a;
    joint.row_b = b;
    joint.a = BodyOf(a);
    joint.b = BodyOf(b);
    joint.settings = SettingsOf(i, type, PoseOf(a), PoseOf(b));
    const Vector load = joint_force.present() ? Wide(joint_force[i]) : Vector{};
    const Vector moment = joint_torque.present() ? Wide(joint_torque[i]) : Vector{};
    joint.StartWith(load * dt, moment * dt);
    for (const uint32_t body : {a, b}) bodies_[body].jointed = true;
    joints_.Add(joint, i);
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
    const auto number = [&](const auto& column) {
      return column.present() ? double{column[i]} : 0;
    };
    const auto limit = [&](const auto& column, int side) {
      return column.present() ? double{column[i][side]} : 0;
    };
    settings.angle_low = limit(angle_limits, 0);
    settings.angle_high = limit(angle_limits, 1);
    settings.travel_low = limit(travel_limits, 0);
    settings.travel_high = limit(travel_limits, 1);
    settings.motor_speed = number(motor_speed);
    settings.motor_torque = number(motor_torque);
    settings.drive_speed = number(drive_speed);
    settings.drive_force = number(drive_force);
    const double sum = Dot(settings.anchor_a, settings.anchor_a) + length +
                       Dot(settings.anchor_b, settings.anchor_b) + settings.rest.w +
                       settings.angle_low + settings.angle_high + settings.travel_low +
                       settings.travel_high + settings.motor_speed + settings.motor_torque +
                       settings.drive_speed + settings.drive_force + number(breaking_force);
    if (!std::isfinite(sum)) {
      throw std::runtime_error("joint row " + std::to_string(i) +
                               " has values that are not finite");
    }
    return settings;
  }

  /** Stores the present anchor and rotation of the second body as those at which the joint is at
   *  rest. */
  void Join(uint64_t i, JointType type, const Pose& a, const Pose& b) {
    const Quaternion of_a = a.rotation.Normalised(), of_b = b.rotation.Normalised();
    if (type != JointType::kDistance && other_anchor[i] == Vector3{}) {
      const Vector at = a.at + of_a.Rotate(Wide(anchor[i]));
      other_anchor[i] = Narrow<Real>(of_b.Inverse().Rotate(at - b.at));
    }
    other_turn[i] = (of_a.Inverse() * of_b).template Stored<Real>();
  }

  Pose PoseOf(uint32_t body) const {
    return {Wide(position[body]) + Wide(motions_[body].moved), bodies_[body].rotation};
  }

  void ScatterJoints(double dt) {
    for (size_t k = 0; k < joints_.count(); ++k) {
      const uint64_t i = joints_.row(k);
      const Joint<Real>& joint = joints_[k];
      const Vector load = joint.Impulse() * (1 / dt);
      if (joint_force.present()) joint_force[i] = Narrow<Real>(load);
      if (joint_torque.present()) joint_torque[i] = Narrow<Real>(joint.Turn() * (1 / dt));
      if (joint_angle.present()) joint_angle[i] = static_cast<Real>(joint.angle());
      if (joint_travel.present()) joint_travel[i] = static_cast<Real>(joint.travel());
      const double most = breaking_force.present() ? double{breaking_force[i]} : 0;
      if (most > 0 && broken.present() && Dot(load, load) > most * most) {
        broken[i] = 1;
        if (joint_force.present()) joint_force[i] = {};
        if (joint_torque.present()) joint_torque[i] = {};
      }
    }
  }

  // --- contacts

  /** A pair of shapes that touch, and the body that stores its impulses. */
  struct Touch {
    uint32_t a, b;  // shapes
    bool a_stores;

    uint32_t owner() const { return a_stores ? a : b; }
    uint32_t partner() const { return a_stores ? b : a; }
  };

  ContactMemory<Real> MemoryOf(const Touch& touch) const {
    const uint32_t body = touch.owner();
    return {partners[body], places[body], impulses[body], touch.a_stores};
  }

  void FindContacts(const Step& step) {
    const std::vector<Pair>& pairs = broad_phase_.Find(bounds_);
    manifolds_.resize(pairs.size());
    step.ParallelFor(pairs.size(), kPairGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        const Pair pair = pairs[i];
        manifolds_[i] = Collide(shapes_[pair.a], shapes_[pair.b], Margin(pair.a, pair.b, step.dt));
      }
    });
    touches_.clear();
    contacts_.clear();
    for (size_t i = 0; i < pairs.size(); ++i) {
      if (manifolds_[i].count > 0 && !joints_.AreJoined(pairs[i]))
        AddContact(pairs[i], manifolds_[i]);
    }
    step.ParallelFor(contacts_.size(), kContactGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) PrepareContact(i);
    });
    colours_.Choose(contacts_, rows());
  }

  double Margin(uint32_t a, uint32_t b, double dt) const {
    const double thickness = std::min(shapes_[a].Thickness(), shapes_[b].Thickness());
    const double speed = SpeedOf(a) + SpeedOf(b);
    const bool plane = shapes_[a].code == ShapeCode::kPlane || shapes_[b].code == ShapeCode::kPlane;
    // Half the thickness is the limit: with a larger distance, bodies that only pass each other
    // would get contacts.
    return kSlop * thickness + (plane ? speed * dt : std::min(speed * dt, 0.5 * thickness));
  }
  double SpeedOf(uint32_t shape_row) const {
    return shape_row < rows() ? bodies_[shape_row].speed : 0;
  }
  uint32_t BodyOf(uint32_t shape_row) const {
    return shape_row < rows() && Movable(shape_row) ? shape_row : kImmovable;
  }

  void AddContact(const Pair& pair, const Manifold& manifold) {
    Contact<Real>& contact = contacts_.emplace_back();
    contact.a = BodyOf(pair.a);
    contact.b = BodyOf(pair.b);
    contact.normal = Narrow<Real>(manifold.normal);
    contact.count = manifold.count;
    const double rub_a = FrictionOf(pair.a), rub_b = FrictionOf(pair.b);
    contact.friction = static_cast<Real>(std::sqrt(rub_a * rub_b));
    contact.restitution = static_cast<Real>(std::max(RestitutionOf(pair.a), RestitutionOf(pair.b)));
    for (int i = 0; i < manifold.count; ++i) {
      const ContactPoint& from = manifold.points[i];
      auto& point = contact.points[i];
      point = {};
      point.arm_a = Narrow<Real>(from.at - shapes_[pair.a].position);
      point.arm_b = Narrow<Real>(from.at - shapes_[pair.b].position);
      point.separation = static_cast<Real>(from.separation);
    }
    // The smaller body stores the contact, because few larger bodies fit around it.
    const bool a_stores =
        contact.b == kImmovable ||
        (contact.a != kImmovable && shapes_[pair.a].Bound() <= shapes_[pair.b].Bound());
    touches_.push_back({pair.a, pair.b, a_stores});
  }

  double FrictionOf(uint32_t row) const {
    return row < rows() && own_friction.present() ? std::max(0.0, double{own_friction[row]})
                                                  : friction.value();
  }
  double RestitutionOf(uint32_t row) const {
    return row < rows() && own_restitution.present()
               ? std::clamp(double{own_restitution[row]}, 0.0, 1.0)
               : restitution.value();
  }

  const Motion<Real>& MotionOf(uint32_t body) const {
    return body == kImmovable ? still_ : motions_[body];
  }

  void PrepareContact(uint64_t i) {
    Contact<Real>& contact = contacts_[i];
    const Touch& touch = touches_[i];
    contact.Prepare(MotionOf(contact.a), MotionOf(contact.b));
    const double reach =
        kNear * std::min(shapes_[touch.a].Thickness(), shapes_[touch.b].Thickness());
    MemoryOf(touch).Recall(contact, touch.partner(), static_cast<Real>(reach));
  }

  // --- solution

  void Solve(const Step& step, const SolverStep<Real>& solver) {
    bool bounces = false;
    for (const Contact<Real>& contact : contacts_) bounces = bounces || contact.restitution > 0;
    const auto pose = [&](uint32_t body) { return PoseOf(body); };
    joints_.Refresh(motions_, pose);
    for (uint32_t k = 0; k < solver.substeps; ++k) {
      if (bounces) {
        step.ParallelFor(contacts_.size(), kContactGrain, [&](uint64_t begin, uint64_t end) {
          for (uint64_t i = begin; i < end; ++i) {
            Contact<Real>& contact = contacts_[i];
            if (contact.restitution == 0) continue;
            contact.Approach(MotionOf(contact.a), MotionOf(contact.b), solver, k);
          }
        });
      }
      if (k == 0) {
        ForEachContact(step, [](auto& contact, auto& a, auto& b) { contact.WarmStart(a, b); });
        joints_.WarmStart(motions_);
      }
      joints_.Solve(motions_, solver, true);
      ForEachContact(step,
                     [&](auto& contact, auto& a, auto& b) { contact.Solve(a, b, solver, true); });
      Drift(step, solver.substep);
      joints_.Refresh(motions_, pose);
      ForEachContact(step,
                     [&](auto& contact, auto& a, auto& b) { contact.Solve(a, b, solver, false); });
      joints_.Solve(motions_, solver, false);
      if (!bounces) continue;
      ForEachContact(step, [&](auto& contact, auto& a, auto& b) {
        if (contact.restitution > 0) contact.Restitute(a, b, solver);
      });
    }
  }

  /** Calls action(contact, motion a, motion b) for all contacts, colour by colour. */
  template <class Action>
  void ForEachContact(const Step& step, Action&& action) {
    const auto order = colours_.order();
    const auto run = [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        Contact<Real>& contact = contacts_[order[i]];
        Motion<Real> still_a, still_b;
        action(contact, contact.a == kImmovable ? still_a : motions_[contact.a],
               contact.b == kImmovable ? still_b : motions_[contact.b]);
      }
    };
    for (uint32_t colour = 0; colour < Colours::kMost; ++colour) {
      const uint32_t first = colours_.first(colour), end = colours_.first(colour + 1);
      if (end - first < kManyContacts || colour == Colours::kMost - 1) {
        run(first, end);
      } else {
        step.ParallelFor(end - first, kContactGrain,
                         [&](uint64_t from, uint64_t to) { run(first + from, first + to); });
      }
    }
  }

  /** Moves and rotates all bodies for a substep. */
  void Drift(const Step& step, Real h) {
    step.ParallelFor(rows(), kBodyGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        Motion<Real>& motion = motions_[i];
        motion.moved += motion.velocity * h;
        motion.turned += motion.spin * h;
        if (bodies_[i].rotates) Turn(bodies_[i], motion, double{h});
      }
    });
    step.ParallelFor(contacts_.size(), kContactGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        Contact<Real>& contact = contacts_[i];
        if (IsRenewed(contact.a) || IsRenewed(contact.b)) {
          contact.Prepare(MotionOf(contact.a), MotionOf(contact.b));
        }
      }
    });
  }
  bool IsRenewed(uint32_t body) const { return body != kImmovable && bodies_[body].renewed; }

  // --- writing the columns

  void Remember() {
    used_.assign(rows(), 0);
    for (size_t i = 0; i < contacts_.size(); ++i) {
      const Touch& touch = touches_[i];
      MemoryOf(touch).Store(contacts_[i], touch.partner(), used_[touch.owner()]);
    }
    for (uint64_t i = 0; i < rows(); ++i) {
      for (uint32_t slot = used_[i]; slot < kSlots && partners[i][slot] != 0; ++slot) {
        partners[i][slot] = 0;
      }
    }
  }

  void Scatter(const Step& step) {
    const Real per_time = 1 / static_cast<Real>(step.dt);
    step.ParallelFor(rows(), kBodyGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        const Body& body = bodies_[i];
        const Motion<Real>& motion = motions_[i];
        if (body.broken) velocity[i].x = std::numeric_limits<Real>::quiet_NaN();
        if (acceleration.present()) {
          acceleration[i] =
              body.translates ? (motion.velocity - velocity[i]) * per_time : Vector3{};
        }
        if (body.translates) {
          velocity[i] = motion.velocity;
          position[i] += motion.moved;
        }
        if (body.rotates) {
          spin[i] = motion.spin;
          orientation[i] = body.rotation.template Stored<Real>();
        }
      }
    });
  }

  const Motion<Real> still_{};
  std::vector<Body> bodies_;             // (rows)
  std::vector<Motion<Real>> motions_;    // (rows)
  std::vector<Shape> shapes_;            // (rows + scenery)
  std::vector<Bounds> bounds_;           // (rows + scenery)
  std::vector<Manifold> manifolds_;      // (pairs)
  std::vector<Touch> touches_;           // (contacts)
  std::vector<Contact<Real>> contacts_;  // (contacts)
  std::vector<uint32_t> used_;           // (rows) number of used slots
  JointSolver<Real> joints_;
  BroadPhase broad_phase_;
  Colours colours_;
};

}  // namespace

VESPER_LAW_LIBRARY("rigid_contact", RigidContact)
