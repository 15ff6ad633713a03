// SPDX-License-Identifier: Apache-2.0
// The law rigid_contact.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "batches.hpp"
#include "body.hpp"
#include "broad_phase.hpp"
#include "collisions.hpp"
#include "colours.hpp"
#include "contact_columns.hpp"
#include "contact_memory.hpp"
#include "gear_columns.hpp"
#include "joint_columns.hpp"
#include "manifold.hpp"
#include "parts.hpp"
#include "sleep.hpp"
#include "solver.hpp"
#include "substances.hpp"
#include "vesper/law.hpp"

namespace vesper::rigid {

// Number of rows (kBodyGrain) and of contacts (kContactGrain) per chunk of a thread.
inline constexpr uint64_t kBodyGrain = 256, kContactGrain = 128;
// Number of batches of contacts per chunk of a thread.
inline constexpr uint64_t kBatchGrain = 32;
// Number of contacts of a colour above which several threads are faster than one.
inline constexpr uint32_t kManyContacts = 512;
// Separation up to which two shapes form a contact, as a fraction of their thickness.
inline constexpr double kSlop = 0.02;
// Distance up to which a contact point is identified with a point of the last step, as a fraction
// of the thickness.
inline constexpr double kNear = 0.2;

/** Motion of rigid bodies that touch. Their shapes resist overlap, rub and bounce. */
template <class Real>
struct RigidContact {
  using Vector3 = Vec3<Real>;
  static constexpr auto kName = "rigid_contact", kVersion = "1.3.0";
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
  Parameter rolling_friction{
      "rollingFriction",
      "Lever arm of the rolling friction of bodies without one of their own.",
      units::metre,
      0,
      0,
      1e6};
  Parameter spin_friction{"spinFriction",
                          "Lever arm of the friction against spin of bodies without one of their "
                          "own.",
                          units::metre,
                          0,
                          0,
                          1e6};
  Parameter sleep_time{
      "sleepTime", "Time at rest after which bodies sleep; 0: never.", units::second, 0, 0, 1e6};
  Parameter sleep_speed{
      "sleepSpeed", "Speed below which a body is at rest.", units::metre_per_second, 0.03, 0, 1e6};

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
  OptionalRead<Vector3> scenery_position{"sceneryPosition", "scenery", units::metre};
  OptionalRead<std::array<Real, 4>> scenery_orientation{"sceneryOrientation", "scenery",
                                                        units::one};
  OptionalRead<int32_t> scenery_shape{"sceneryShape", "scenery", units::one};
  OptionalRead<Vec3<double>> scenery_size{"scenerySize", "scenery", units::metre};
  OptionalRead<int32_t> scenery_carrier{"sceneryCarrier", "scenery", units::one};
  JointColumns<Real> joint_columns;
  GearColumns<Real> gear_columns;
  ContactColumns<Real> contact_columns;
  MeshColumns mesh_columns;
  Substances<Real> substances;
  // The contacts of the last step, see contact_memory.hpp.
  Scratch<SlotPartners> partners{"partners", "body", units::one};
  Scratch<SlotVectors<Real>> places{"places", "body", units::metre};
  Scratch<SlotVectors<Real>> impulses{"impulses", "body", kImpulseUnit};
  SleepColumns<Real> sleep_columns;

  auto Parameters() {
    return std::tie(substeps, friction, restitution, restitution_speed, push_speed,
                    rolling_friction, sleep_time, sleep_speed, spin_friction);
  }
  auto Properties() {
    return std::tuple_cat(std::tie(mass, force, torque, inertia, velocity, position, spin,
                                   orientation, acceleration, shape, size, carrier),
                          contact_columns.FirstProperties(),
                          std::tie(scenery_position, scenery_orientation, scenery_shape,
                                   scenery_size, scenery_carrier),
                          joint_columns.Properties(), std::tie(partners, places, impulses),
                          contact_columns.LaterProperties(), mesh_columns.Properties(),
                          joint_columns.LaterProperties(), substances.Properties(),
                          gear_columns.Properties(), sleep_columns.Properties(),
                          contact_columns.LastProperties(), substances.LastProperties());
  }

