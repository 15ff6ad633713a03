#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "closest_point.hpp"
#include "mesh_topology.hpp"
#include "patch_grid.hpp"
#include "vesper/law.hpp"

namespace {

using namespace vesper;
using namespace vesper::surface_contact;

// Patches that a thread takes at once.
constexpr uint64_t kGrain = 32;

/** A point of one mesh inside another. */
template <class Real>
struct Contact {
  uint32_t point;                 // row of body
  uint32_t face;                  // row of surface
  Real depth;                     // below the nearest point of the mesh [m], > 0
  Vec3<Real> normal;              // from the point to there, length 1
  std::array<Real, 3> weights;    // of the face's corners at the nearest point
  std::array<Vec3<Real>, 3> reactions;  // on the face's corners [N]
};

/** Penalty contact of meshes with each other and with points: spring and damper along the normal,
 *  spring and damper with Coulomb's limit across it. */
template <class Real>
struct SurfaceContact {
  static constexpr auto kName = "surface_contact", kVersion = "1.0.0";
  static constexpr auto kDoc = "Elastic, damped contact with friction of triangle meshes and points.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kMomentum | kAngularMomentum | kTranslation | kRotation;

  Parameter maximum_depth{"maximumDepth", "Points deeper than this inside a mesh are let go.",
                          units::metre, 0.25, 1e-9, 1e9};

  Read<Vertices> vertices{"vertices", "surface", units::one};
  Read<Real> hardness{"hardness", "surface", units::newton_per_metre};
  OptionalRead<Real> damping{"surfaceDamping", "surface", units::newton_second_per_metre};
  OptionalRead<Real> friction{"frictionCoefficient", "surface", units::one};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Read<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};
  /// How far the spring across the normal of a point's deepest contact is stretched.
  Scratch<Vec3<Real>> stretch{"frictionStretch", "body", units::metre};

  auto Parameters() { return std::tie(maximum_depth); }
  auto Properties() {
    return std::tie(vertices, hardness, damping, friction, position, velocity, force, stretch);
  }

  void Bind() {
    RefuseNegative(hardness);
    if (damping.present()) RefuseNegative(damping);
    if (friction.present()) RefuseNegative(friction);
    topology_.Build({vertices.data(), vertices.size()}, position.size());
    const auto patches = topology_.patches();
    boxes_.resize(patches.size());
    face_boxes_.resize(patches.size());
    with_faces_.clear();
    for (uint32_t i = 0; i < patches.size(); ++i) {
      if (patches[i].face_count > 0) with_faces_.push_back(i);
    }
    grid_.Reserve(with_faces_.size());
    chunks_.resize((patches.size() + kGrain - 1) / kGrain);
  }

