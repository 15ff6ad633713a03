// SPDX-License-Identifier: Apache-2.0
// Convex polyhedra and surfaces of triangles, in the axes of their items, from the columns of
// meshes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "rigid/rotation.hpp"

namespace vesper::rigid {

/** A convex polyhedron. Its core is the same polyhedron with all faces moved inwards by `rounding`.
 *  The spans point to memory of a Form, or of the function that made the polyhedron. */
struct Polytope {
  std::span<const Vector> corners, core;
  std::span<const Vector> normals;            // outward unit normals of the faces
  std::span<const uint32_t> first, around;    // corners of face i: around[first[i]], ... in order
  std::span<const uint32_t> begin, touching;  // faces at corner i: touching[begin[i]], ...
  double rounding = 0;                        // [m]
  double thickness = 0;                       // smallest extent perpendicular to a face [m]
  double bound = 0;                           // distance from the origin to the farthest corner [m]
  double volume = 0;                          // [m^3]
  Vector moments;  // moments of inertia about the axes through the origin, per mass [m^2]

  /** Returns the point that is farthest in a direction. */
  static const Vector& Farthest(std::span<const Vector> points, const Vector& direction) {
    size_t found = 0;
    double most = Dot(points[0], direction);
    for (size_t i = 1; i < points.size(); ++i) {
      const double along = Dot(points[i], direction);
      if (along > most) {
        most = along;
        found = i;
      }
    }
    return points[found];
  }

  /** Returns a face at the corner that is farthest in a direction. Of the faces at this corner,
   *  returns the face that is most perpendicular to the direction. */
  size_t FaceTowards(const Vector& direction) const {
    const auto corner = size_t(&Farthest(corners, direction) - corners.data());
    size_t found = touching[begin[corner]];
    for (uint32_t i = begin[corner] + 1; i < begin[corner + 1]; ++i) {
      if (Dot(normals[touching[i]], direction) > Dot(normals[found], direction)) {
        found = touching[i];
      }
    }
    return found;
  }
};

/** Triangles that are solid on the side from which their corners run counter-clockwise. */
class Surface {
 public:
  struct Triangle {
    std::array<Vector, 3> corners;
    Vector normal;
    /** Bit i is set if the edge from corner i to corner i + 1 is convex or belongs to this triangle
     *  only. Other shapes can touch such an edge from directions between the normals. */
    uint32_t edges = 0;
  };

  Surface(std::span<const Vec3<double>> points, std::span<const int32_t> indices);

  const Triangle& operator[](uint32_t i) const { return triangles_[i]; }
  const Vector& low() const { return low_; }
  const Vector& high() const { return high_; }
  bool empty() const { return triangles_.empty(); }
  /** Appends the triangles whose bounding boxes overlap a box, in ascending order. */
  void Find(const Vector& low, const Vector& high, std::vector<uint32_t>& found) const;

 private:
  struct Node {
    Vector low, high;
    uint32_t first, count;  // range of order_; a node with more than kLeaf has two children
    uint32_t right;         // index of the second child; the first one follows this node
  };
  static constexpr uint32_t kLeaf = 4;

  void FindEdges(std::span<const int32_t> indices, std::span<const Vec3<double>> points);
  uint32_t Build(uint32_t first, uint32_t count);

  std::vector<Triangle> triangles_;
  std::vector<uint32_t> order_;
  std::vector<Node> nodes_;
  Vector low_, high_;
};

/** The form of a mesh in contacts: its convex hull if the mesh moves, and its triangles if not. */
class Form {
 public:
  // A row of the column `meshRanges` contains five ranges. Each range is a pair of first row and
  // number of rows. The ranges are:
  // - corners of the hull, among the points;
  // - corners of its core, among the points;
  // - faces of the hull, among the indices (for each face its number of corners, then the corners);
  // - points of the mesh;
  // - triangles of the mesh, among the indices.
  static constexpr size_t kRanges = 10;
  using Ranges = std::array<int32_t, kRanges>;

  /** Builds the hull. If a range exceeds its column, the form has no hull, or no surface. */
  Form(const Ranges& ranges, std::span<const Vec3<double>> points,
       std::span<const int32_t> indices);

  /** Returns the convex hull; null if the mesh has none. */
  const Polytope* hull() const { return hull_.corners.empty() ? nullptr : &hull_; }
  /** Returns the surface; null if the mesh has no triangles. Builds the surface at the first call.
   *  Not thread-safe. */
  const Surface* surface();
  /** Returns a number that differs for meshes with different points or indices. */
  uint64_t digest() const { return digest_; }

 private:
  void BuildHull(std::span<const int32_t> faces);
  void Measure();

  uint64_t digest_ = 0;
  Polytope hull_;
  std::vector<Vector> corners_, core_, normals_;
  std::vector<uint32_t> first_, around_, begin_, touching_;
  std::span<const Vec3<double>> points_;
  std::span<const int32_t> triangles_;
  std::unique_ptr<Surface> surface_;
};

/** The forms of all meshes, which are built again if the columns change. */
class Forms {
 public:
  template <class Ranges, class Points, class Indices>
  void Update(const Ranges& ranges, const Points& points, const Indices& indices) {
    const Key key{ranges.data(),    points.data(),    indices.data(),
                  ranges.version(), points.version(), indices.version(),
                  ranges.size(),    points.size(),    indices.size()};
    if (key == key_) return;
    key_ = {};
    forms_.clear();
    const bool complete = ranges.present() && points.present() && indices.present();
    for (uint64_t i = 0; complete && i < ranges.size(); ++i) {
      forms_.push_back(std::make_unique<Form>(ranges[i], std::span(points.data(), points.size()),
                                              std::span(indices.data(), indices.size())));
    }
    key_ = key;
  }

  /** Returns the form in a row; null if there is none. */
  Form* Find(int32_t row) const {
    return row >= 0 && size_t(row) < forms_.size() ? forms_[size_t(row)].get() : nullptr;
  }

 private:
  struct Key {
    const void *ranges = nullptr, *points = nullptr, *indices = nullptr;
    uint64_t versions[3] = {}, sizes[3] = {};
    bool operator==(const Key&) const = default;
    Key() = default;
    Key(const void* r, const void* p, const void* i, uint64_t rv, uint64_t pv, uint64_t iv,
        uint64_t rs, uint64_t ps, uint64_t is)
        : ranges(r), points(p), indices(i), versions{rv, pv, iv}, sizes{rs, ps, is} {}
  };

  Key key_;
  std::vector<std::unique_ptr<Form>> forms_;
};

}  // namespace vesper::rigid
