// SPDX-License-Identifier: Apache-2.0
// Contact points of hulls and triangles against searches through all their features, and fuzz.
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include "manifold.hpp"
#include "rigid_scene.hpp"

namespace vesper {
namespace {

using rigid::Axes;
using rigid::Form;
using rigid::Manifold;
using rigid::Quaternion;
using rigid::Shape;
using rigid::ShapeCode;
using Vector = Vec3<double>;
using Points = std::vector<Vector>;

/// Draws numbers that are the same on all machines.
struct Draw {
  std::mt19937 random;

  explicit Draw(uint32_t seed) : random(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * random() / 4294967296.0;
  }
  int Below(int count) { return int(random() % uint32_t(count)); }
  Vector In(double half) {
    const double x = (*this)(-half, half), y = (*this)(-half, half), z = (*this)(-half, half);
    return {x, y, z};
  }
  Quaternion Turn() {
    const Vector v = In(1);
    return Quaternion{v, (*this)(0.1, 1)}.Normalised();
  }
};

/// A hull and the memory of its form.
struct Solid {
  explicit Solid(const Points& points) : found(points) {
    RigidScene<double> scene;
    scene.AddForm(points, found.Triangles(), &found);
    Form::Ranges ranges;
    std::copy(scene.mesh_ranges.begin(), scene.mesh_ranges.end(), ranges.begin());
    Points rows(scene.mesh_points.size() / 3);
    for (size_t i = 0; i < rows.size(); ++i) {
      rows[i] = {scene.mesh_points[3 * i], scene.mesh_points[3 * i + 1],
                 scene.mesh_points[3 * i + 2]};
    }
    form = std::make_unique<Form>(ranges, rows, scene.mesh_indices);
  }
  Shape At(const Vector& position, const Quaternion& q) const {
    return Shape::Of(int32_t(ShapeCode::kMesh), {}, position, q, form->hull());
  }

