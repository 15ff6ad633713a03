// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "deepest_point.hpp"
#include "mesh_topology.hpp"
#include "patch_grid.hpp"
#include "responder.hpp"
#include "skin.hpp"
#include "vesper/law.hpp"

namespace {

using namespace vesper;
using namespace vesper::surface_contact;

// Patches per chunk of a thread.
constexpr uint64_t kGrain = 32;

/** A contact of a corner of a patch that is behind a mesh. */
template <class Real>
struct CornerContact {
  uint32_t corner;  // index among the corners of the patch
  uint32_t mesh;
  Immersion<Real> at;
};

/** A contact of an edge of a patch that is deeper behind a mesh between its ends than at its
 *  ends. */
template <class Real>
struct EdgeContact {
  std::array<uint32_t, 2> bodies;  // rows of the bodies at its two ends
  Real sharpness;                  // 1; less if the edge is almost flat
  DeepestPoint<Real> at;
  std::array<Immersion<Real>, 2> ends;

  /** Returns the excess of the depth of the edge's deepest point over the depth of one end. It is 1
   *  if the end is not behind the mesh, and 0 if the end is equally deep. */
  Real Excess(int end) const {
    const Real ratio = ends[end].depth / at.depth;
    return 1 - ratio * ratio;
  }
};

/** A force on a body [N]. All reactions are added later in a fixed order. */
template <class Real>
struct Reaction {
  uint32_t body;
  Vec3<Real> force;
};

/** Penalty contact of meshes with each other and with points. A spring and a damper act along the
 *  normal. A tangential spring and a damper act as friction, limited by Coulomb's law. */
template <class Real>
struct SurfaceContact {
  static constexpr auto kName = "surface_contact", kVersion = "1.1.0";
  static constexpr auto kDoc =
      "Elastic, damped contact with friction of triangle meshes and points.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kMomentum | kAngularMomentum | kTranslation | kRotation;

  Parameter maximum_depth{"maximumDepth", "Points deeper than this inside a mesh are let go.",
                          units::metre,   0.25,
                          1e-9,           1e9};

  Read<Vertices> vertices{"vertices", "surface", units::one};
  Read<Real> hardness{"hardness", "surface", units::newton_per_metre};
  OptionalRead<Real> damping{"surfaceDamping", "surface", units::newton_second_per_metre};
  OptionalRead<Real> friction{"frictionCoefficient", "surface", units::one};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Read<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};
  OptionalAccumulate<Vec3<Real>> contact_force{"contactForce", "body", units::newton};
  /// Elongation of each body's friction spring.
  Scratch<Vec3<Real>> stretch{"frictionStretch", "body", units::metre};
  /// The last step in which a contact stretched the friction spring, and this contact. The contact
  /// is 0 for the body's own contact as a corner. For the contact of an edge, it is the row of the
  /// edge's other end plus one.
  Scratch<std::array<uint32_t, 2>> stretched_by{"frictionUse", "body", units::one};

  auto Parameters() { return std::tie(maximum_depth); }
  auto Properties() {
    return std::tie(vertices, hardness, damping, friction, position, velocity, force, stretch,
                    stretched_by, contact_force);
  }

