// SPDX-License-Identifier: Apache-2.0
#include "mesh_topology.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace vesper::surface_contact {

void MeshTopology::Build(std::span<const Vertices> surfaces, uint64_t bodies) {
  on_border_.assign(bodies, 0);
  owned_.assign(bodies, 0);
  patches_.clear();
  meshes_.clear();
  faces_.clear();
  corners_.clear();
  edges_.clear();
  FindNeighbours(surfaces);
  ListAround(surfaces);
  CutIntoPatches(surfaces);
}

void MeshTopology::FindNeighbours(std::span<const Vertices> surfaces) {
  struct Side {
    uint32_t low, high, surface, number;
    bool upwards;
  };
  std::vector<Side> sides;
  sides.reserve(3 * surfaces.size());
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    for (uint32_t e = 0; e < 3; ++e) {
      const uint32_t from = surfaces[s][e], to = surfaces[s][(e + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), s, e, from < to});
    }
  }
  std::ranges::sort(sides, {},
                    [](const Side& e) { return std::tuple(e.low, e.high, e.surface, e.number); });
  neighbours_.assign(surfaces.size(), {kNone, kNone, kNone});
  owns_.assign(surfaces.size(), {});
  std::vector<char> owned(surfaces.size(), 0);  // number of edges that each surface owns so far
  for (size_t i = 0, end; i < sides.size(); i = end) {
    const Side& a = sides[i];
    for (end = i + 1; end < sides.size() && sides[end].low == a.low && sides[end].high == a.high;) {
      ++end;
    }
    const Side* owner = &a;
    if (end - i == 2 && a.upwards != sides[i + 1].upwards) {
      const Side& b = sides[i + 1];
      neighbours_[a.surface][a.number] = b.surface;
      neighbours_[b.surface][b.number] = a.surface;
      if (owned[b.surface] < owned[a.surface]) owner = &b;
    } else {
      on_border_[a.low] = on_border_[a.high] = 1;
    }
    if (a.low == a.high) continue;
    owns_[owner->surface][owner->number] = true;
    ++owned[owner->surface];
  }
}

void MeshTopology::ListAround(std::span<const Vertices> surfaces) {
  first_around_.assign(on_border_.size() + 1, 0);
  for (const Vertices& corners : surfaces) {
    for (const uint32_t body : corners) ++first_around_[body + 1];
  }
  std::partial_sum(first_around_.begin(), first_around_.end(), first_around_.begin());
  around_.resize(3 * surfaces.size());
  std::vector<uint32_t> next(first_around_.begin(), first_around_.end() - 1);
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    for (const uint32_t body : surfaces[s]) around_[next[body]++] = s;
  }
}

// Traverses each mesh breadth first, so that the faces of a patch are neighbours.
void MeshTopology::CutIntoPatches(std::span<const Vertices> surfaces) {
  std::vector<char> seen(surfaces.size(), 0);
  for (uint32_t start = 0; start < surfaces.size(); ++start) {
    if (seen[start]) continue;
    size_t cut = faces_.size();
    seen[start] = 1;
    faces_.push_back(start);
    for (size_t at = cut; at < faces_.size(); ++at) {
      for (const uint32_t body : surfaces[faces_[at]]) {
        for (const uint32_t next : Around(body)) {
          if (seen[next]) continue;
          seen[next] = 1;
          faces_.push_back(next);
        }
      }
    }
    const auto of_mesh = std::span(faces_).subspan(cut);
    const bool closed = std::ranges::none_of(
        of_mesh, [&](uint32_t face) { return std::ranges::count(neighbours_[face], kNone) > 0; });
    const auto mesh = static_cast<uint32_t>(meshes_.size());
    meshes_.push_back({static_cast<uint32_t>(of_mesh.size()), closed});
    for (; cut < faces_.size(); cut += kPatchFaces) {
      AddPatch(mesh, static_cast<uint32_t>(cut), surfaces);
    }
  }
  for (uint32_t body = 0; body < owned_.size(); ++body) {
    if (owned_[body]) continue;
    patches_.push_back({kNone, 0, 0, static_cast<uint32_t>(corners_.size()), 1, 1, 0, 0});
    corners_.push_back(body);
  }
}

// Adds a patch of at most kPatchFaces faces, starting at `first_face`. All faces from there on
// belong to the same mesh.
void MeshTopology::AddPatch(uint32_t mesh, uint32_t first_face,
                            std::span<const Vertices> surfaces) {
  const auto faces = std::span(faces_)
                         .subspan(first_face)
                         .first(std::min<size_t>(kPatchFaces, faces_.size() - first_face));
  std::vector<uint32_t> corners;
  for (const uint32_t face : faces) {
    corners.insert(corners.end(), surfaces[face].begin(), surfaces[face].end());
  }
  std::ranges::sort(corners);
  corners.erase(std::ranges::unique(corners).begin(), corners.end());
  const auto others =
      std::ranges::stable_partition(corners, [&](uint32_t body) { return owned_[body] == 0; });
  const auto own_count = static_cast<uint32_t>(others.begin() - corners.begin());
  patches_.push_back({mesh, first_face, static_cast<uint32_t>(faces.size()),
                      static_cast<uint32_t>(corners_.size()), static_cast<uint32_t>(corners.size()),
                      own_count, static_cast<uint32_t>(edges_.size()), 0});
  corners_.insert(corners_.end(), corners.begin(), corners.end());
  for (const uint32_t body : corners) owned_[body] = 1;
  AddEdges(patches_.back(), surfaces);
}

void MeshTopology::AddEdges(Patch& patch, std::span<const Vertices> surfaces) {
  const auto corners = CornersOf(patch);
  const auto place = [&](uint32_t body) {
    return static_cast<uint32_t>(std::ranges::find(corners, body) - corners.begin());
  };
  for (const uint32_t face : FacesOf(patch)) {
    for (uint32_t e = 0; e < 3; ++e) {
      if (!owns_[face][e]) continue;
      edges_.push_back({{place(surfaces[face][e]), place(surfaces[face][(e + 1) % 3])}, face, e});
    }
  }
  patch.edge_count = static_cast<uint32_t>(edges_.size()) - patch.first_edge;
}

}  // namespace vesper::surface_contact
