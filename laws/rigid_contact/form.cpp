// SPDX-License-Identifier: Apache-2.0
#include "form.hpp"

#include <algorithm>
#include <cmath>

#include "digest.hpp"

namespace vesper::rigid {
namespace {

/** Returns a range of a column; empty if it exceeds the column. */
template <class T>
std::span<const T> Part(std::span<const T> all, int32_t first, int32_t count) {
  if (first < 0 || count < 0 || uint64_t(first) + uint64_t(count) > all.size()) return {};
  return all.subspan(size_t(first), size_t(count));
}

bool AllFinite(std::span<const Vector> points) {
  return std::ranges::all_of(points, [](const Vector& p) { return std::isfinite(Dot(p, p)); });
}

/** Returns the unit normal of a polygon; 0 if it has no area (M. E. Newell). */
Vector NormalOf(std::span<const Vector> corners, std::span<const uint32_t> around) {
  Vector sum;
  const Vector& origin = corners[around[0]];
  for (size_t i = 1; i + 1 < around.size(); ++i) {
    sum += Cross(corners[around[i]] - origin, corners[around[i + 1]] - origin);
  }
  const double length = Length(sum);
  return length > 0 ? sum * (1 / length) : Vector{};
}

/** Rotates the order of the corners of a face. The first three corners then span the largest
 *  area of three successive corners. Contacts compute the normal of the face from these three
 *  corners. */
void BeginAtWidest(std::span<const Vector> corners, std::span<uint32_t> around) {
  size_t widest = 0;
  double most = -1;
  for (size_t i = 0; i < around.size(); ++i) {
    const Vector &a = corners[around[i]], &b = corners[around[(i + 1) % around.size()]],
                 &c = corners[around[(i + 2) % around.size()]];
    const Vector area = Cross(b - a, c - a);
    if (Dot(area, area) > most) {
      most = Dot(area, area);
      widest = i;
    }
  }
  std::rotate(around.begin(), around.begin() + std::ptrdiff_t(widest), around.end());
}

}  // namespace

Form::Form(const Ranges& r, std::span<const Vec3<double>> points, std::span<const int32_t> indices)
    : points_(Part(points, r[6], r[7])), triangles_(Part(indices, r[8], r[9])) {
  const auto corners = Part(points, r[0], r[1]), core = Part(points, r[2], r[3]);
  corners_.assign(corners.begin(), corners.end());
  core_.assign(core.begin(), core.end());
  Digest digest;
  for (const auto& range : {corners, points_}) {
    digest.Add(uint64_t(range.size()));
    for (const Vector& point : range) digest.Add(point);
  }
  for (const int32_t index : triangles_) digest.Add(uint64_t(uint32_t(index)));
  digest_ = digest.value();
  if (corners_.size() < 4 || core_.empty() || !AllFinite(corners_) || !AllFinite(core_)) return;
  BuildHull(Part(indices, r[4], r[5]));
}

void Form::BuildHull(std::span<const int32_t> faces) {
  first_ = {0};
  for (size_t i = 0; i < faces.size();) {
    const int32_t count = faces[i++];
    if (count < 3 || size_t(count) > faces.size() - i) return;
    for (int32_t k = 0; k < count; ++k) {
      const int32_t corner = faces[i++];
      if (corner < 0 || size_t(corner) >= corners_.size()) return;
      around_.push_back(uint32_t(corner));
    }
    const auto face = std::span(around_).subspan(first_.back());
    BeginAtWidest(corners_, face);
    normals_.push_back(NormalOf(corners_, face));
    first_.push_back(uint32_t(around_.size()));
    if (normals_.back() == Vector{}) return;
  }
  if (normals_.size() < 4) return;
  begin_.assign(corners_.size() + 1, 0);
  for (const uint32_t corner : around_) ++begin_[corner + 1];
  for (size_t i = 0; i < corners_.size(); ++i) {
    if (begin_[i + 1] == 0) return;  // a corner without a face
    begin_[i + 1] += begin_[i];
  }
  touching_.resize(around_.size());
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (uint32_t face = 0; face < normals_.size(); ++face) {
    for (uint32_t i = first_[face]; i < first_[face + 1]; ++i) {
      touching_[next[around_[i]]++] = face;
    }
  }
  Measure();
}

/** Computes thickness, rounding, volume and moments, and publishes the hull if it has a volume. */
void Form::Measure() {
  Polytope hull;
  hull.thickness = hull.rounding = HUGE_VAL;
  for (const Vector& normal : normals_) {
    const double high = Dot(Polytope::Farthest(corners_, normal), normal);
    const double low = Dot(Polytope::Farthest(corners_, -normal), normal);
    hull.thickness = std::min(hull.thickness, high - low);
    hull.rounding = std::min(hull.rounding, high - Dot(Polytope::Farthest(core_, normal), normal));
  }
  double six_volumes = 0;
  Vector squares;  // 60 times the integrals of x^2, y^2 and z^2
  for (uint32_t face = 0; face < normals_.size(); ++face) {
    const Vector& a = corners_[around_[first_[face]]];
    for (uint32_t i = first_[face] + 1; i + 1 < first_[face + 1]; ++i) {
      const Vector &b = corners_[around_[i]], &c = corners_[around_[i + 1]];
      const double part = Dot(a, Cross(b, c));
      const auto square = [](double p, double q, double r) {
        return p * p + q * q + r * r + p * q + q * r + r * p;
      };
      six_volumes += part;
      squares += Vector{square(a.x, b.x, c.x), square(a.y, b.y, c.y), square(a.z, b.z, c.z)} * part;
    }
  }
  for (const Vector& corner : corners_) hull.bound = std::max(hull.bound, Length(corner));
  hull.volume = six_volumes / 6;
  if (!(hull.volume > 0 && hull.thickness > 0) || !std::isfinite(hull.volume)) return;
  const Vector mean = squares * (1 / (10 * six_volumes));
  hull.moments = {mean.y + mean.z, mean.x + mean.z, mean.x + mean.y};
  if (!(hull.rounding > 0)) {  // there is no smaller core, so the hull is its own core
    core_ = corners_;
    hull.rounding = 0;
  }
  hull.corners = corners_;
  hull.core = core_;
  hull.normals = normals_;
  hull.first = first_;
  hull.around = around_;
  hull.begin = begin_;
  hull.touching = touching_;
  hull_ = hull;
}

const Surface* Form::surface() {
  if (!surface_) surface_ = std::make_unique<Surface>(points_, triangles_);
  return surface_->empty() ? nullptr : surface_.get();
}

Surface::Surface(std::span<const Vec3<double>> points, std::span<const int32_t> indices) {
  std::vector<int32_t> kept;
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    Triangle triangle;
    bool valid = true;
    for (size_t k = 0; k < 3; ++k) {
      const int32_t index = indices[i + k];
      valid = valid && index >= 0 && size_t(index) < points.size();
      if (valid) triangle.corners[k] = points[size_t(index)];
    }
    if (!valid || !AllFinite(triangle.corners)) continue;
    const std::array<uint32_t, 3> around = {0, 1, 2};
    triangle.normal = NormalOf(triangle.corners, around);
    if (triangle.normal == Vector{}) continue;
    triangles_.push_back(triangle);
    kept.insert(kept.end(), {indices[i], indices[i + 1], indices[i + 2]});
  }
  if (triangles_.empty()) return;
  FindEdges(kept, points);
  order_.resize(triangles_.size());
  for (uint32_t i = 0; i < order_.size(); ++i) order_[i] = i;
  Build(0, uint32_t(order_.size()));
  low_ = nodes_[0].low;
  high_ = nodes_[0].high;
}

