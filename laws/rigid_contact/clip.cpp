// SPDX-License-Identifier: Apache-2.0
#include "clip.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vesper::rigid {
namespace {

// Sine of the greatest angle between two edges that count as parallel. Parallel edges touch along
// their length. Other edges touch at one point.
constexpr double kParallel = 0.02;

/** A polygon during clipping. */
struct Polygon {
  static constexpr int kMost = 2 * Face::kMost;
  std::array<Vector, kMost> corners;
  int count = 0;

  void Add(const Vector& corner) {
    if (count < kMost) corners[count++] = corner;
  }
};

/** Finds the part of a polygon on the inner side of the plane through `at` with the outward normal
 *  `out`. Returns false if this is the whole polygon, and does not write `kept` then. */
bool ClipAt(const Polygon& polygon, const Vector& at, const Vector& out, Polygon& kept) {
  std::array<double, Polygon::kMost> outside;  // distance from the plane, times the length of `out`
  bool is_whole = true;
  for (int i = 0; i < polygon.count; ++i) {
    outside[i] = Dot(polygon.corners[i] - at, out);
    is_whole = is_whole && outside[i] <= 0;
  }
  if (is_whole) return false;
  kept.count = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const int next = i + 1 == polygon.count ? 0 : i + 1;
    const Vector &p = polygon.corners[i], &q = polygon.corners[next];
    const double from = outside[i], to = outside[next];
    if (from <= 0) kept.Add(p);
    if ((from <= 0) == (to <= 0)) continue;
    if (polygon.count == 2 && next == 0) continue;  // an edge has one side only
    kept.Add(p + (q - p) * (from / (from - to)));
  }
  return true;
}

double Area(const Vector& a, const Vector& b, const Vector& c, const Vector& normal) {
  return Dot(Cross(b - a, c - a), normal);
}

/** Adds the contact points of two nearly parallel edges: the two ends of the part in which the
 *  edges lie beside each other. */
void AddEdges(const Meeting& meeting, const Face& a, const Face& b, Manifold& manifold) {
  const Vector along = a.corners[1] - a.corners[0], other = b.corners[1] - b.corners[0];
  const double square = Dot(along, along), other_square = Dot(other, other);
  const Vector across = Cross(along, other);
  if (Dot(across, across) > kParallel * kParallel * square * other_square || square == 0) return;
  const double t0 = Dot(b.corners[0] - a.corners[0], along) / square;
  const double t1 = Dot(b.corners[1] - a.corners[0], along) / square;
  const double low = std::max(0.0, std::min(t0, t1)), high = std::min(1.0, std::max(t0, t1));
  if (!(low < high)) return;
  const double radii = meeting.a.radius + meeting.b.radius;
  for (const double t : {low, high}) {
    const Vector on_a = a.corners[0] + along * t;
    const Vector on_b = b.corners[0] + other * ((t - t0) / (t1 - t0));
    const double separation = Dot(on_b - on_a, meeting.normal) - radii;
    if (separation > meeting.margin) continue;
    const Vector surface = on_a + meeting.normal * meeting.a.radius;
    manifold.Add({surface + meeting.normal * (separation / 2), separation});
  }
}

}  // namespace

Vector NormalOf(const Face& face) {
  if (face.count < 3) return {};
  const Vector normal = Cross(face.corners[1] - face.corners[0], face.corners[2] - face.corners[0]);
  const double length = Length(normal);
  return length > 0 ? normal * (1 / length) : Vector{};
}

void Choose(std::span<const ContactPoint> points, const Vector& normal, Manifold& manifold) {
  const ContactPoint* found = points.data();
  const auto count = static_cast<int>(points.size());
  if (count <= Manifold::kMost) {
    for (int i = 0; i < count; ++i) manifold.Add(found[i]);
    return;
  }
  const auto best = [&](auto&& value) {
    int chosen = 0;
    double most = value(found[0]);
    for (int i = 1; i < count; ++i) {
      const double other = value(found[i]);
      if (!(other > most)) continue;
      chosen = i;
      most = other;
    }
    return chosen;
  };
  const int first = best([](const ContactPoint& p) { return -p.separation; });
  const Vector a = found[first].at;
  const int second = best([&](const ContactPoint& p) { return Dot(p.at - a, p.at - a); });
  const Vector b = found[second].at;
  const int left = best([&](const ContactPoint& p) { return Area(a, b, p.at, normal); });
  const int right = best([&](const ContactPoint& p) { return -Area(a, b, p.at, normal); });
  manifold.Add(found[first]);
  manifold.Add(found[second]);
  if (Area(a, b, found[left].at, normal) > 0) manifold.Add(found[left]);
  if (Area(a, b, found[right].at, normal) < 0) manifold.Add(found[right]);
}

