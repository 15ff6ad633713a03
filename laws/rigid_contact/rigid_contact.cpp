// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "body.hpp"
#include "broad_phase.hpp"
#include "collisions.hpp"
#include "colours.hpp"
#include "contact_columns.hpp"
#include "contact_memory.hpp"
#include "joint_columns.hpp"
#include "manifold.hpp"
#include "parts.hpp"
#include "solver.hpp"
#include "vesper/law.hpp"

namespace {

using namespace vesper;
using namespace vesper::rigid;

// Rows and contacts per chunk of a thread.
constexpr uint64_t kBodyGrain = 256, kContactGrain = 128;
// Number of contacts of a colour above which several threads are faster than one.
constexpr uint32_t kManyContacts = 512;
// Separation up to which two shapes form a contact, as a fraction of their thickness.
constexpr double kSlop = 0.02;
// Distance up to which a contact point is identified with a point of the last step, as a fraction
// of the thickness.
constexpr double kNear = 0.2;

/** Motion of rigid bodies that touch: their shapes resist overlap, rub and bounce. */
template <class Real>
struct RigidContact {
  using Vector3 = Vec3<Real>;
  static constexpr auto kName = "rigid_contact", kVersion = "1.1.0";
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
  ContactColumns<Real> contact_columns;
  MeshColumns mesh_columns;
  // The contacts of the last step, see contact_memory.hpp.
  Scratch<SlotPartners> partners{"partners", "body", units::one};
  Scratch<SlotVectors<Real>> places{"places", "body", units::metre};
  Scratch<SlotVectors<Real>> impulses{"impulses", "body", kImpulseUnit};

  auto Parameters() {
    return std::tie(substeps, friction, restitution, restitution_speed, push_speed,
                    rolling_friction);
  }
  auto Properties() {
    return std::tuple_cat(std::tie(mass, force, torque, inertia, velocity, position, spin,
                                   orientation, acceleration, shape, size, carrier),
                          contact_columns.FirstProperties(),
                          std::tie(scenery_position, scenery_orientation, scenery_shape,
                                   scenery_size, scenery_carrier),
                          joint_columns.Properties(), std::tie(partners, places, impulses),
                          contact_columns.LaterProperties(), mesh_columns.Properties(),
                          joint_columns.LaterProperties());
  }

  void Advance(const Step& step) {
    const auto count = static_cast<uint32_t>(std::lround(substeps.value()));
    const auto dt = static_cast<Real>(step.dt);
    const auto solver = SolverStep<Real>::Of(dt, count, Real(push_speed), Real(restitution_speed));
    Gather(step);
    joint_columns.Gather(joints_, *this, step.dt);
    FindContacts(step);
    Solve(step, solver);
    Remember();
    if (contact_columns.reaction.present()) ScatterReactions(step);
    joint_columns.Scatter(joints_, *this, step.dt);
    Scatter(step);
  }

  // --- for the joints

  uint64_t rows() const { return mass.size(); }
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

  bool Movable(uint32_t body) const { return bodies_[body].translates || bodies_[body].rotates; }

  // --- reading the columns

  void Gather(const Step& step) {
    const uint64_t scenery = scenery_shape.present() ? scenery_shape.size() : 0;
    forms_.Update(mesh_columns.ranges, mesh_columns.points, mesh_columns.indices);
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
    const double bound = shapes_[i].Bound();
    body.speed = Length(Wide(motion.velocity)) + Length(Wide(motion.spin)) * bound;
    Bound(i, Movable(uint32_t(i)), body.speed * dt);
  }

  void GatherPart(const Part& part, double dt) {
    const Body& body = bodies_[part.body];
    const Motion<Real>& motion = motions_[part.body];
    shapes_[part.row] = part.shape;
    const double reach = Length(part.offset) + part.shape.Bound();
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
    const auto& own = contact_columns;
    if (own.friction.present()) sum += double{own.friction[i]};
    if (own.restitution.present()) sum += double{own.restitution[i]};
    if (own.rolling.present()) sum += double{own.rolling[i]};
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
    if (one.hull == nullptr) return;  // other shapes are symmetric
    bounds.low = one.position - Vector{one.Reach({-1, 0, 0}) + more, one.Reach({0, -1, 0}) + more,
                                       one.Reach({0, 0, -1}) + more};
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

  void FindContacts(const Step& step) {
    const std::vector<Pair>& pairs = broad_phase_.Find(bounds_);
    collisions_.Find(
        step, pairs, shapes_, surfaces_, [&](const Pair& pair) { return MayMeet(pair); },
        [&](const Pair& pair) { return Margin(pair.a, pair.b, step.dt); });
    touches_.clear();
    contacts_.clear();
    contact_columns.ClearTouches();
    collisions_.ForEach(pairs, surfaces_, [&](const Pair& pair, const Manifold& manifold) {
      TryContact(pair, manifold);
    });
    step.ParallelFor(contacts_.size(), kContactGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) PrepareContact(i);
    });
    colours_.Choose(contacts_, rows());
  }

  bool MayMeet(const Pair& pair) const {
    return contact_columns.Meet(pair.a, pair.b) && parts_.BodyOf(pair.a) != parts_.BodyOf(pair.b);
  }

  /** Counts a touch; adds a contact unless one of the shapes is a sensor, or a joint connects the
   *  bodies. */
  void TryContact(const Pair& pair, const Manifold& manifold) {
    const uint32_t a = parts_.BodyOf(pair.a), b = parts_.BodyOf(pair.b);
    if (joints_.AreJoined({std::min(a, b), std::max(a, b)})) return;
    const bool sensed = contact_columns.IsSensor(pair.a) || contact_columns.IsSensor(pair.b);
    if (contact_columns.CountsTouches()) CountTouch(pair, manifold, sensed);
    if (!sensed) AddContact(pair, manifold);
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
    // The distance is at most half the thickness. With a larger distance, bodies that only pass
    // each other would get contacts.
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
    const auto [rub_a, rub_b] = OfBoth(contact_columns.friction, pair, friction.value());
    contact.friction = static_cast<Real>(std::sqrt(rub_a * rub_b));
    const auto [e_a, e_b] = OfBoth(contact_columns.restitution, pair, restitution.value());
    contact.restitution = static_cast<Real>(std::min(1.0, std::max(e_a, e_b)));
    const auto [arm_a, arm_b] = OfBoth(contact_columns.rolling, pair, rolling_friction.value());
    contact.rolling = static_cast<Real>(std::max(arm_a, arm_b));
    contact.roll[0] = contact.roll[1] = 0;
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

  /** Returns the values of the two shapes of a pair, or `otherwise`. */
  template <class Column>
  static std::pair<double, double> OfBoth(const Column& column, const Pair& pair,
                                          double otherwise) {
    return {ContactColumns<Real>::ValueOf(column, pair.a, otherwise),
            ContactColumns<Real>::ValueOf(column, pair.b, otherwise)};
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
        joints_.WarmStart(motions_, solver);
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
      MemoryOf(touch).Store(contacts_[i], touch.partner(), used_[parts_.BodyOf(touch.owner())]);
    }
    for (uint64_t i = 0; i < rows(); ++i) {
      for (uint32_t slot = used_[i]; slot < kSlots && partners[i][slot] != 0; ++slot) {
        partners[i][slot] = 0;
      }
    }
  }

  /** Writes the mean force on each body at its contacts. The force on a part is that on its body.
   */
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
    for (const Part& part : parts_.all()) {
      if (bodies_[part.body].broken) continue;
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
};

}  // namespace

VESPER_LAW_LIBRARY("rigid_contact", RigidContact)