  void Bind() {
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
      chunk.reactions.clear();
      chunk.edge_contacts.clear();
      for (uint64_t i = begin; i < end; ++i) {
        FindContacts(i, chunk);
        PushCorners(topology_.patches()[i], step, chunk);
      }
    });
    // Adds forces in the order of the chunks, on one thread. Several chunks may add forces to the
    // same body, and an edge may use the friction springs of both its ends.
    for (Chunk& chunk : chunks_) {
      for (const auto& contact : chunk.edge_contacts) PushEdge(contact, step, chunk);
      for (const auto& [body, reaction] : chunk.reactions) {
        force[body] += reaction;
        if (contact_force.present()) contact_force[body] += reaction;
      }
    }
  }

  /** Returns half the sum of the squared depths times the hardness, over all contacts. The energy
   *  of friction springs is not included. */
  double PotentialEnergy() {
    double energy = 0;
    Chunk chunk;
    for (uint64_t i = 0; i < boxes_.size(); ++i) Enclose(i);
    grid_.Build(face_boxes_, with_faces_);
    for (uint64_t i = 0; i < boxes_.size(); ++i) {
      chunk.edge_contacts.clear();
      FindContacts(i, chunk);
      for (const auto& contact : chunk.corner_contacts) {
        const double depth{contact.at.depth};
        energy += 0.5 * double{hardness[contact.at.face]} * depth * depth;
      }
      for (const auto& contact : chunk.edge_contacts) {
        const double depth =
            double{contact.at.depth} * double{contact.Excess(0)} * double{contact.Excess(1)};
        const auto skin = MaterialOf(contact.at.faces, contact.at.shares);
        energy += 0.5 * double{skin.hardness} * double{contact.sharpness} * depth * depth;
      }
    }
    return energy;
  }

 private:
  static constexpr uint32_t kOwn = 0;
  /// Cosine of 30 degrees. An edge with a larger angle between its faces is sharp.
  static constexpr Real kSharpCosine = Real(0.866);

  /** The friction spring of a body, and the contact that uses it; see stretched_by. */
  struct Spring {
    uint32_t body = kNone;
    uint32_t user = kOwn;
  };

  /** A corner of a patch inside the box of another mesh. */
  struct Near {
    uint32_t corner;
    Nearest<Real> nearest;
  };

  /** Results and work memory of a range of patches. The vectors keep their memory between steps. */
  struct Chunk {
    std::vector<Reaction<Real>> reactions;  // reactions of all patches; the other vectors serve
                                            // one patch
    std::vector<uint32_t> candidates;       // patches of other meshes that it may touch
    std::vector<Vec3<Real>> points;         // positions of the patch's corners
    std::vector<CornerContact<Real>> corner_contacts;
    std::vector<EdgeContact<Real>> edge_contacts;
    // The members below are data for the patch and one mesh.
    std::vector<Near> near;
    std::vector<uint32_t> edges;  // edges of the patch that may be behind the mesh
    std::vector<Face<Real>> faces;
    std::vector<Ridge<Real>> ridges;
    std::vector<Immersion<Real>> ends;  // one per corner of the patch
  };

  /** Computes the bounding boxes of a patch. Throws if the position of one of its bodies is not
   *  finite. */
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

  /** Finds the contacts of a patch's own corners and edges with every other mesh. Contacts of
   *  corners are in the order of corners, then meshes; contacts of edges follow, in the order of
   *  meshes. */
  void FindContacts(uint64_t index, Chunk& chunk) const {
    const auto patches = topology_.patches();
    chunk.corner_contacts.clear();
    FindCandidates(index, chunk.candidates);
    if (chunk.candidates.empty()) return;
    chunk.points.clear();
    for (const uint32_t body : topology_.CornersOf(patches[index])) {
      chunk.points.push_back(position[body]);
    }
    for (auto first = chunk.candidates.begin(); first != chunk.candidates.end();) {
      const uint32_t mesh = patches[*first].mesh;
      auto last = first + 1;
      while (last != chunk.candidates.end() && patches[*last].mesh == mesh) ++last;
      FindContactsWithMesh(index, {first, last}, chunk);
      first = last;
    }
    std::ranges::sort(chunk.corner_contacts, {}, [](const CornerContact<Real>& contact) {
      return std::pair(contact.corner, contact.mesh);
    });
  }

  /** Lists the patches of other meshes that may touch this patch, grouped by mesh. */
  void FindCandidates(uint64_t index, std::vector<uint32_t>& out) const {
    const auto patches = topology_.patches();
    out.clear();
    grid_.Query(boxes_[index], [&](uint32_t other) {
      if (patches[other].mesh != patches[index].mesh) out.push_back(other);
    });
    std::ranges::sort(out);
  }

  /** Finds the contacts with one mesh; `others` are this mesh's patches. */
  void FindContactsWithMesh(uint64_t index, std::span<const uint32_t> others, Chunk& chunk) const {
    const Patch& patch = topology_.patches()[index];
    const uint32_t mesh = topology_.patches()[others.front()].mesh;
    const Skin<Real> skin(topology_, vertices.data(), position.data());
    const size_t first = chunk.corner_contacts.size();
    FindCorners(skin, others, 0, patch.own_count, chunk);
    if (topology_.meshes()[mesh].face_count == 1)
      return;  // behind a flat mesh, the deepest point
               // of an edge is one of its ends
    FindEdgesBehind(index, others, chunk);
    if (chunk.edges.empty()) return;
    GatherRidges(skin, boxes_[index], others, chunk);
    if (chunk.ridges.empty()) return;
    const size_t own = chunk.corner_contacts.size();
    FindCorners(skin, others, patch.own_count, patch.corner_count, chunk);
    chunk.ends.assign(patch.corner_count, {});
    for (size_t i = first; i < chunk.corner_contacts.size(); ++i) {
      chunk.ends[chunk.corner_contacts[i].corner] = chunk.corner_contacts[i].at;
    }
    chunk.corner_contacts.resize(own);
    FindDeepEdges(skin, patch, chunk);
  }

  /** Appends the corners with indices from `begin` to `end` that are behind a mesh. */
  void FindCorners(const Skin<Real>& skin, std::span<const uint32_t> others, uint32_t begin,
                   uint32_t end, Chunk& chunk) const {
    const Real reach = Real(maximum_depth);
    chunk.near.clear();
    for (uint32_t corner = begin; corner < end; ++corner) {
      for (const uint32_t other : others) {
        if (!face_boxes_[other].Contains(chunk.points[corner])) continue;
        chunk.near.push_back({corner, {reach * reach}});
        break;
      }
    }
    if (chunk.near.empty()) return;
    for (const uint32_t other : others) {
      for (const uint32_t row : topology_.FacesOf(topology_.patches()[other])) {
        const Face<Real> face = skin.FaceAt(row);
        for (auto& [corner, nearest] : chunk.near) {
          Approach(chunk.points[corner], face, nearest);
        }
      }
    }
    for (const auto& [corner, nearest] : chunk.near) {
      const Immersion<Real> at = skin.ImmersionAt(nearest);
      if (at.face == kNone) continue;
      chunk.corner_contacts.push_back({corner, topology_.patches()[others.front()].mesh, at});
    }
  }

  /** Lists the patch's own edges that may be partly behind a mesh. */
  void FindEdgesBehind(uint64_t index, std::span<const uint32_t> others, Chunk& chunk) const {
    const auto edges = topology_.EdgesOf(topology_.patches()[index]);
    chunk.edges.clear();
    const bool apart = std::ranges::none_of(
        others, [&](uint32_t other) { return SpaceBehind(other).Overlaps(boxes_[index]); });
    if (apart) return;
    for (uint32_t i = 0; i < edges.size(); ++i) {
      const auto [a, b] = edges[i].ends;
      const bool meets = std::ranges::any_of(others, [&](uint32_t other) {
        return SpaceBehind(other).Meets(chunk.points[a], chunk.points[b]);
      });
      if (meets) chunk.edges.push_back(i);
    }
  }

  /** Lists the faces of a mesh, and its convex edges (ridges) near the box. */
  void GatherRidges(const Skin<Real>& skin, const Box<Real>& box, std::span<const uint32_t> others,
                    Chunk& chunk) const {
    const Box<Real> around = box.Grown(Real(maximum_depth));
    chunk.faces.clear();
    chunk.ridges.clear();
    for (const uint32_t other : others) {
      const Patch& patch = topology_.patches()[other];
      const auto corners = topology_.CornersOf(patch);
      for (const uint32_t row : topology_.FacesOf(patch)) {
        chunk.faces.push_back(skin.FaceAt(row));
      }
      for (const Edge& edge : topology_.EdgesOf(patch)) {
        const Vec3<Real> start = position[corners[edge.ends[0]]];
        const Vec3<Real> end = position[corners[edge.ends[1]]];
        Ridge<Real> ridge;
        if (around.Meets(start, end) && MakeRidge(skin, edge, start, end, ridge)) {
          chunk.ridges.push_back(ridge);
        }
      }
    }
  }

  /** Returns a box that contains all points that may be behind the faces of a patch. For a closed
   *  mesh, it is the bounding box. */
  const Box<Real>& SpaceBehind(uint32_t index) const {
    const Patch& patch = topology_.patches()[index];
    const Mesh& mesh = topology_.meshes()[patch.mesh];
    const bool whole = mesh.closed && mesh.face_count == patch.face_count;
    return whole ? boxes_[index] : face_boxes_[index];
  }

  /** Computes a ridge. Returns false if the edge is not convex, or an adjacent face has no area. */
  bool MakeRidge(const Skin<Real>& skin, const Edge& edge, Vec3<Real> start, Vec3<Real> end,
                 Ridge<Real>& ridge) const {
    const uint32_t neighbour = topology_.Neighbour(edge.surface, edge.number);
    if (neighbour == kNone) return false;
    const Face<Real> face = skin.FaceAt(edge.surface), other = skin.FaceAt(neighbour);
    const Vec3<Real> middle = (other.a + other.b + other.c) * (Real(1) / 3), along = end - start;
    if (!(Dot(face.normal, middle - start) < 0) || !(other.scale > 0)) return false;
    ridge = {start, along * (1 / Dot(along, along)), {Unit(face.normal), Unit(other.normal)}};
    return true;
  }

  /** Appends a contact for each listed edge of the patch that is deeper between its ends than at
   *  its ends. */
  void FindDeepEdges(const Skin<Real>& skin, const Patch& patch, Chunk& chunk) const {
    const DeepestPointSearch<Real> search(skin, chunk.ridges, chunk.faces);
    const auto edges = topology_.EdgesOf(patch);
    const auto corners = topology_.CornersOf(patch);
    for (const uint32_t i : chunk.edges) {
      const auto [a, b] = edges[i].ends;
      const Real sharpness = SharpnessOf(skin, edges[i]);
      if (sharpness == 0) continue;
      const Real least = std::max(chunk.ends[a].depth, chunk.ends[b].depth);
      const DeepestPoint<Real> deepest =
          search.Find(chunk.points[a], chunk.points[b], least, Real(maximum_depth));
      if (deepest.depth == 0) continue;
      chunk.edge_contacts.push_back(
          {{corners[a], corners[b]}, sharpness, deepest, {chunk.ends[a], chunk.ends[b]}});
    }
  }

  /** Returns the sharpness of an edge: 0 for a flat or concave edge, and 1 for a border or an edge
   *  with an angle of 30 degrees or more between its faces. A flat edge has no contacts, because
   *  only the outline of a flat area makes contacts. */
  Real SharpnessOf(const Skin<Real>& skin, const Edge& edge) const {
    const uint32_t neighbour = topology_.Neighbour(edge.surface, edge.number);
    if (neighbour == kNone) return 1;
    const Face<Real> face = skin.FaceAt(edge.surface), other = skin.FaceAt(neighbour);
    const Vec3<Real> middle = (other.a + other.b + other.c) * (Real(1) / 3);
    if (!(Dot(face.normal, middle - face.a) < 0)) return 0;
    const Real cosine = Dot(Unit(face.normal), Unit(other.normal));
    return std::clamp((1 - cosine) / (1 - kSharpCosine), Real(0), Real(1));
  }

  /** Applies the forces of the corners' contacts to the points of a patch. Stores the reactions on
   *  the touched meshes. */
  void PushCorners(const Patch& patch, const Step& step, Chunk& chunk) {
    const auto bodies = topology_.PointsOf(patch);
    auto contact = chunk.corner_contacts.begin();
    for (uint32_t corner = 0; corner < bodies.size(); ++corner) {
      const auto first = contact;
      while (contact != chunk.corner_contacts.end() && contact->corner == corner) ++contact;
      const uint32_t body = bodies[corner];
      if (first == contact) continue;
      const auto depth = [](const CornerContact<Real>& of) { return of.at.depth; };
      const auto deepest = std::ranges::max_element(first, contact, {}, depth);
      for (auto each = first; each != contact; ++each) {
        const Touch<Real, 1> touch{
            position[body], velocity[body], {each->at}, {1}, each->at.depth, 1};
        const Spring spring = each == deepest ? Spring{body, kOwn} : Spring{};
        const Response<Real> response = Exert(touch, step, spring, chunk);
        const Vec3<Real> push = each->at.normal * response.push + response.drag;
        force[body] += push;
        if (contact_force.present()) contact_force[body] += push;
      }
    }
  }

  /** Applies the contact force of an edge. It is the negative gradient of the energy k S (D A
   *  B)^2 / 2, with the hardness k, the depth D, the sharpness S and the excesses A, B of D over
   *  the depths of the ends. An edge that is hardly deeper than its end adds little force. The
   *  edge takes over the load of the end as it gets deeper. */
  void PushEdge(const EdgeContact<Real>& contact, const Step& step, Chunk& chunk) {
    const auto& bodies = contact.bodies;
    const std::array<Real, 2> weights{1 - contact.at.place, contact.at.place};
    const std::array<Real, 2> excess{contact.Excess(0), contact.Excess(1)};
    const Real both = excess[0] * excess[1];
    const Real strength = contact.sharpness * both * (2 * (excess[0] + excess[1]) - 3 * both);
    const Touch<Real, 2> touch{position[bodies[0]] * weights[0] + position[bodies[1]] * weights[1],
                               velocity[bodies[0]] * weights[0] + velocity[bodies[1]] * weights[1],
                               contact.at.faces,
                               contact.at.shares,
                               contact.at.depth,
                               strength};
    const Response<Real> response = Exert(touch, step, SpringOf(bodies, step), chunk);
    if (response.push <= 0) return;
    const Vec3<Real> total = touch.Normal() * response.push + response.drag;
    const Real hardness_now = std::min(MaterialOf(touch.faces, touch.shares).hardness,
                                       response.push / (strength * touch.depth));
    const Real relief = 2 * contact.sharpness * both * hardness_now;
    for (int end = 0; end < 2; ++end) {
      chunk.reactions.push_back({bodies[end], total * weights[end]});
      const Immersion<Real>& at = contact.ends[end];
      if (at.face == kNone) continue;
      const Vec3<Real> relieved = at.normal * (relief * excess[1 - end] * at.depth);
      chunk.reactions.push_back({bodies[end], -relieved});
      for (int corner = 0; corner < 3; ++corner) {
        chunk.reactions.push_back({vertices[at.face][corner], relieved * at.weights[corner]});
      }
    }
  }

  template <size_t n>
  Material<Real> MaterialOf(const std::array<Immersion<Real>, n>& faces,
                            const std::array<Real, n>& shares) const {
    Material<Real> sum;
    for (size_t i = 0; i < n; ++i) {
      const uint32_t face = faces[i].face;
      sum.hardness += shares[i] * hardness[face];
      if (damping.present()) sum.damping += shares[i] * damping[face];
      if (friction.present()) sum.friction += shares[i] * friction[face];
    }
    return sum;
  }

  /** Computes the forces of a contact on its point, and stores the reactions on the corners of the
   *  faces. The reactions conserve momentum and angular momentum, because friction acts at the
   *  point, as if the faces extended to it. Without a friction spring, friction is the force of its
   *  damper only. */
  template <size_t n>
  Response<Real> Exert(const Touch<Real, n>& touch, const Step& step, Spring spring,
                       Chunk& chunk) const {
    Material<Real> skin = MaterialOf(touch.faces, touch.shares);
    skin.hardness *= touch.strength;
    skin.damping *= touch.strength;
    Real closing = 0;
    for (size_t i = 0; i < n; ++i) {
      const Immersion<Real>& at = touch.faces[i];
      closing +=
          touch.shares[i] * Dot(Blend(at.weights, Moving(at.face)) - touch.velocity, at.normal);
    }
    const Real push = skin.hardness * touch.depth + skin.damping * closing;
    if (push <= 0) return {};  // a contact does not attract
    Vec3<Real> normal = touch.Normal();
    Response<Real> response{push};
    const auto frames = FramesOf(touch, std::make_index_sequence<n>());
    if (friction.present()) {
      Real limit = skin.friction * push;
      if constexpr (n > 1) {
        const Real length = Length(normal);
        limit *= length;
        normal = normal * (1 / length);
      }
      Vec3<Real> carried;
      for (size_t i = 0; i < n; ++i) {
        carried += frames[i].Carried(Moving(touch.faces[i].face)) * touch.shares[i];
      }
      const Vec3<Real> slip = Across(touch.velocity - carried, normal);
      Vec3<Real> stretched;
      if (spring.body != kNone) {
        if (Holds(spring, step)) stretched = Across(stretch[spring.body], normal);
        if (step.stage == 1) stretched += slip * static_cast<Real>(step.dt);
      }
      response.drag = Rub(skin, slip, limit, stretched);
      if (spring.body != kNone && step.stage == 1) {
        stretch[spring.body] = stretched;
        stretched_by[spring.body] = {StepsDone(step) + 1, spring.user};
      }
    }
    for (size_t i = 0; i < n; ++i) {
      const Immersion<Real>& at = touch.faces[i];
      for (int corner = 0; corner < 3; ++corner) {
        chunk.reactions.push_back(
            {vertices[at.face][corner], (at.normal * (-push * at.weights[corner]) +
                                         frames[i].Reaction(corner, response.drag)) *
                                            touch.shares[i]});
      }
    }
    return response;
  }

  /** Returns true if this contact stretched the spring in the previous step or in this one. */
  bool Holds(Spring spring, const Step& step) const {
    const uint32_t then = StepsDone(step) + (step.stage == 1 ? 0 : 1);
    const auto [when, user] = stretched_by[spring.body];
    return when == then && user == spring.user;
  }

  /** Returns the friction spring, of either end, that the edge already stretches. Otherwise returns
   *  a spring that no contact uses. */
  Spring SpringOf(const std::array<uint32_t, 2>& bodies, const Step& step) const {
    const std::array<Spring, 2> springs{Spring{bodies[0], bodies[1] + 1},
                                        Spring{bodies[1], bodies[0] + 1}};
    for (const Spring& spring : springs) {
      if (Holds(spring, step)) return spring;
    }
    for (const Spring& spring : springs) {
      if (stretched_by[spring.body][0] != StepsDone(step) + 1) return spring;
    }
    return {};
  }

  static uint32_t StepsDone(const Step& step) { return static_cast<uint32_t>(step.index); }

  std::array<Vec3<Real>, 3> Moving(uint32_t face) const {
    const auto [i, j, k] = vertices[face];
    return {velocity[i], velocity[j], velocity[k]};
  }

  /** Returns the touched faces as responders for the point. */
  template <size_t n, size_t... i>
  std::array<Frame<Real>, n> FramesOf(const Touch<Real, n>& touch,
                                      std::index_sequence<i...>) const {
    const Skin<Real> skin(topology_, vertices.data(), position.data());
    return {Frame<Real>(skin.Corners(touch.faces[i].face), touch.point)...};
  }

  // Bind or Advance can rebuild all following members.
  MeshTopology topology_;
  std::vector<Box<Real>> boxes_;       // one per patch
  std::vector<Box<Real>> face_boxes_;  // (patches), including the layer in which contacts are
                                       // searched
  std::vector<uint32_t> with_faces_;   // indices of patches
  PatchGrid<Real> grid_;
  std::vector<Chunk> chunks_;  // one per kGrain patches
};

}  // namespace

VESPER_LAW_LIBRARY("surface_contact", SurfaceContact)