  void Advance(const Step& step) {
    const auto count = static_cast<uint32_t>(std::lround(substeps.value()));
    const auto dt = static_cast<Real>(step.dt);
    const auto solver = SolverStep<Real>::Of(dt, count, Real(push_speed), Real(restitution_speed));
    Gather(step);
    joint_columns.Gather(joints_, *this, step.dt);
    gear_columns.Gather(joints_, step.dt);
    FindContacts(step);
    Solve(step, solver);
    Remember();
    if (contact_columns.reaction.present()) ScatterReactions(step);
    joint_columns.Scatter(joints_, *this, step.dt);
    gear_columns.Scatter(joints_, step.dt);
    Scatter(step);
    sleep_.Count(*this, sleep_columns,
                 [&](uint32_t i) { return std::max(SpeedAtEnd(i), MeanSpeed(i, step.dt)); });
  }

  // --- for tests

  /** Returns the number of contacts that the last step solved. */
  size_t solved_contacts() const { return contacts_.size(); }
  /** Returns the number of pairs of shapes whose contact points the last step computed. */
  size_t collided_pairs() const {
    return size_t(std::count_if(pairs().begin(), pairs().end(),
                                [&](const Pair& pair) { return MustCollide(pair); }));
  }

  // --- for the joints and for sleep

  uint64_t rows() const { return mass.size(); }
  size_t shape_count() const { return shapes_.size(); }
  const std::vector<Pair>& pairs() const { return broad_phase_.pairs(); }
  const Parts& parts() const { return parts_; }
  const JointSolver<Real>& joints() const { return joints_; }
  bool Movable(uint32_t body) const { return bodies_[body].translates || bodies_[body].rotates; }
  /** Returns the row of the body to which a shape belongs; rows() or more for scenery. */
  uint32_t BodyOfShape(uint32_t shape) const { return parts_.BodyOf(shape); }
  Vector3 ForceOn(uint32_t body) const { return force[body]; }
  Vector3 TorqueOn(uint32_t body) const { return torque.present() ? torque[body] : Vector3{}; }
  /** Returns the acceleration of the fastest point of a body by a force and a torque [m/s^2]. */
  double AccelerationBy(uint32_t body, const Vector3& push, const Vector3& twist) const {
    const Motion<Real>& motion = motions_[body];
    return Length(Wide(push * motion.inverse_mass)) +
           Length(Wide(motion.inverse_inertia * twist)) * ReachOf(body);
  }
  /** Returns whether two shapes touch in this step and exert forces on each other. */
  bool Touches(const Pair& pair) const {
    if (!MayMeet(pair) || AreJoined(pair)) return false;
    if (contact_columns.IsSensor(pair.a) || contact_columns.IsSensor(pair.b)) return false;
    return Collide(shapes_[pair.a], shapes_[pair.b], Margin(pair.a, pair.b, dt_)).count > 0;
  }
  /** Returns the bounds of a shape without the distance that it may move in this step. */
  Bounds StillBounds(uint32_t shape) const {
    const uint32_t body = parts_.BodyOf(shape);
    return body < rows() && Movable(body) ? BoundsOf(shape, true, 0) : bounds_[shape];
  }
  /** Returns the digest of the parameters and of the substances. */
  uint64_t DigestOfSettings() const {
    Digest digest;
    for (const Parameter* one : {&substeps, &friction, &restitution, &restitution_speed,
                                 &push_speed, &rolling_friction, &sleep_time, &sleep_speed}) {
      digest.Add(one->value());
    }
    if (spin_friction.value() > 0) digest.Add(spin_friction.value());
    return digest.Add(substances.present() ? substances.template DigestOfRows<Digest>() : 0)
        .value();
  }
  /** Returns the digest of the values of a shape, without forces, and without the pose of a part.
   *  Without `moves`, the velocities count as 0. */
  uint64_t DigestOfShape(uint32_t shape, bool moves) const {
    if (shape >= rows()) return DigestOfScenery(shape - rows());
    const uint64_t i = shape;
    Digest digest;
    digest.Add(i).Add(double{mass[i]}).Add(uint64_t(uint32_t(this->shape[i]))).Add(size[i]);
    if (inertia.present()) digest.Add(Wide(inertia[i]));
    if (carrier.present()) digest.Add(uint64_t(uint32_t(carrier[i])));
    if (parts_.BodyOf(shape) == shape) {
      digest.Add(Wide(position[i])).Add(Quaternion::Load(orientation[i]));
    }
    digest.Add(moves ? Wide(velocity[i]) : Vector{}).Add(moves ? Wide(spin[i]) : Vector{});
    contact_columns.AddTo(digest, i);
    digest.Add(substances.present() ? uint64_t(uint32_t(substances.CodeOf(shape))) : 0);
    return digest.Add(DigestOfMesh(mesh_columns.mesh, i)).value();
  }