void ChooseSteadily(std::span<const ContactPoint> found, const Vector& normal, Manifold& manifold) {
  if (found.size() <= size_t(Manifold::kMost)) return Choose(found, normal, manifold);
  // A point replaces an earlier point only if it is better by this fraction of the extent.
  constexpr double kBetter = 0.05;
  double square = 0, deepest = HUGE_VAL;
  for (const ContactPoint& p : found) {
    square = std::max(square, Dot(p.at - found[0].at, p.at - found[0].at));
    deepest = std::min(deepest, p.separation);
  }
  const double slack = kBetter * std::sqrt(square);
  const auto best = [&](double better, auto&& value) {
    size_t chosen = 0;
    for (size_t i = 1; i < found.size(); ++i) {
      if (value(found[i]) > value(found[chosen]) + better) chosen = i;
    }
    return chosen;
  };
  const double x = std::abs(normal.x), y = std::abs(normal.y);
  const Vector along = Cross(normal, x < y ? Vector{1, 0, 0} : Vector{0, 1, 0});
  const size_t first = best(slack, [&](const ContactPoint& p) { return Dot(p.at, along); });
  const Vector a = found[first].at;
  const size_t second =
      best(kBetter * square, [&](const ContactPoint& p) { return Dot(p.at - a, p.at - a); });
  const Vector b = found[second].at;
  const auto side = [&](double sign) {
    return best(kBetter * square,
                [&](const ContactPoint& p) { return sign * Area(a, b, p.at, normal); });
  };
  const size_t left = side(1), right = side(-1);
  manifold.Add(found[first]);
  if (second != first) manifold.Add(found[second]);
  if (Area(a, b, found[left].at, normal) > 0) manifold.Add(found[left]);
  if (Area(a, b, found[right].at, normal) < 0) manifold.Add(found[right]);
  // A point that is clearly deeper than the chosen points replaces the nearest chosen point.
  double least = HUGE_VAL;
  for (int i = 0; i < manifold.count; ++i) least = std::min(least, manifold.points[i].separation);
  if (deepest > least - 0.2 * slack) return;
  const size_t deep = best(0, [](const ContactPoint& p) { return -p.separation; });
  int nearest = 0;
  const auto distance = [&](int i) {
    const Vector way = manifold.points[i].at - found[deep].at;
    return Dot(way, way);
  };
  for (int i = 1; i < manifold.count; ++i) {
    if (distance(i) < distance(nearest)) nearest = i;
  }
  manifold.points[nearest] = found[deep];
}

void AddClipped(const Clipping& c, Manifold& manifold) {
  std::array<Polygon, 2> polygons;
  Polygon *now = &polygons[0], *other = &polygons[1];
  for (int i = 0; i < c.incident.count; ++i) now->Add(c.incident.corners[i]);
  for (int side = 0; side < c.reference.count && now->count > 0; ++side) {
    const Vector& from = c.reference.corners[side];
    const Vector& to = c.reference.corners[side + 1 == c.reference.count ? 0 : side + 1];
    if (ClipAt(*now, from, Cross(to - from, c.normal), *other)) std::swap(now, other);
  }
  const Polygon& polygon = *now;
  std::array<ContactPoint, Polygon::kMost> found;
  int count = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const double height = Dot(polygon.corners[i] - c.reference.corners[0], c.normal) - c.inset;
    const double separation = height - c.radius;
    if (separation > c.margin) continue;
    const Vector surface = polygon.corners[i] - c.normal * c.radius;
    found[count++] = {surface - c.normal * (separation / 2), separation};
  }
  const auto all = std::span<const ContactPoint>(found).first(size_t(count));
  (c.steady ? ChooseSteadily : Choose)(all, c.normal, manifold);
}

void ClipFaces(const Meeting& meeting, Manifold& manifold) {
  const Vector& n = meeting.normal;
  const Face a = meeting.a.SupportFace(n), b = meeting.b.SupportFace(-n);
  const Vector normal_a = NormalOf(a), normal_b = NormalOf(b);
  const double flat_a = Dot(normal_a, n), flat_b = -Dot(normal_b, n);
  if (std::max(flat_a, flat_b) < kFlat) {
    if (a.count == 2 && b.count == 2) AddEdges(meeting, a, b, manifold);
    return;
  }
  // One face, the incident face, is clipped at the sides of the other face, the reference. The
  // small preference for the first face prevents that the reference alternates between two parallel
  // faces.
  const bool steady = meeting.a.hull != nullptr || meeting.b.hull != nullptr;
  if (flat_a >= flat_b - 1e-3) {
    AddClipped({a, normal_a, b, meeting.b.radius, meeting.a.radius, meeting.margin, steady},
               manifold);
  } else {
    AddClipped({b, normal_b, a, meeting.a.radius, meeting.b.radius, meeting.margin, steady},
               manifold);
  }
}

}  // namespace vesper::rigid