/** Marks the edges that other shapes can touch from directions between the normals of the two
 *  adjacent triangles. */
void Surface::FindEdges(std::span<const int32_t> indices, std::span<const Vec3<double>> points) {
  // Cosine of the angle between two triangles up to which their common edge counts as flat.
  constexpr double kFlat = 0.996;
  // Vertices at the same place count as one vertex.
  std::vector<int32_t> by_place(indices.begin(), indices.end());
  const auto before = [&](int32_t a, int32_t b) {
    const Vector &p = points[size_t(a)], &q = points[size_t(b)];
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
  };
  std::sort(by_place.begin(), by_place.end(), before);
  by_place.erase(std::unique(by_place.begin(), by_place.end(),
                             [&](int32_t a, int32_t b) { return !before(a, b) && !before(b, a); }),
                 by_place.end());
  const auto place = [&](int32_t vertex) {
    return uint64_t(std::lower_bound(by_place.begin(), by_place.end(), vertex, before) -
                    by_place.begin());
  };
  struct Edge {
    uint64_t ends;  // the smaller place first
    uint32_t triangle, side;
    bool reversed;
  };
  std::vector<Edge> edges;
  for (uint32_t t = 0; t < triangles_.size(); ++t) {
    for (uint32_t side = 0; side < 3; ++side) {
      const uint64_t p = place(indices[3 * t + side]), q = place(indices[3 * t + (side + 1) % 3]);
      edges.push_back({std::min(p, q) << 32 | std::max(p, q), t, side, q < p});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return x.ends != y.ends ? x.ends < y.ends : x.triangle < y.triangle;
  });
  for (size_t i = 0; i < edges.size();) {
    size_t end = i + 1;
    while (end < edges.size() && edges[end].ends == edges[i].ends) ++end;
    bool open = true;
    if (end - i == 2 && edges[i].reversed != edges[i + 1].reversed) {
      const Triangle &a = triangles_[edges[i].triangle], &b = triangles_[edges[i + 1].triangle];
      const Vector& opposite = b.corners[(edges[i + 1].side + 2) % 3];
      const bool convex = Dot(opposite - a.corners[0], a.normal) < 0;
      open = convex && Dot(a.normal, b.normal) < kFlat;
    }
    for (; i < end; ++i) {
      if (open) triangles_[edges[i].triangle].edges |= 1u << edges[i].side;
    }
  }
}

