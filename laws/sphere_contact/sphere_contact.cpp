// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <vector>

#include "sphere_pairs.hpp"
#include "vesper/law.hpp"

namespace {

using namespace vesper;

constexpr uint64_t kGrain = 512;

// Number of contacts that a sphere stores. At most this many spheres of equal or larger radius can
// touch a sphere at the same time.
constexpr uint32_t kSlots = 12;

// Partner id of the floor; it is greater than the rows of all bodies.
constexpr uint32_t kFloor = UINT32_MAX;

/** Contact of spheres by springs and dashpots, with the friction of Cundall and Strack. */
template <class Real>
struct SphereContact {
  using Vector = Vec3<Real>;
  static constexpr auto kName = "sphere_contact", kVersion = "1.0.0";
  static constexpr auto kDoc = "Elastic, damped contact with friction of balls and a floor.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kMomentum | kAngularMomentum | kTranslation | kRotation;

  Parameter stiffness{"stiffness", "Force per overlap.", units::newton_per_metre, 1e4, 1e-9, 1e15};
  Parameter damping{
      "dampingRatio", "Damping of a contact per critical damping.", units::one, 0.3, 0, 1};
  Parameter friction{"friction", "Largest tangential force per normal force.", units::one, 0.5, 0,
                     10};
  Parameter floor_height{"floorHeight", "Height of an immovable floor; by default out of reach.",
                         units::metre,  -1e9,
                         -1e9,          1e9};

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Real> radius{"radius", "body", units::metre};
  Read<Vector> position{"position", "body", units::metre};
  Read<Vector> velocity{"velocity", "body", units::metre_per_second};
  OptionalRead<Vector> spin{"angularVelocity", "body", units::radian_per_second};
  Accumulate<Vector> force{"externalForce", "body", units::newton};
  OptionalAccumulate<Vector> torque{"torque", "body", units::newton_metre};
  OptionalAccumulate<Vector> contact_force{"contactForce", "body", units::newton};
  // For each contact in which this sphere is the smaller one, `partner` contains the row of the
  // other sphere plus one. The rows are in ascending order and end with 0. `slip` contains the
  // accumulated slip of the surfaces.
  Scratch<std::array<uint32_t, kSlots>> partner{"partner", "body", units::one};
  Scratch<std::array<Real, 3 * kSlots>> slip{"slip", "body", units::metre};

  auto Parameters() { return std::tie(stiffness, damping, friction, floor_height); }
  auto Properties() {
    return std::tie(mass, radius, position, velocity, spin, force, torque, partner, slip,
                    contact_force);
  }