  bool IsBroken(uint32_t body) const { return bodies_[body].broken; }
  void MarkJointed(uint32_t body) { bodies_[body].jointed = true; }
  uint32_t BodyOf(uint32_t row) const { return row < rows() && Movable(row) ? row : kImmovable; }
  const Motion<Real>& MotionOf(uint32_t body) const {
    return body == kImmovable ? still_ : motions_[body];
  }
  /** Returns the velocities of a body at the start of the step. */
  Motion<Real> StoredMotion(uint32_t body) const {
    Motion<Real> motion;
    if (bodies_[body].translates) motion.velocity = velocity[body];
    if (bodies_[body].rotates) motion.spin = spin[body];
    return motion;
  }
  Pose PoseOf(uint32_t body) const {
    return {Wide(position[body]) + Wide(motions_[body].moved), bodies_[body].rotation};
  }

 private:
  static constexpr vesper_unit kImpulseUnit = VESPER_UNIT_INIT(1, 1, -1, 0, 0, 0, 0, 1.0, "N*s");

  // --- reading the columns

  void Gather(const Step& step) {
    dt_ = step.dt;
    const uint64_t scenery = scenery_shape.present() ? scenery_shape.size() : 0;
    forms_.Update(mesh_columns.ranges, mesh_columns.points, mesh_columns.indices);
    if (substances.present()) substances.Gather();
    bodies_.resize(rows());
    motions_.resize(rows());
    shapes_.resize(rows() + scenery);
    bounds_.resize(rows() + scenery);
    surfaces_.assign(mesh_columns.ranges.present() ? shapes_.size() : 0, nullptr);
    FindParts();
    step.ParallelFor(rows(), kBodyGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) GatherBody(i, step.dt);
    });
    for (const Part& part : parts_.all()) GatherPart(part, step.dt);
    for (uint64_t i = 0; i < scenery; ++i) GatherScenery(i);
    if (!surfaces_.empty()) GatherSurfaces();
  }

  /** Finds the attached shapes that are parts of bodies, with their poses relative to the
   * bodies. */
  void FindParts() {
    parts_.Reset(rows());
    if (!contact_columns.part.present() || !carrier.present()) return;
    for (uint32_t i = 0; i < rows(); ++i) {
      const int32_t body = carrier[i];
      if (contact_columns.part[i] == 0 || body < 0 || uint64_t(body) >= rows()) continue;
      if (!IsFinite(i) || !IsFinite(uint64_t(body))) continue;
      const Shape one = Shape::Of(shape[i], size[i], Wide(position[i]),
                                  Quaternion::Load(orientation[i]).Normalised(), HullOf(i));
      parts_.Add(i, uint32_t(body), one, Quaternion::Load(orientation[i]).Normalised(),
                 Wide(position[body]), Quaternion::Load(orientation[body]).Normalised());
    }
    parts_.AddBodies(
        [&](uint32_t body) { return Shape::Of(shape[body], size[body], {}, {}, HullOf(body)); });
  }

  const Polytope* HullOf(uint64_t i) const {
    Form* form = mesh_columns.mesh.present() ? forms_.Find(mesh_columns.mesh[i]) : nullptr;
    return form == nullptr ? nullptr : form->hull();
  }

  void GatherBody(uint64_t i, double dt) {
    Body& body = bodies_[i];
    Motion<Real>& motion = motions_[i];
    const Vector at = Wide(position[i]);
    body.rotation = Quaternion::Load(orientation[i]);
    body.broken = !IsFinite(i);
    if (body.broken) {
      body.translates = body.rotates = body.gyrates = false;
      body.reach = 0;
      shapes_[i] = {};
      motion = {};
      return;
    }
    body.rotation = body.rotation.Normalised();
    const double weight = mass[i];
    const bool carried = carrier.present() && carrier[i] >= 0;
    const int32_t code = weight > 0 && shape[i] == int32_t(ShapeCode::kPlane)
                             ? int32_t(ShapeCode::kBox)  // a plane in the columns is a thin box
                             : shape[i];
    shapes_[i] = carried ? Shape{} : Shape::Of(code, size[i], at, body.rotation, HullOf(i));
    Vector moments = inertia.present() ? Wide(inertia[i]) : Vector{};
    if (moments == Vector{}) {
      const Vector* of_parts = parts_.MomentsOf(uint32_t(i));
      moments = of_parts != nullptr ? *of_parts * weight : shapes_[i].Moments(weight);
    }
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
    body.reach = shapes_[i].Bound();
    body.speed = Length(Wide(motion.velocity)) + Length(Wide(motion.spin)) * body.reach;
    Bound(i, Movable(uint32_t(i)), body.speed * dt);
  }

  void GatherPart(const Part& part, double dt) {
    Body& body = bodies_[part.body];
    const Motion<Real>& motion = motions_[part.body];
    shapes_[part.row] = part.shape;
    const double reach = Length(part.offset) + part.shape.Bound();
    body.reach = std::max(body.reach, reach);
    bodies_[part.row].speed =
        body.broken ? 0 : Length(Wide(motion.velocity)) + Length(Wide(motion.spin)) * reach;
    Bound(part.row, Movable(part.body), bodies_[part.row].speed * dt);
  }

  /** Replaces the hulls of immovable meshes by their triangles. */
  void GatherSurfaces() {
    const auto form = [&](const auto& column, uint64_t i) {
      return column.present() ? forms_.Find(column[i]) : nullptr;
    };
    for (uint64_t i = 0; i < rows(); ++i) {
      if (shape[i] != int32_t(ShapeCode::kMesh) || Movable(uint32_t(i)) || bodies_[i].broken ||
          (carrier.present() && carrier[i] >= 0)) {
        continue;
      }
      GatherSurface(i, form(mesh_columns.mesh, i), Wide(position[i]), bodies_[i].rotation);
    }
    for (uint64_t i = 0; rows() + i < shapes_.size(); ++i) {
      const Quaternion q = Quaternion::Load(scenery_orientation[i]);
      if (scenery_shape[i] != int32_t(ShapeCode::kMesh) || !(Dot(q.v, q.v) + q.w * q.w > 0) ||
          (scenery_carrier.present() && scenery_carrier[i] >= 0)) {
        continue;
      }
      GatherSurface(rows() + i, form(mesh_columns.scenery_mesh, i), Wide(scenery_position[i]),
                    q.Normalised());
    }
  }

  void GatherSurface(uint64_t row, Form* form, const Vector& at, const Quaternion& q) {
    shapes_[row] = {};
    surfaces_[row] = form == nullptr ? nullptr : form->surface();
    const Surface* surface = surfaces_[row];
    if (surface == nullptr) return Bound(row, false, 0);
    Shape& one = shapes_[row];
    one.code = ShapeCode::kSurface;
    one.axes = Axes::Of(q);
    one.position = at;
    const Vector centre = at + one.axes.ToWorld((surface->low() + surface->high()) * 0.5);
    one.half = (surface->high() - surface->low()) * 0.5;
    const Vector reach{one.Reach({1, 0, 0}), one.Reach({0, 1, 0}), one.Reach({0, 0, 1})};
    bounds_[row] = {centre - reach, centre + reach, false};
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
    return std::isfinite(sum) && norm > 0 && contact_columns.AreFinite(i);
  }

  /** Computes the bounding box of a shape, enlarged by the distance `way` that it may move in this
   *  step. */
  void Bound(uint64_t row, bool movable, double way) {
    const Shape& one = shapes_[row];
    if (one.code == ShapeCode::kNone || (one.Thickness() < 0)) shapes_[row].code = ShapeCode::kNone;
    bounds_[row] = BoundsOf(row, movable, way);
  }
  Bounds BoundsOf(uint64_t row, bool movable, double way) const {
    const Shape& one = shapes_[row];
    if (one.code == ShapeCode::kNone) {
      return {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, false};
    }
    const double more = kSlop * one.Thickness() + way;
    const Vector reach{one.Reach({1, 0, 0}) + more, one.Reach({0, 1, 0}) + more,
                       one.Reach({0, 0, 1}) + more};
    Bounds bounds{one.position - reach, one.position + reach, movable};
    if (one.hull != nullptr) {  // other shapes are symmetric
      bounds.low = one.position - Vector{one.Reach({-1, 0, 0}) + more, one.Reach({0, -1, 0}) + more,
                                         one.Reach({0, 0, -1}) + more};
    }
    return bounds;
  }

  /** Returns the distance from the centre of a body to its farthest point [m]; 1 m for a body
   *  without a shape. */
  double ReachOf(uint32_t body) const { return bodies_[body].reach > 0 ? bodies_[body].reach : 1; }
  double SpeedAtEnd(uint32_t body) const {
    const Motion<Real>& motion = motions_[body];
    return Length(Wide(motion.velocity)) + Length(Wide(motion.spin)) * ReachOf(body);
  }

  /** Returns the mean speed of the fastest point of a body in this step [m/s]. It includes
   *  corrections of positions, which leave no velocity. */
  double MeanSpeed(uint32_t body, double dt) const {
    const Motion<Real>& motion = motions_[body];
    return (Length(Wide(motion.moved)) + Length(Wide(motion.turned)) * ReachOf(body)) / dt;
  }

  uint64_t DigestOfScenery(uint64_t i) const {
    Digest digest;
    digest.Add(uint64_t(uint32_t(scenery_shape[i]))).Add(scenery_size[i]);
    digest.Add(Wide(scenery_position[i])).Add(Quaternion::Load(scenery_orientation[i]));
    if (scenery_carrier.present()) digest.Add(uint64_t(scenery_carrier[i] >= 0));
    return digest.Add(DigestOfMesh(mesh_columns.scenery_mesh, i)).value();
  }
  template <class Column>
  uint64_t DigestOfMesh(const Column& column, uint64_t i) const {
    const Form* form = column.present() ? forms_.Find(column[i]) : nullptr;
    return form == nullptr ? 0 : form->digest();
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
    const uint32_t body = parts_.BodyOf(touch.owner());
    return {partners[body], places[body], impulses[body], touch.a_stores};
  }
  uint32_t NameOfPartner(const Touch& touch) const { return NameOf(touch.partner(), rows()); }

  void FindContacts(const Step& step) {
    const std::vector<Pair>& pairs = broad_phase_.Find(bounds_);
    sleep_.Wake(*this, sleep_columns, {sleep_time.value(), sleep_speed.value()}, step);
    collisions_.Find(
        step, pairs, shapes_, surfaces_, [&](const Pair& pair) { return MustCollide(pair); },
        [&](const Pair& pair) { return Margin(pair.a, pair.b, step.dt); });
    touches_.clear();
    contacts_.clear();
    contact_columns.ClearTouches();
    collisions_.ForEach(pairs, surfaces_, [&](const Pair& pair, const Manifold& manifold) {
      TryContact(pair, manifold);
    });
    sleep_.FallAsleep(*this, sleep_columns, contacts_);
    StopSleepers();
    step.ParallelFor(contacts_.size(), kContactGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) RecallContact(i);
    });
    colours_.Choose(contacts_, rows());
    batches_.Choose(contacts_, colours_);
    ForEachBatch(step, [&](Batch<Real>& batch) { batch.Load(contacts_, motions_); });
    ForEachSingle(step, [&](uint32_t i) {
      contacts_[i].FindMasses(MotionOf(contacts_[i].a), MotionOf(contacts_[i].b));
    });
  }

  /** Excludes the bodies that sleep from the solution. */
  void StopSleepers() {
    const auto rests = [&](uint32_t body) { return body != kImmovable && sleep_.Rests(body); };
    joints_.LetRest(rests);
    size_t kept = 0;
    for (size_t i = 0; i < contacts_.size(); ++i) {
      if (rests(contacts_[i].a) || rests(contacts_[i].b)) continue;
      if (kept != i) {
        contacts_[kept] = contacts_[i];
        touches_[kept] = touches_[i];
      }
      ++kept;
    }
    contacts_.resize(kept);
    touches_.resize(kept);
    for (uint32_t i = 0; i < rows(); ++i) {
      if (sleep_.Rests(i)) motions_[i].velocity = motions_[i].spin = {};
    }
  }

  /** Returns whether the contact points of a pair must be computed in this step. */
  bool MustCollide(const Pair& pair) const {
    return MayMeet(pair) && (contact_columns.CountsTouches() || IsAwake(pair));
  }
  /** Returns whether one of the bodies of a pair is movable and does not sleep. */
  bool IsAwake(const Pair& pair) const {
    const auto awake = [&](uint32_t shape) {
      const uint32_t body = BodyOf(parts_.BodyOf(shape));
      return body != kImmovable && !sleep_.Rests(body);
    };
    return awake(pair.a) || awake(pair.b);
  }
  bool AreJoined(const Pair& pair) const {
    const uint32_t a = parts_.BodyOf(pair.a), b = parts_.BodyOf(pair.b);
    return joints_.AreJoined({std::min(a, b), std::max(a, b)});
  }

  bool MayMeet(const Pair& pair) const {
    return contact_columns.Meet(pair.a, pair.b) && parts_.BodyOf(pair.a) != parts_.BodyOf(pair.b);
  }

  /** Counts a touch; adds a contact unless one of the shapes is a sensor, or a joint connects the
   *  bodies. */
  void TryContact(const Pair& pair, const Manifold& manifold) {
    if (AreJoined(pair)) return;
    const bool sensed = contact_columns.IsSensor(pair.a) || contact_columns.IsSensor(pair.b);
    if (contact_columns.CountsTouches()) CountTouch(pair, manifold, sensed);
    if (!sensed && IsAwake(pair)) AddContact(pair, manifold);
  }

  void CountTouch(const Pair& pair, const Manifold& manifold, bool sensed) {
    double least = HUGE_VAL;
    for (int i = 0; i < manifold.count; ++i) {
      least = std::min(least, manifold.points[i].separation);
    }
    // Bodies that rest on each other may have a small distance.
    const double thickness = std::min(shapes_[pair.a].Thickness(), shapes_[pair.b].Thickness());
    if (least > (sensed ? 0 : kSlop * thickness)) return;
    for (const uint32_t row : {pair.a, pair.b}) {
      contact_columns.CountTouch(row);
      if (parts_.BodyOf(row) != row) contact_columns.CountTouch(parts_.BodyOf(row));
    }
  }

  double Margin(uint32_t a, uint32_t b, double dt) const {
    const double thickness = std::min(shapes_[a].Thickness(), shapes_[b].Thickness());
    const double speed = SpeedOf(a) + SpeedOf(b);
    const auto solid = [&](uint32_t row) {
      return shapes_[row].code == ShapeCode::kPlane || shapes_[row].code == ShapeCode::kSurface;
    };
    // The distance is at most half the thickness. Bodies that only pass each other would get
    // contacts with a larger distance.
    return kSlop * thickness +
           (solid(a) || solid(b) ? speed * dt : std::min(speed * dt, 0.5 * thickness));
  }
  double SpeedOf(uint32_t shape_row) const {
    return shape_row < rows() ? bodies_[shape_row].speed : 0;
  }
  /** Returns the centre of a shape's body, from which the lever arms are measured. */
  Vector CentreOf(uint32_t shape_row) const {
    const uint32_t body = parts_.BodyOf(shape_row);
    return body == shape_row ? shapes_[shape_row].position : Wide(position[body]);
  }

  void AddContact(const Pair& pair, const Manifold& manifold) {
    Contact<Real>& contact = contacts_.emplace_back();
    contact.a = BodyOf(parts_.BodyOf(pair.a));
    contact.b = BodyOf(parts_.BodyOf(pair.b));
    contact.normal = Narrow<Real>(manifold.normal);
    contact.count = manifold.count;
    contact.spent = {};
    const Touching touching = TouchingOf(pair);
    contact.friction = static_cast<Real>(touching.friction);
    contact.restitution = static_cast<Real>(std::min(1.0, touching.restitution));
    contact.rolling = static_cast<Real>(touching.rolling);
    contact.spinning = static_cast<Real>(touching.spinning);
    contact.roll[0] = contact.roll[1] = contact.spin = 0;
    const Vector centre_a = CentreOf(pair.a), centre_b = CentreOf(pair.b);
    for (int i = 0; i < manifold.count; ++i) {
      const ContactPoint& from = manifold.points[i];
      auto& point = contact.points[i];
      point = {};
      point.arm_a = Narrow<Real>(from.at - centre_a);
      point.arm_b = Narrow<Real>(from.at - centre_b);
      point.separation = static_cast<Real>(from.separation);
    }
    // The smaller body stores the contact, because only a few larger bodies can touch it.
    const bool a_stores =
        contact.b == kImmovable ||
        (contact.a != kImmovable && shapes_[pair.a].Bound() <= shapes_[pair.b].Bound());
    touches_.push_back({pair.a, pair.b, a_stores});
  }

  /** Returns the values of the contact of two shapes. */
  Touching TouchingOf(const Pair& pair) const {
    const auto& columns = contact_columns;
    const auto larger = [&](const auto& column, double otherwise) {
      return std::max(ContactColumns<Real>::ValueOf(column, pair.a, otherwise),
                      ContactColumns<Real>::ValueOf(column, pair.b, otherwise));
    };
    const double rolls = larger(columns.rolling, rolling_friction.value());
    const double spins = larger(columns.spinning, spin_friction.value());
    if (substances.present()) {
      Touching touching = TouchOf(
          substances, pair.a, pair.b,
          {friction.value(), restitution.value(), rolling_friction.value(), spin_friction.value()},
          [&](uint32_t shape) { return columns.OwnValues(shape); });
      // Without such values of substances, a value 0 of a body is a value that is set.
      if (!substances.HasRolling()) touching.rolling = rolls;
      if (!substances.HasSpinning()) touching.spinning = spins;
      return touching;
    }
    const double rub_a = ContactColumns<Real>::ValueOf(columns.friction, pair.a, friction.value());
    const double rub_b = ContactColumns<Real>::ValueOf(columns.friction, pair.b, friction.value());
    return {std::sqrt(rub_a * rub_b), larger(columns.restitution, restitution.value()), rolls,
            spins};
  }

  /** Begins with the impulses of the last step. The means of the arms are sums in the order that
   *  the points have before. */
  void RecallContact(uint64_t i) {
    Contact<Real>& contact = contacts_[i];
    const Touch& touch = touches_[i];
    contact.FindDirections();
    const double reach =
        kNear * std::min(shapes_[touch.a].Thickness(), shapes_[touch.b].Thickness());
    MemoryOf(touch).Recall(contact, NameOfPartner(touch), static_cast<Real>(reach));
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
        ForEachContact(
            step, [&](Batch<Real>& batch) { batch.WarmStart(motions_); },
            [](auto& contact, auto& a, auto& b) { contact.WarmStart(a, b); });
        joints_.WarmStart(motions_, solver);
      }
      joints_.Solve(motions_, solver, true);
      SolveContacts(step, solver, true);
      Drift(step, solver.substep);
      joints_.Refresh(motions_, pose);
      SolveContacts(step, solver, false);
      joints_.Solve(motions_, solver, false);
      if (!bounces) continue;
      ForEachContact(
          step, [](Batch<Real>&) {},
          [&](auto& contact, auto& a, auto& b) {
            if (contact.restitution > 0) contact.Restitute(a, b, solver);
          });
    }
    ForEachBatch(step, [&](Batch<Real>& batch) { batch.Store(contacts_); });
  }

  void SolveContacts(const Step& step, const SolverStep<Real>& solver, bool push) {
    ForEachContact(
        step, [&](Batch<Real>& batch) { batch.Solve(motions_, solver, push); },
        [&](auto& contact, auto& a, auto& b) { contact.Solve(a, b, solver, push); });
  }

  /** Calls of_batch(batch) for all batches, and of_single(contact, motion a, motion b) for the
   * other contacts, colour by colour. */
  template <class OfBatch, class OfSingle>
  void ForEachContact(const Step& step, OfBatch&& of_batch, OfSingle&& of_single) {
    for (uint32_t colour = 0; colour < Colours::kMost; ++colour) {
      const auto batches = batches_.Of(colour);
      const auto singles = batches_.SinglesOf(colour);
      const auto run_batches = [&](uint64_t begin, uint64_t end) {
        for (uint64_t i = begin; i < end; ++i) of_batch(batches[i]);
      };
      const auto run_singles = [&](uint64_t begin, uint64_t end) {
        for (uint64_t i = begin; i < end; ++i) {
          Contact<Real>& contact = contacts_[singles[i]];
          Motion<Real> still_a, still_b;
          of_single(contact, contact.a == kImmovable ? still_a : motions_[contact.a],
                    contact.b == kImmovable ? still_b : motions_[contact.b]);
        }
      };
      if (batches.size() < kManyContacts / Batch<Real>::kCount) {
        run_batches(0, batches.size());
      } else {
        step.ParallelFor(batches.size(), kBatchGrain, run_batches);
      }
      if (singles.size() < kManyContacts || colour == Colours::kMost - 1) {
        run_singles(0, singles.size());
      } else {
        step.ParallelFor(singles.size(), kContactGrain, run_singles);
      }
    }
  }

  /** Calls action(batch) for all batches, in any order. */
  template <class Action>
  void ForEachBatch(const Step& step, Action&& action) {
    const auto batches = batches_.all();
    step.ParallelFor(batches.size(), kBatchGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) action(batches[i]);
    });
  }
  /** Calls action(index) for all contacts that no batch contains, in any order. */
  template <class Action>
  void ForEachSingle(const Step& step, Action&& action) {
    const auto singles = batches_.singles();
    step.ParallelFor(singles.size(), kContactGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) action(singles[i]);
    });
  }

  /** Moves and rotates all bodies for a substep. */
  void Drift(const Step& step, Real h) {
    step.ParallelFor(rows(), kBodyGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        if (sleep_.Rests(uint32_t(i))) continue;
        Motion<Real>& motion = motions_[i];
        motion.moved += motion.velocity * h;
        motion.turned += motion.spin * h;
        if (bodies_[i].rotates) Turn(bodies_[i], motion, double{h});
      }
    });
    const auto renew = [&](uint32_t i) {
      Contact<Real>& contact = contacts_[i];
      contact.FindDirections();
      contact.FindMasses(MotionOf(contact.a), MotionOf(contact.b));
    };
    const auto is_renewed = [&](uint32_t body) { return IsRenewed(body); };
    ForEachBatch(step,
                 [&](Batch<Real>& batch) { batch.Renew(contacts_, motions_, is_renewed, renew); });
    ForEachSingle(step, [&](uint32_t i) {
      if (IsRenewed(contacts_[i].a) || IsRenewed(contacts_[i].b)) renew(i);
    });
  }
  bool IsRenewed(uint32_t body) const { return body != kImmovable && bodies_[body].renewed; }

  // --- writing the columns

  void Remember() {
    used_.assign(rows(), 0);
    for (size_t i = 0; i < contacts_.size(); ++i) {
      const Touch& touch = touches_[i];
      MemoryOf(touch).Store(contacts_[i], NameOfPartner(touch),
                            used_[parts_.BodyOf(touch.owner())]);
    }
    for (uint64_t i = 0; i < rows(); ++i) {
      if (sleep_.Rests(uint32_t(i))) continue;  // its contacts are those before it fell asleep
      for (uint32_t slot = used_[i]; slot < kSlots && partners[i][slot] != 0; ++slot) {
        partners[i][slot] = 0;
      }
    }
  }

  /** Writes the mean force on each body at its contacts. The force on a part of a body is
   *  written to the body. */
  void ScatterReactions(const Step& step) {
    const auto& reaction = contact_columns.reaction;
    std::fill(reaction.begin(), reaction.end(), Vector3{});
    const Real per_time = 1 / static_cast<Real>(step.dt);
    for (size_t i = 0; i < contacts_.size(); ++i) {
      const Vector3 force = contacts_[i].TotalImpulse() * per_time;
      const uint32_t a = parts_.BodyOf(touches_[i].a), b = parts_.BodyOf(touches_[i].b);
      if (a < rows()) reaction[a] -= force;
      if (b < rows()) reaction[b] += force;
    }
    for (uint32_t i = 0; i < rows(); ++i) {
      for (uint32_t slot = 0; sleep_.Rests(i) && slot < kSlots; ++slot) {
        if (partners[i][slot] == 0) continue;
        const Vector3 force = ContactMemory<Real>::ImpulseOf(impulses[i], slot) * per_time;
        const uint32_t other = partners[i][slot] - 1;
        reaction[i] -= force;
        if (other < rows()) reaction[parts_.BodyOf(other)] += force;
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
        const bool rests = sleep_.Rests(uint32_t(i));
        if (rests && acceleration.present()) acceleration[i] = {};
        if (body.translates) {
          velocity[i] = motion.velocity;
          if (!rests) position[i] += motion.moved;
        }
        if (body.rotates && rests) {
          spin[i] = {};
        } else if (body.rotates) {
          spin[i] = motion.spin;
          orientation[i] = body.rotation.template Stored<Real>();
        }
      }
    });
    for (const Part& part : parts_.all()) {
      if (bodies_[part.body].broken || sleep_.Rests(part.body)) continue;
      const Quaternion q = Quaternion::Load(orientation[part.body]).Normalised();
      position[part.row] = Narrow<Real>(Wide(position[part.body]) + q.Rotate(part.offset));
      orientation[part.row] = (q * part.turn).template Stored<Real>();
    }
  }

  const Motion<Real> still_{};
  std::vector<Body> bodies_;             // one per row
  std::vector<Motion<Real>> motions_;    // one per row
  std::vector<Shape> shapes_;            // one per row, then one per item of scenery
  std::vector<Bounds> bounds_;           // in the order of shapes_
  std::vector<Touch> touches_;           // one per contact
  std::vector<Contact<Real>> contacts_;  // one per contact
  std::vector<uint32_t> used_;           // number of used slots of each row
  Forms forms_;
  Parts parts_;
  std::vector<const Surface*> surfaces_;  // in the order of shapes_; empty without meshes
  Collisions collisions_;
  JointSolver<Real> joints_;
  BroadPhase broad_phase_;
  Colours colours_;
  Batches<Real> batches_;
  Sleep<Real> sleep_;
  double dt_ = 0;  // [s]
};

}  // namespace vesper::rigid