uint32_t Surface::Build(uint32_t first, uint32_t count) {
  const auto index = uint32_t(nodes_.size());
  Node node{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, first, count, 0};
  for (uint32_t i = first; i < first + count; ++i) {
    for (const Vector& p : triangles_[order_[i]].corners) {
      node.low = {std::min(node.low.x, p.x), std::min(node.low.y, p.y), std::min(node.low.z, p.z)};
      node.high = {std::max(node.high.x, p.x), std::max(node.high.y, p.y),
                   std::max(node.high.z, p.z)};
    }
  }
  nodes_.push_back(node);
  if (count <= kLeaf) return index;
  const Vector extent = node.high - node.low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const auto middle = [&](uint32_t t) {
    const auto& c = triangles_[t].corners;
    const Vector sum = c[0] + c[1] + c[2];
    return axis == 0 ? sum.x : axis == 1 ? sum.y : sum.z;
  };
  const auto begin = order_.begin() + first;
  const uint32_t half = count / 2;
  std::nth_element(begin, begin + half, begin + count, [&](uint32_t x, uint32_t y) {
    const double a = middle(x), b = middle(y);
    return a != b ? a < b : x < y;
  });
  Build(first, half);
  const uint32_t right = Build(first + half, count - half);
  nodes_[index].right = right;
  return index;
}

void Surface::Find(const Vector& low, const Vector& high, std::vector<uint32_t>& found) const {
  const auto overlaps = [&](const Vector& from, const Vector& to) {
    return from.x <= high.x && low.x <= to.x && from.y <= high.y && low.y <= to.y &&
           from.z <= high.z && low.z <= to.z;
  };
  std::array<uint32_t, 64> stack;  // the tree of 2^20 triangles has 20 levels
  uint32_t depth = 0;
  const size_t before = found.size();
  if (!nodes_.empty()) stack[depth++] = 0;
  while (depth > 0) {
    const uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    if (!overlaps(node.low, node.high)) continue;
    if (node.count > kLeaf) {
      stack[depth++] = node.right;
      stack[depth++] = index + 1;
      continue;
    }
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      const auto& c = triangles_[order_[i]].corners;
      const Vector from{std::min({c[0].x, c[1].x, c[2].x}), std::min({c[0].y, c[1].y, c[2].y}),
                        std::min({c[0].z, c[1].z, c[2].z})};
      const Vector to{std::max({c[0].x, c[1].x, c[2].x}), std::max({c[0].y, c[1].y, c[2].y}),
                      std::max({c[0].z, c[1].z, c[2].z})};
      if (overlaps(from, to)) found.push_back(order_[i]);
    }
  }
  std::sort(found.begin() + std::ptrdiff_t(before), found.end());
}

}  // namespace vesper::rigid
