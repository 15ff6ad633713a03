// SPDX-License-Identifier: Apache-2.0
// Connected surfaces, and the order in which the law processes them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace vesper::surface_contact {

inline constexpr uint32_t kNone = UINT32_MAX;

/// Rows of the three bodies at the corners of a surface.
using Vertices = std::array<uint32_t, 3>;

/// Up to kPatchFaces neighbouring faces of one mesh, or one body without surfaces.
struct Patch {
  uint32_t mesh;                        // kNone: a body without surfaces
  uint32_t first_face, face_count;      // indices into MeshTopology::faces
  uint32_t first_corner, corner_count;  // indices into MeshTopology::corners
  uint32_t own_count;                   // number of corners that the patch owns, the first ones;
                                        // each
                                        // body has one owner
  uint32_t first_edge, edge_count;      // indices into MeshTopology::edges; each edge has one owner
};

/// An edge, described by the surface that owns it.
struct Edge {
  std::array<uint32_t, 2> ends;  // indices into CornersOf(the surface's patch)
  uint32_t surface, number;      // the edge goes from corner `number` of the surface to the next
                                 // one
};

struct Mesh {
  uint32_t face_count;
  bool closed;  // the mesh has no border
};

/** The meshes. A mesh is a set of surfaces that are connected by shared bodies. An edge is inner if
 *  exactly two surfaces share it, in opposite directions. A body at any other edge is on the border
 *  of the mesh. */
class MeshTopology {
 public:
  static constexpr uint32_t kPatchFaces = 32;

  /// Builds the topology. Allocates; time is O(n log n).
  void Build(std::span<const Vertices> surfaces, uint64_t bodies);

  std::span<const Patch> patches() const { return patches_; }
  std::span<const Mesh> meshes() const { return meshes_; }
  /// Returns the rows of the surfaces of a patch.
  std::span<const uint32_t> FacesOf(const Patch& patch) const {
    return std::span(faces_).subspan(patch.first_face, patch.face_count);
  }
  /// Returns the rows of the bodies at the corners of a patch.
  std::span<const uint32_t> CornersOf(const Patch& patch) const {
    return std::span(corners_).subspan(patch.first_corner, patch.corner_count);
  }
  /// Returns the rows of the bodies that a patch owns. The patch computes the contacts of these
  /// points.
  std::span<const uint32_t> PointsOf(const Patch& patch) const {
    return std::span(corners_).subspan(patch.first_corner, patch.own_count);
  }
  std::span<const Edge> EdgesOf(const Patch& patch) const {
    return std::span(edges_).subspan(patch.first_edge, patch.edge_count);
  }
  /// Returns the surface at the other side of the edge from corner `edge` to the next corner, or
  /// kNone at a border.
  uint32_t Neighbour(uint32_t surface, uint32_t edge) const { return neighbours_[surface][edge]; }
  bool OnBorder(uint32_t body) const { return on_border_[body]; }
  /// Returns the surfaces with a corner at this body, in row order.
  std::span<const uint32_t> Around(uint32_t body) const {
    return std::span(around_).subspan(first_around_[body],
                                      first_around_[body + 1] - first_around_[body]);
  }

 private:
  void FindNeighbours(std::span<const Vertices> surfaces);
  void ListAround(std::span<const Vertices> surfaces);
  void CutIntoPatches(std::span<const Vertices> surfaces);
  void AddPatch(uint32_t mesh, uint32_t first_face, std::span<const Vertices> surfaces);
  void AddEdges(Patch& patch, std::span<const Vertices> surfaces);

  std::vector<Patch> patches_;
  std::vector<Mesh> meshes_;
  std::vector<uint32_t> faces_;
  std::vector<uint32_t> corners_;
  std::vector<Edge> edges_;
  std::vector<Vertices> neighbours_;       // neighbours of each surface at its edges, or kNone
  std::vector<std::array<bool, 3>> owns_;  // for each surface, whether it owns each of its edges
  std::vector<char> on_border_;            // for each body, whether it is on a border
  std::vector<uint32_t> first_around_;     // start of each body in around_ (bodies + 1)
  std::vector<uint32_t> around_;
  std::vector<char> owned_;  // for each body, whether a patch owns it
};

}  // namespace vesper::surface_contact