  HullBySearch found;
  std::unique_ptr<Form> form;
};

Points Corners(const Solid& solid, const Shape& shape) {
  Points corners;
  for (const Vector& corner : solid.found.corners) {
    corners.push_back(shape.position + shape.axes.ToWorld(corner));
  }
  return corners;
}

double Separation(const Points& a, const Points& b, const Vector& normal) {
  double high = -HUGE_VAL, low = HUGE_VAL;
  for (const Vector& p : a) high = std::max(high, Dot(p, normal));
  for (const Vector& p : b) low = std::min(low, Dot(p, normal));
  return low - high;
}

/// Returns the largest separation among the normals of all faces and pairs of edges.
double LargestSeparation(const Solid& a, const Shape& at_a, const Solid& b, const Shape& at_b) {
  const Points p = Corners(a, at_a), q = Corners(b, at_b);
  double most = -HUGE_VAL;
  for (const Vector& n : a.found.normals)
    most = std::max(most, Separation(p, q, at_a.axes.ToWorld(n)));
  for (const Vector& n : b.found.normals) {
    most = std::max(most, Separation(p, q, -at_b.axes.ToWorld(n)));
  }
  const auto edges = [](const Solid& solid, const Points& corners) {
    Points all;
    for (const auto& face : solid.found.faces) {
      for (size_t i = 0; i < face.size(); ++i) {
        all.push_back(corners[size_t(face[(i + 1) % face.size()])] - corners[size_t(face[i])]);
      }
    }
    return all;
  };
  for (const Vector& u : edges(a, p)) {
    for (const Vector& v : edges(b, q)) {
      const Vector way = Cross(u, v);
      if (Dot(way, way) < 1e-8 * Dot(u, u) * Dot(v, v)) continue;
      const Vector normal = way * (1 / Length(way));
      most = std::max({most, Separation(p, q, normal), Separation(p, q, -normal)});
    }
  }
  return most;
}

Points Cloud(Draw& draw, int count) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(draw.In(0.5));
  return points;
}

/// Returns the corners of the hull of points only.
Points OnHull(const Points& points) {
  const HullBySearch all(points);
  std::vector<bool> used(points.size());
  for (const auto& face : all.faces) {
    for (const int32_t corner : face) used[size_t(corner)] = true;
  }
  Points corners;
  for (size_t i = 0; i < points.size(); ++i) {
    if (used[i]) corners.push_back(points[i]);
  }
  return corners;
}

TEST(RigidGeometry, FormMeasuresABoxByTheClosedForm) {
  const Solid solid(BoxCorners({1, 2, 3}));
  const rigid::Polytope& hull = *solid.form->hull();
  EXPECT_NEAR(hull.volume, 6, 1e-12);
  EXPECT_NEAR(hull.thickness, 1, 1e-12);
  EXPECT_NEAR(hull.rounding, 0.05, 1e-12);
  EXPECT_LT(Length(hull.moments - Vector{13.0 / 12, 10.0 / 12, 5.0 / 12}), 1e-12);
}

TEST(RigidGeometry, HullsTouchAlongTheDirectionOfLeastOverlap) {
  Draw draw(5);
  constexpr double kMargin = 0.02;
  int touching = 0, deep = 0;
  for (int i = 0; i < 250; ++i) {
    const Solid one(OnHull(Cloud(draw, 8))), other(OnHull(Cloud(draw, 8)));
    const double thickness = std::min(one.found.thickness, other.found.thickness);
    if (thickness < 0.1) continue;
    const Shape a = one.At(draw.In(0.1), draw.Turn());
    Shape b = other.At({}, draw.Turn());
    // Moves the second hull until it overlaps by a drawn depth.
    const Vector way = draw.In(1);
    const double wanted = i % 4 == 0 ? draw(-0.3, -0.1) : draw(-0.02, 0.01);
    double near = 0, far = 3;
    for (int k = 0; k < 40; ++k) {
      b.position = way * (1 / Length(way)) * ((near + far) / 2);
      (LargestSeparation(one, a, other, b) < wanted ? near : far) = (near + far) / 2;
    }
    const double most = LargestSeparation(one, a, other, b);
    const Manifold found = rigid::Collide(a, b, kMargin);
    const Points p = Corners(one, a), q = Corners(other, b);
    if (found.count == 0) {
      ASSERT_GT(most, 0) << "case " << i;  // only a corner beside a corner may be farther
      continue;
    }
    // Only the normals of faces are considered for overlaps deeper than the rounding.
    const bool is_deep = most < -0.04 * thickness;
    ++(is_deep ? deep : touching);
    ASSERT_NEAR(Length(found.normal), 1, 1e-9) << "case " << i;
    const double along = Separation(p, q, found.normal);
    ASSERT_GT(along, is_deep ? 2 * most - 0.1 * thickness : most - 0.05 * thickness)
        << "case " << i;
    double least = HUGE_VAL;
    for (int k = 0; k < found.count; ++k) least = std::min(least, found.points[k].separation);
    ASSERT_NEAR(least, along, 0.03 * thickness + 0.02 * std::abs(along)) << "case " << i;
  }
  EXPECT_GT(touching, 60);
  EXPECT_GT(deep, 20);
}

// The contact of a hull with the corners of a box is that of the box.
TEST(RigidGeometry, HullOfABoxTouchesABoxLikeTheBox) {
  Draw draw(9);
  const Vector size{0.6, 0.8, 1};
  const Solid solid(BoxCorners(size));
  int compared = 0;
  for (int i = 0; i < 800; ++i) {
    const Quaternion q = draw.Turn();
    const Shape hull = solid.At({}, q);
    const Shape box = Shape::Of(int32_t(ShapeCode::kBox), size, {}, q);
    const Shape other =
        Shape::Of(int32_t(ShapeCode::kBox), {1, 0.5, 0.7}, draw.In(0.8), draw.Turn());
    const Manifold by_box = rigid::Collide(box, other, 0.01);
    const Manifold by_hull = rigid::Collide(hull, other, 0.01);
    double least = 0;
    for (int k = 0; k < by_box.count; ++k) least = std::min(least, by_box.points[k].separation);
    if (by_box.count == 0 || least < -0.02) continue;
    ASSERT_GT(by_hull.count, 0) << "case " << i;
    double of_hull = 0;
    for (int k = 0; k < by_hull.count; ++k) {
      of_hull = std::min(of_hull, by_hull.points[k].separation);
    }
    ASSERT_NEAR(of_hull, least, 0.01) << "case " << i;
    ++compared;
  }
  EXPECT_GT(compared, 15);
}

double DistanceToSegment(const Vector& p, const Vector& a, const Vector& b) {
  const double t = std::clamp(Dot(p - a, b - a) / Dot(b - a, b - a), 0.0, 1.0);
  return Length(p - a - (b - a) * t);
}

TEST(RigidGeometry, BallTouchesATriangleAtItsDistance) {
  Draw draw(3);
  int faces = 0, edges = 0;
  for (int i = 0; i < 8000; ++i) {
    const std::array<Vec3<double>, 3> corners = {draw.In(1), draw.In(1), draw.In(1)};
    const std::array<int32_t, 3> indices = {0, 1, 2};
    const rigid::Surface surface(corners, indices);
    if (surface.empty() || Length(Cross(corners[1] - corners[0], corners[2] - corners[0])) < 0.1) {
      continue;
    }
    const Vector normal = surface[0].normal;
    const Vector at = draw.In(1.5);
    const double radius = draw(0.1, 0.5);
    const Shape ball = Shape::Of(int32_t(ShapeCode::kSphere), Vector{2, 2, 2} * radius, at, {});
    const Shape pose = Shape::Of(int32_t(ShapeCode::kBox), {1, 1, 1}, {}, {});
    rigid::SurfaceContacts contacts;
    contacts.Find(surface, pose, ball, 0.01);
    const double height = Dot(at - corners[0], normal);
    bool inside = true;
    double distance = HUGE_VAL;
    for (size_t k = 0; k < 3; ++k) {
      const Vector &p = corners[k], &q = corners[(k + 1) % 3];
      inside = inside && Dot(Cross(q - p, at - p), normal) >= 0;
      distance = std::min(distance, DistanceToSegment(at, p, q));
    }
    if (inside) distance = std::abs(height);
    const double gap = distance - radius;
    if (height < 0 || gap > 0.011) {
      ASSERT_TRUE(contacts.manifolds().empty()) << "case " << i << ", gap " << gap;
    } else if (gap < 0.009 && height > 0.02 * distance) {
      ASSERT_EQ(contacts.manifolds().size(), 1u) << "case " << i << ", gap " << gap;
      // The normal of the face replaces the exact normal for a contact almost above the face.
      ASSERT_NEAR(contacts.manifolds()[0].points[0].separation, gap, 3e-4) << "case " << i;
      ++(inside ? faces : edges);
    }
  }
  EXPECT_GT(faces, 50);
  EXPECT_GT(edges, 50);
}

/// A convex shape of the tests: its extent from its centre along a direction of its own axes.
using Extent = std::function<double(const Vector&)>;

Extent ExtentOfEllipsoid(const Vector& size) {
  return [size](const Vector& d) {
    const double x = size.x * d.x / 2, y = size.y * d.y / 2, z = size.z * d.z / 2;
    return std::sqrt(x * x + y * y + z * z);
  };
}

/// A direction in the world, and the separation of two shapes along it [m].
struct Found {
  Vector normal;
  double separation;
};

/// Returns the largest separation of two convex shapes among all directions. This is their distance
/// if they are apart, and the depth of a small overlap. The search improves the best of many
/// directions by random steps of decreasing length.
Found SeparationBySearch(const Extent& a, const Shape& at_a, const Extent& b, const Shape& at_b,
                         Draw& draw) {
  const Vector way = at_b.position - at_a.position;
  const auto separation = [&](const Vector& n) {
    return Dot(way, n) - a(at_a.axes.ToOwn(n)) - b(at_b.axes.ToOwn(-n));
  };
  Found best{{0, 1, 0}, separation({0, 1, 0})};
  for (int i = 0; i < 3000; ++i) {
    const double step = i < 400 ? 4 : 0.3 * std::pow(10, -6.0 * (i - 400) / 2600);
    const Vector to = best.normal + draw.In(1) * step;
    if (!(Length(to) > 0.01)) continue;
    const Vector n = to * (1 / Length(to));
    const double along = separation(n);
    if (along > best.separation) best = {n, along};
  }
  return best;
}

TEST(RigidGeometry, EllipsoidTouchesOtherShapesAtTheirDistance) {
  Draw draw(12);
  struct Partner {
    ShapeCode code;
    double tolerance;  // boxes, hulls and cylinders are rounded while a direction is sought
    int compared = 0;
  } partners[] = {{ShapeCode::kEllipsoid, 1e-5}, {ShapeCode::kSphere, 1e-5},
                  {ShapeCode::kCapsule, 1e-5},   {ShapeCode::kBox, 5e-3},
                  {ShapeCode::kCylinder, 5e-3},  {ShapeCode::kMesh, 5e-3}};
  for (int i = 0; i < 3000; ++i) {
    Partner& partner = partners[i % 6];
    const Vector extent{draw(0.4, 1), draw(0.4, 1), draw(0.4, 1)};
    const double across = draw(0.3, 0.8), high = across + draw(0, 0.5);
    const Vector size{across, partner.code == ShapeCode::kSphere ? across : high,
                      partner.code == ShapeCode::kBox || partner.code == ShapeCode::kEllipsoid
                          ? draw(0.3, 0.8)
                          : across};
    const Solid solid(BoxCorners(size));
    const Shape egg = Shape::Of(int32_t(ShapeCode::kEllipsoid), extent, draw.In(0.1), draw.Turn());
    const Vector at = draw.In(1);
    const Quaternion q = draw.Turn();
    const Shape other = partner.code == ShapeCode::kMesh
                            ? solid.At(at, q)
                            : Shape::Of(int32_t(partner.code), size, at, q);
    const Extent of_other = [&](const Vector& d) {
      const double round = std::hypot(d.x, d.z) * size.x / 2;
      switch (partner.code) {
        case ShapeCode::kEllipsoid:
          return ExtentOfEllipsoid(size)(d);
        case ShapeCode::kSphere:
          return size.x / 2 * Length(d);
        case ShapeCode::kCapsule:
          return size.x / 2 * Length(d) + std::abs(d.y) * (size.y - size.x) / 2;
        case ShapeCode::kCylinder:
          return round + std::abs(d.y) * size.y / 2;
        default:
          return (std::abs(d.x) * size.x + std::abs(d.y) * size.y + std::abs(d.z) * size.z) / 2;
      }
    };
    const Manifold manifold = rigid::Collide(egg, other, 0.05);
    const double expected =
        SeparationBySearch(ExtentOfEllipsoid(extent), egg, of_other, other, draw).separation;
    if (expected > 0.06) {
      ASSERT_EQ(manifold.count, 0) << "case " << i << ", distance " << expected;
    } else if (expected < 0.045 && expected > -0.005) {
      ASSERT_EQ(manifold.count, 1) << "case " << i << ", distance " << expected;
      const rigid::ContactPoint& point = manifold.points[0];
      ASSERT_NEAR(point.separation, expected, partner.tolerance) << "case " << i;
      // The point is half of the separation above the surface of the ellipsoid.
      const Vector own =
          egg.axes.ToOwn(point.at - manifold.normal * (point.separation / 2) - egg.position);
      const double x = 2 * own.x / extent.x, y = 2 * own.y / extent.y, z = 2 * own.z / extent.z;
      ASSERT_NEAR(x * x + y * y + z * z, 1, 1e-6) << "case " << i;
      ++partner.compared;
    }
  }
  for (const Partner& partner : partners) EXPECT_GT(partner.compared, 10) << int(partner.code);
}

TEST(RigidGeometry, EllipsoidTouchesATriangleAtItsDistance) {
  Draw draw(13);
  int compared = 0;
  for (int i = 0; i < 6000; ++i) {
    const std::array<Vec3<double>, 3> corners = {draw.In(1), draw.In(1), draw.In(1)};
    const std::array<int32_t, 3> indices = {0, 1, 2};
    const rigid::Surface surface(corners, indices);
    if (surface.empty() || Length(Cross(corners[1] - corners[0], corners[2] - corners[0])) < 0.1) {
      continue;
    }
    const Vector extent{draw(0.2, 0.6), draw(0.2, 0.6), draw(0.2, 0.6)};
    const Shape egg = Shape::Of(int32_t(ShapeCode::kEllipsoid), extent, draw.In(1), draw.Turn());
    const Shape pose = Shape::Of(int32_t(ShapeCode::kBox), {1, 1, 1}, {}, {});
    if (Dot(egg.position - corners[0], surface[0].normal) < 0.02) continue;
    const Extent flat = [&](const Vector& d) {
      return std::max({Dot(corners[0], d), Dot(corners[1], d), Dot(corners[2], d)});
    };
    rigid::SurfaceContacts contacts;
    contacts.Find(surface, pose, egg, 0.02);
    const Found found = SeparationBySearch(flat, pose, ExtentOfEllipsoid(extent), egg, draw);
    const double expected = found.separation;
    if (expected > 0.03) {
      ASSERT_TRUE(contacts.manifolds().empty()) << "case " << i << ", distance " << expected;
    } else if (expected < 0.015 && expected > -0.005 &&
               Dot(found.normal, surface[0].normal) > 0.1) {
      ASSERT_EQ(contacts.manifolds().size(), 1u) << "case " << i << ", distance " << expected;
      ASSERT_NEAR(contacts.manifolds()[0].points[0].separation, expected, 2e-3) << "case " << i;
      ++compared;
    }
  }
  EXPECT_GT(compared, 20);
}

// A tree finds the same triangles as a search through all triangles.
TEST(RigidGeometry, SurfaceFindsTheTrianglesInABox) {
  Draw draw(8);
  std::vector<Vec3<double>> points;
  std::vector<int32_t> indices;
  for (int i = 0; i < 300; ++i) {
    const Vector at = draw.In(10);
    for (int k = 0; k < 3; ++k) {
      points.push_back(at + draw.In(1));
      indices.push_back(3 * i + k);
    }
  }
  const rigid::Surface surface(points, indices);
  for (int i = 0; i < 200; ++i) {
    const Vector at = draw.In(10), half{draw(0, 2), draw(0, 2), draw(0, 2)};
    const Vector low = at - half, high = at + half;
    std::vector<uint32_t> found, expected;
    surface.Find(low, high, found);
    for (uint32_t t = 0; t < 300; ++t) {
      const auto& c = surface[t].corners;
      const auto apart = [&](auto&& of) {
        return std::min({of(c[0]), of(c[1]), of(c[2])}) > of(high) ||
               std::max({of(c[0]), of(c[1]), of(c[2])}) < of(low);
      };
      if (!apart([](const Vector& v) { return v.x; }) &&
          !apart([](const Vector& v) { return v.y; }) &&
          !apart([](const Vector& v) { return v.z; })) {
        expected.push_back(t);
      }
    }
    ASSERT_EQ(found, expected);
  }
}

/// Adds a body with a hull that may be flat, thin, tiny or nonsense.
void AddOddHull(RigidScene<double>& scene, Draw& draw, double mass) {
  const Vector at = draw.In(0.8), moving = draw.In(2);
  const int kind = draw.Below(4);
  if (kind == 0) {
    scene.Add(ShapeCode::kMesh, {1, 1, 1}, mass, at, moving, draw.Turn());
    scene.mesh_form.back() = draw.Below(1000) - 500;  // no such mesh
    return;
  }
  Points points = OnHull(Cloud(draw, 6));
  const Vector scale{std::pow(10, draw(-3, 0.5)), std::pow(10, draw(-3, 0.5)), 1};
  if (kind == 1) {
    for (Vector& p : points) p = {p.x * scale.x, p.y * scale.y, p.z};
  }
  scene.AddHull(points, mass, at, moving, draw.Turn());
  if (kind == 2) {  // columns that do not fit together
    scene.mesh_ranges[scene.mesh_ranges.size() - 1 - size_t(draw.Below(10))] = draw.Below(200) - 50;
    if (draw.Below(2) == 0) scene.mesh_indices.back() = draw.Below(100) - 50;
    if (draw.Below(3) == 0) scene.mesh_points.back() = std::nan("");
  }
}

// The environment variable VESPER_FUZZ_SCENES sets the number of scenes.
TEST(RigidGeometry, RandomScenesStayFiniteAndGainNoEnergy) {
  const char* given = std::getenv("VESPER_FUZZ_SCENES");
  const int scenes = given == nullptr ? 60 : std::atoi(given);
  for (int i = 0; i < scenes; ++i) {
    Draw draw(static_cast<uint32_t>(i));
    RigidScene<double> scene;
    scene.has_layers = draw.Below(2) == 0;
    const int bodies = 2 + draw.Below(8);
    double bound = 0;  // energy of the speed at which overlaps are undone [J]
    for (int k = 0; k < bodies; ++k) {
      const double mass = std::pow(10, draw(-6, 6));
      bound += mass * 3 * 3;
      if (draw.Below(3) > 0) {
        AddOddHull(scene, draw, mass);
        continue;
      }
      const ShapeCode codes[] = {ShapeCode::kSphere, ShapeCode::kBox, ShapeCode::kCapsule,
                                 ShapeCode::kCylinder, ShapeCode::kEllipsoid};
      const double across = draw(0.05, 0.6);
      const ShapeCode code = codes[draw.Below(5)];
      scene.Add(code, {across, code == ShapeCode::kSphere ? across : across + draw(0, 1), across},
                mass, draw.In(0.8), draw.In(2), draw.Turn());
    }
    if (draw.Below(2) == 0) {
      scene.AddTerrain(6, 4, [&](double, double) { return draw(-0.5, 0.2); });
    }
    for (size_t k = 0; k < scene.spin.size(); ++k) scene.spin[k] = draw(-3, 3);
    const double begin = scene.KineticEnergy();
    PhysicsEngine engine = scene.MakeRigidEngine();
    engine.Advance(1.0 / 60, 30);
    for (const auto* column : {&scene.position, &scene.velocity, &scene.spin, &scene.orientation}) {
      for (const double value : *column) ASSERT_TRUE(std::isfinite(value)) << "scene " << i;
    }
    // The bodies also spin, at most at 6 rad/s.
    ASSERT_LT(scene.KineticEnergy(), 2 * begin + 40 * bound) << "scene " << i;
  }
}

}  // namespace
}  // namespace vesper