  void Advance(const Step& step) {
    const auto for_each = [&](uint64_t count, auto&& body) {
      step.ParallelFor(count, kGrain, body);
    };
    pairs_.Update(AllSpheres(), for_each);
    balls_.resize(mass.size());
    contacts_.resize(pairs_.pair_count());
    // An integrator may evaluate the same contacts in several stages. Only the first stage adds to
    // the slip.
    const Real dt = step.stage == 1 ? static_cast<Real>(step.dt) : 0;
    for_each(mass.size(), [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) balls_[i] = BallOf(i);
    });
    for_each(mass.size(), [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) TouchLarger(i, dt);
    });
    for_each(mass.size(), [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) TakeReactions(i);
    });
  }

  /** Returns the energy of the springs along the normals. The tangential springs of friction are
   *  not included. */
  double PotentialEnergy() {
    pairs_.Update(AllSpheres(), [](uint64_t count, auto&& body) { body(0, count); });
    double squares = 0;
    for (uint64_t i = 0; i < mass.size(); ++i) {
      const Real height = position[i].y - Real(floor_height);
      const bool on_floor = mass[i] != 0 && radius[i] > 0 && radius[i] > height;
      if (on_floor) squares += Square(double{radius[i] - height});
      for (const uint32_t j : pairs_.PartnersOf(i)) {
        const Real depth = radius[i] + radius[j] - Length(position[j] - position[i]);
        if (depth > 0) squares += Square(double{depth});
      }
    }
    return stiffness.value() / 2 * squares;
  }

 private:
  /** The properties of a body that a contact reads, adjacent in memory. */
  struct Ball {
    Vector position, velocity, spin;
    Real radius, inverse_mass;
  };
  /** The effect of a contact on its larger sphere, which is added to the sphere's forces later. */
  struct Contact {
    Vector force;   // on the larger sphere [N]
    Vector moment;  // normal x force [N]; times the lever arm of a sphere, it is the torque on it
    Real depth;     // [m]; 0 or less: no contact
  };
  /** Geometry and relative motion of the contact between a ball and another ball or the floor. */
  struct Meeting {
    Vector normal;    // unit vector from the ball to the other body
    Vector velocity;  // velocity of the other's surface relative to the ball's, at the contact
                      // point
    Real depth;
    Real inverse_mass;  // 1 / reduced mass
  };

  /** The stored contacts of a sphere, read and written in the order of their partners. */
  class Memory {
   public:
    Memory(std::array<uint32_t, kSlots>& ids, std::array<Real, 3 * kSlots>& slips)
        : ids_(ids), slips_(slips) {
      for (; count_ < kSlots && ids[count_] != 0; ++count_) {
        old_ids_[count_] = ids[count_];
        old_slips_[count_] = {slips[3 * count_], slips[3 * count_ + 1], slips[3 * count_ + 2]};
      }
    }
    ~Memory() {
      for (; kept_ < count_; ++kept_) ids_[kept_] = 0;
    }
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;

    Vector Recall(uint32_t id) {
      while (next_ < count_ && old_ids_[next_] < id) ++next_;
      return next_ < count_ && old_ids_[next_] == id ? old_slips_[next_] : Vector{};
    }
    /** Stores a contact, unless all slots are used. */
    void Keep(uint32_t id, const Vector& slip) {
      if (kept_ == kSlots) return;
      ids_[kept_] = id;
      slips_[3 * kept_] = slip.x;
      slips_[3 * kept_ + 1] = slip.y;
      slips_[3 * kept_ + 2] = slip.z;
      ++kept_;
    }

   private:
    std::array<uint32_t, kSlots>& ids_;
    std::array<Real, 3 * kSlots>& slips_;
    std::array<uint32_t, kSlots> old_ids_;
    std::array<Vector, kSlots> old_slips_;
    uint32_t count_ = 0, next_ = 0, kept_ = 0;
  };

  static constexpr double Square(double x) { return x * x; }

  Spheres<Real> AllSpheres() const {
    return {mass.size(), position.data(), radius.data(), mass.data()};
  }

  Ball BallOf(uint64_t i) const {
    return {position[i], velocity[i], spin.present() ? spin[i] : Vector{}, radius[i],
            mass[i] == 0 ? 0 : 1 / mass[i]};
  }

  /** Computes the contacts of a ball with larger balls and with the floor. Adds the forces on the
   *  ball, and stores the forces on its partners. */
  void TouchLarger(uint64_t i, Real dt) {
    const Ball& ball = balls_[i];
    Memory memory(partner[i], slip[i]);
    Vector pull{}, turn{};
    uint32_t pair = pairs_.FirstPair(i);
    for (const uint32_t j : pairs_.PartnersOf(i)) {
      Contact& contact = contacts_[pair++];
      contact.depth = 0;
      const Ball& other = balls_[j];
      const Vector way = other.position - ball.position;
      const Real reach = ball.radius + other.radius, square = Dot(way, way);
      if (square >= reach * reach) continue;
      const Meeting meeting = Meet(ball, other, way, std::sqrt(square));
      const Vector pushed = Press(meeting, j + 1, dt, memory);
      contact = {pushed, Cross(meeting.normal, pushed), meeting.depth};
      pull -= pushed;
      turn -= contact.moment * Arm(ball, meeting.depth);
    }
    const Real depth = ball.radius - (ball.position.y - Real(floor_height));
    if (depth > 0 && ball.radius > 0 && ball.inverse_mass != 0) {
      const Vector down{0, -1, 0};
      const Real arm = ball.radius - depth;
      const Meeting meeting{down, -(ball.velocity + Cross(ball.spin, down * arm)), depth,
                            ball.inverse_mass};
      const Vector pushed = Press(meeting, kFloor, dt, memory);
      pull -= pushed;
      turn -= Cross(down, pushed) * arm;
    }
    force[i] += pull;
    if (torque.present()) torque[i] += turn;
    if (contact_force.present()) contact_force[i] += pull;
  }

  /** Adds the forces of the contacts in which a ball is the larger one. */
  void TakeReactions(uint64_t i) const {
    for (const uint32_t pair : pairs_.PairsAsLarger(i)) {
      const Contact& contact = contacts_[pair];
      if (!(contact.depth > 0)) continue;
      force[i] += contact.force;
      if (contact_force.present()) contact_force[i] += contact.force;
      if (torque.present()) torque[i] -= contact.moment * Arm(balls_[i], contact.depth);
    }
  }

  /** Returns the lever arm: the distance from the ball's centre to the middle of the overlap [m].
   *  */
  static Real Arm(const Ball& ball, Real depth) { return ball.radius - depth / 2; }

  static Meeting Meet(const Ball& ball, const Ball& other, const Vector& way, Real distance) {
    // Two balls at the same place have no direction, so an arbitrary direction is used.
    const Vector normal = distance > 0 ? way * (1 / distance) : Vector{0, 1, 0};
    const Real depth = ball.radius + other.radius - distance;
    const Vector turning = ball.spin * Arm(ball, depth) + other.spin * Arm(other, depth);
    return {normal, other.velocity - ball.velocity - Cross(turning, normal), depth,
            ball.inverse_mass + other.inverse_mass};
  }

  /** Returns the force on the other body. A spring and a dashpot act along the normal, and their
   *  force is never attractive. A weaker spring and dashpot act along the surface, and they slip
   *  at the limit of friction. */
  Vector Press(const Meeting& meeting, uint32_t id, Real dt, Memory& memory) const {
    const Real k(stiffness);
    const Real critical = 2 * std::sqrt(k / meeting.inverse_mass);
    const Real dashpot = Real(damping) * critical;
    const Vector normal = meeting.normal;
    const Real apart = Dot(meeting.velocity, normal);
    const Real press = std::max(Real{0}, k * meeting.depth - dashpot * apart);
    if (friction.value() == 0) return normal * press;

    const Real across_k = kTangential * k, across_dashpot = kTangential * dashpot;
    const Vector across = meeting.velocity - normal * apart;
    Vector slipped = memory.Recall(id);
    slipped += across * dt - normal * Dot(slipped, normal);
    Vector rub = -(slipped * across_k + across * across_dashpot);
    const Real limit = Real(friction) * press, square = Dot(rub, rub);
    if (square > limit * limit) {
      rub = rub * (limit / std::sqrt(square));
      slipped = -(rub + across * across_dashpot) * (1 / across_k);
    }
    memory.Keep(id, slipped);
    return normal * press + rub;
  }

  // Tangential stiffness as a fraction of the normal stiffness. A solid ball oscillates equally
  // fast in both directions with this fraction.
  static constexpr Real kTangential = Real{2} / 7;

  SpherePairs<Real> pairs_;
  std::vector<Ball> balls_;        // one per row
  std::vector<Contact> contacts_;  // one per pair
};

}  // namespace

VESPER_LAW_LIBRARY("sphere_contact", SphereContact)