  void Advance(const Step& step) {
    const uint64_t patches = boxes_.size();
    step.ParallelFor(patches, kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) Enclose(i);
    });
    grid_.Build(face_boxes_, with_faces_);
    step.ParallelFor(patches, kGrain, [&](uint64_t begin, uint64_t end) {
      Chunk& chunk = chunks_[begin / kGrain];
      chunk.contacts.clear();
      for (uint64_t i = begin; i < end; ++i) Push(i, step, chunk);
    });
    // A corner may feel points of many chunks.
    for (const Chunk& chunk : chunks_) {
      for (const Contact<Real>& contact : chunk.contacts) {
        for (int i = 0; i < 3; ++i) force[vertices[contact.face][i]] += contact.reactions[i];
      }
    }
  }

  /** Half the square of each depth, times the hardness. The stretch of friction is not in it. */
  double PotentialEnergy() {
    double energy = 0;
    Chunk chunk;
    for (uint64_t i = 0; i < boxes_.size(); ++i) Enclose(i);
    grid_.Build(face_boxes_, with_faces_);
    for (uint64_t i = 0; i < boxes_.size(); ++i) {
      FindCandidates(i, chunk.candidates);
      for (const uint32_t point : topology_.PointsOf(topology_.patches()[i])) {
        FindContacts(point, chunk);
      }
    }
    for (const Contact<Real>& contact : chunk.contacts) {
      energy += 0.5 * double{hardness[contact.face]} * double{contact.depth} * double{contact.depth};
    }
    return energy;
  }

 private:
  /** What a range of patches finds; its vectors keep their memory from step to step. */
  struct Chunk {
    std::vector<uint32_t> candidates;  // patches that a patch may touch
    std::vector<Contact<Real>> contacts;
  };

  /** The closest point of a mesh so far. */
  struct Nearest {
    Real square;  // of the distance
    uint32_t face = kNone;
    Closest<Real> at{};
    Vec3<Real> offset{};  // from there
    Vec3<Real> normal{};  // of the face, as long as twice its area
  };

  /** Puts boxes around a patch. Throws if a body of it is nowhere. */
  void Enclose(uint64_t patch) {
    Box<Real> box;
    for (const uint32_t body : topology_.CornersOf(topology_.patches()[patch])) {
      const Vec3<Real> p = position[body];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
        throw std::runtime_error("'position' of body row " + std::to_string(body) +
                                 " is not finite");
      }
      box.Include(p);
    }
    boxes_[patch] = box;
    face_boxes_[patch] = box.Grown(Real(maximum_depth));
  }

  /** Finds the contacts of a patch's points and pushes the points; notes the reactions. */
  void Push(uint64_t index, const Step& step, Chunk& chunk) {
    FindCandidates(index, chunk.candidates);
    for (const uint32_t point : topology_.PointsOf(topology_.patches()[index])) {
      const size_t first = chunk.contacts.size();
      FindContacts(point, chunk);
      const auto contacts = std::span(chunk.contacts).subspan(first);
      if (contacts.empty()) {
        if (step.stage == 1) stretch[point] = {};
        continue;
      }
      const auto deepest = std::ranges::max_element(contacts, {}, &Contact<Real>::depth);
      for (auto contact = contacts.begin(); contact != contacts.end(); ++contact) {
        force[point] += Exert(*contact, step, contact == deepest);
      }
    }
  }

  /** Patches of other meshes near this one, mesh by mesh. */
  void FindCandidates(uint64_t index, std::vector<uint32_t>& out) const {
    const auto patches = topology_.patches();
    out.clear();
    grid_.Query(boxes_[index], [&](uint32_t other) {
      if (patches[other].mesh != patches[index].mesh) out.push_back(other);
    });
    std::ranges::sort(out);
  }

  /** Appends a contact for each mesh among the candidates that has the point inside. */
  void FindContacts(uint32_t point, Chunk& chunk) const {
    const auto& candidates = chunk.candidates;
    for (size_t i = 0; i < candidates.size();) {
      const uint32_t mesh = topology_.patches()[candidates[i]].mesh;
      Nearest nearest{Real(maximum_depth) * Real(maximum_depth)};
      for (; i < candidates.size() && topology_.patches()[candidates[i]].mesh == mesh; ++i) {
        if (!face_boxes_[candidates[i]].Contains(position[point])) continue;
        for (const uint32_t face : topology_.FacesOf(topology_.patches()[candidates[i]])) {
          Approach(position[point], face, nearest);
        }
      }
      Contact<Real> contact;
      if (nearest.face != kNone && IsInside(point, nearest, contact)) {
        chunk.contacts.push_back(contact);
      }
    }
  }

  std::array<Vec3<Real>, 3> Corners(uint32_t face) const {
    const auto [a, b, c] = vertices[face];
    return {position[a], position[b], position[c]};
  }

  static Vec3<Real> Blend(const std::array<Real, 3>& weights, const std::array<Vec3<Real>, 3>& of) {
    return of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2];
  }

  /** Takes the face if it is nearer to p. A face without area has no side and is passed over. */
  void Approach(Vec3<Real> p, uint32_t face, Nearest& nearest) const {
    const auto [a, b, c] = Corners(face);
    const Vec3<Real> normal = Cross(b - a, c - a);
    const Real scale = Dot(normal, normal), height = Dot(normal, p - a);
    if (!(height * height < nearest.square * scale)) return;
    const Closest<Real> at = ClosestOnTriangle(p, a, b, c);
    const Vec3<Real> offset = p - Blend(at.weights, {a, b, c});
    const Real square = at.feature == kFace ? height * height / scale : Dot(offset, offset);
    if (square < nearest.square) nearest = {square, face, at, offset, normal};
  }

  /** Fills in the contact if the point is behind the nearest point of the mesh. */
  bool IsInside(uint32_t point, const Nearest& nearest, Contact<Real>& contact) const {
    const Real depth = std::sqrt(nearest.square);
    if (depth == 0 || !IsBehind(nearest)) return false;
    contact.point = point;
    contact.face = nearest.face;
    contact.depth = depth;
    contact.normal =
        nearest.at.feature == kFace ? Unit(nearest.normal) : nearest.offset * (-1 / depth);
    contact.weights = nearest.at.weights;
    return true;
  }

  /** Nothing is behind a border. */
  bool IsBehind(const Nearest& nearest) const {
    const auto& [square, face, at, offset, normal] = nearest;
    if (at.feature == kFace) return Dot(offset, normal) < 0;
    if (at.feature < kCorner0) {
      const uint32_t neighbour = topology_.Neighbour(face, at.feature - kEdge0);
      return neighbour != kNone && Dot(offset, Unit(normal) + Unit(Normal(neighbour))) < 0;
    }
    const uint32_t corner = vertices[face][at.feature - kCorner0];
    return !topology_.OnBorder(corner) && IsBehindCorner(offset, corner);
  }

  /** By the sum of the normals around, weighted with their angles (J. A. Baerentzen, H. Aanaes,
   *  Signed Distance Computation Using the Angle Weighted Pseudonormal, 2005); where all faces
   *  agree, by any of them. */
  bool IsBehindCorner(Vec3<Real> offset, uint32_t corner) const {
    const auto around = topology_.Around(corner);
    const auto behind = std::ranges::count_if(
        around, [&](uint32_t face) { return Dot(offset, Normal(face)) < 0; });
    if (behind == 0) return false;
    if (behind == std::ssize(around)) return true;
    Vec3<Real> sum;
    for (const uint32_t face : around) sum += Unit(Normal(face)) * AngleAt(corner, face);
    return Dot(offset, sum) < 0;
  }

  /** Outwards, as long as twice the area. */
  Vec3<Real> Normal(uint32_t face) const {
    const auto [a, b, c] = Corners(face);
    return Cross(b - a, c - a);
  }

  static Vec3<Real> Unit(Vec3<Real> v) {
    const Real length = Length(v);
    return length > 0 ? v * (1 / length) : Vec3<Real>{};
  }

  /** Of a face's corner [rad]. */
  Real AngleAt(uint32_t body, uint32_t face) const {
    auto [a, b, c] = vertices[face];
    while (a != body) {
      const uint32_t first = a;
      a = b, b = c, c = first;
    }
    const Vec3<Real> u = position[b] - position[a], v = position[c] - position[a];
    return std::atan2(Length(Cross(u, v)), Dot(u, v));
  }

  /** The force on the point [N]; fills in the reactions. They are such that momentum and angular
   *  momentum are kept: friction acts at the point, as if the face carried it along. */
  Vec3<Real> Exert(Contact<Real>& contact, const Step& step, bool remembers) {
    const auto corners = Corners(contact.face);
    const auto [i, j, k] = vertices[contact.face];
    const std::array<Vec3<Real>, 3> moving{velocity[i], velocity[j], velocity[k]};
    const Vec3<Real> moving_point = velocity[contact.point];

    const Vec3<Real> closing = Blend(contact.weights, moving) - moving_point;
    const Real speed = Dot(closing, contact.normal);
    const Real push = hardness[contact.face] * contact.depth + Damping(contact.face) * speed;
    if (push <= 0) {  // it does not pull
      if (remembers && step.stage == 1) stretch[contact.point] = {};
      return {};
    }

    const Frame frame(corners, position[contact.point]);
    const Vec3<Real> slip =
        Across(moving_point - frame.Carried(moving), contact.normal);
    const Vec3<Real> drag = Rub(contact, slip, push, step, remembers);
    for (int corner = 0; corner < 3; ++corner) {
      contact.reactions[corner] = contact.normal * (-push * contact.weights[corner]) +
                                  frame.Reaction(corner, drag);
    }
    return contact.normal * push + drag;
  }

  /** A negative one would pull, speed up or blow up. */
  template <class Column>
  static void RefuseNegative(const Column& column) {
    for (uint64_t row = 0; row < column.size(); ++row) {
      if (!(column[row] < 0)) continue;
      throw std::runtime_error("'" + std::string(column.name()) + "' of surface row " +
                               std::to_string(row) + " is " + std::to_string(column[row]) +
                               ", expected 0 or more");
    }
  }

  Real Damping(uint32_t face) const { return damping.present() ? damping[face] : 0; }

  static Vec3<Real> Across(Vec3<Real> v, Vec3<Real> normal) { return v - normal * Dot(v, normal); }

  /** Friction on the point [N]: a spring and a damper against the slip, which give way at Coulomb's
   *  limit (P. A. Cundall, O. D. L. Strack, A Discrete Numerical Model for Granular Assemblies,
   *  1979). Without memory, the damper alone. */
  Vec3<Real> Rub(const Contact<Real>& contact, Vec3<Real> slip, Real push, const Step& step,
                 bool remembers) {
    if (!friction.present()) return {};
    const Real limit = friction[contact.face] * push;
    const Real stiffness = hardness[contact.face], viscosity = Damping(contact.face);
    Vec3<Real> stretched;
    if (remembers) {
      stretched = Across(stretch[contact.point], contact.normal);
      if (step.stage == 1) stretched += slip * static_cast<Real>(step.dt);
    }
    Vec3<Real> drag = stretched * -stiffness - slip * viscosity;
    const Real size = Length(drag);
    if (!(size <= limit)) {
      drag = drag * (limit / size);
      stretched = stiffness > 0 ? (drag + slip * viscosity) * (-1 / stiffness) : Vec3<Real>{};
    }
    if (remembers && step.stage == 1) stretch[contact.point] = stretched;
    return drag;
  }

  /** A point as a face carries it: weights of the corners, and a height above its plane. */
  struct Frame {
    Frame(const std::array<Vec3<Real>, 3>& corners, Vec3<Real> point) {
      const auto& [a, b, c] = corners;
      const Vec3<Real> cross = Cross(b - a, c - a);
      const Real area = Dot(cross, cross);
      normal = cross * (1 / std::sqrt(area));
      gradients = {Cross(cross, c - b) * (1 / area), Cross(cross, a - c) * (1 / area),
                   Cross(cross, b - a) * (1 / area)};
      height = Dot(normal, point - a);
      weights[1] = Dot(gradients[1], point - a);
      weights[2] = Dot(gradients[2], point - a);
      weights[0] = 1 - weights[1] - weights[2];
    }

    /** Velocity of the point if the face carried it along. */
    Vec3<Real> Carried(const std::array<Vec3<Real>, 3>& moving) const {
      Vec3<Real> sum = Blend(weights, moving);
      for (int i = 0; i < 3; ++i) sum -= gradients[i] * (height * Dot(normal, moving[i]));
      return sum;
    }

    /** What a corner feels of a force on the point. Over the corners, these have the opposite sum
     *  and the opposite moment, and they do the work that Carried says. */
    Vec3<Real> Reaction(int corner, Vec3<Real> on_point) const {
      return on_point * -weights[corner] +
             normal * (height * Dot(gradients[corner], on_point));
    }

    Vec3<Real> normal;
    std::array<Vec3<Real>, 3> gradients;  // of the weights [1/m]
    std::array<Real, 3> weights;
    Real height;
  };

  // All of it is rebuilt by Bind or by each Advance.
  MeshTopology topology_;
  std::vector<Box<Real>> boxes_;       // (patches)
  std::vector<Box<Real>> face_boxes_;  // (patches), with the layer in which contact is looked for
  std::vector<uint32_t> with_faces_;   // patches
  PatchGrid<Real> grid_;
  std::vector<Chunk> chunks_;          // (patches / kGrain)
};

}  // namespace

VESPER_LAW_LIBRARY("surface_contact", SurfaceContact)
