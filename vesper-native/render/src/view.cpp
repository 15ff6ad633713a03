// SPDX-License-Identifier: Apache-2.0
#include "view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace vesper::render {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Minimum ratio of the near to the far distance for which a 24-bit depth buffer is precise enough.
constexpr float kNearestToFarthest = 5e-4F;

struct Interval {
  float low = kInfinity, high = -kInfinity;
  void Include(float a, float b) {
    low = std::min(low, a);
    high = std::max(high, b);
  }
};

}  // namespace

float Extent::Radius() const {
  float radius = 0;
  for (const Ball& ball : items) radius = std::max(radius, ball.centre.norm() + ball.radius);
  return radius;
}

View::View(const Camera& camera, const Image& image, const Extent& extent)
    : origin_(camera.target),
      eye_(camera.eye - camera.target),
      forward_((-eye_).stableNormalized()),
      orthographic_(camera.orthographic),
      half_height_(orthographic_ ? camera.extent / 2 : std::tan(camera.extent / 2)),
      image_height_(static_cast<float>(image.height)),
      target_height_(2 * half_height_ * (orthographic_ ? 1 : eye_.norm())),
      fade_radius_(std::max(extent.Radius(), target_height_ / 2)) {
  FitDepth(extent);
  const Vector3f right = forward_.cross(camera.up.stableNormalized()).normalized();
  const Vector3f up = right.cross(forward_);
  const float half_width =
      half_height_ * static_cast<float>(image.width) / static_cast<float>(image.height);
  corner_ = 1 / std::hypot(1.0F, half_height_, half_width);
  Matrix4f view = Matrix4f::Identity();
  view.row(0).head<3>() = right;
  view.row(1).head<3>() = up;
  view.row(2).head<3>() = -forward_;
  view.block<3, 1>(0, 3) = view.block<3, 3>(0, 0) * -eye_;
  Matrix4f projection = Matrix4f::Zero();
  projection(0, 0) = 1 / half_width;
  projection(1, 1) = 1 / half_height_;
  const float depth = far_ - near_;
  if (orthographic_) {
    projection(2, 2) = -2 / depth;
    projection(2, 3) = -(far_ + near_) / depth;
    projection(3, 3) = 1;
  } else {
    projection(2, 2) = -(far_ + near_) / depth;
    projection(2, 3) = -2 * far_ * near_ / depth;
    projection(3, 2) = -1;
  }
  clip_ = projection * view;
}

void View::FitDepth(const Extent& extent) {
  Interval depth;
  for (const auto* balls : {&extent.items, &extent.planes}) {
    for (const Ball& ball : *balls) {
      const float centre = Depth(ball.centre);
      depth.Include(centre - ball.radius, centre + ball.radius);
    }
  }
  const float target = eye_.norm(), reach = extent.fades ? kFadeEnd * fade_radius_ : 0;
  depth.Include(target - reach, target + reach);
  const float margin = 0.01F * (depth.high - depth.low) + 1e-3F * fade_radius_;
  far_ = depth.high + margin;
  near_ = depth.low - margin;
  if (!orthographic_) near_ = std::max(near_, far_ * kNearestToFarthest);
}

Vector4f View::Eye() const {
  Vector4f eye;
  eye << (orthographic_ ? Vector3f(-forward_) : eye_), orthographic_ ? 0.0F : 1.0F;
  return eye;
}

float View::PixelsPerMetre(float depth) const {
  const float height = orthographic_ ? half_height_ : half_height_ * std::max(depth, near_);
  return image_height_ / (2 * height);
}

float View::PixelsPerMetre(const Ball& ball) const {
  float depth = Depth(ball.centre) - ball.radius;
  if (!orthographic_ && depth < near_) {
    // The ball reaches the plane of the eye. All of its visible points are in the cone around the
    // corners of the view, and therefore have a depth in proportion to their distance.
    depth = std::max(depth, corner_ * ((ball.centre - eye_).norm() - ball.radius));
  }
  return PixelsPerMetre(depth);
}

Matrix4f ShadowMatrix(const Vector3f& to_light, std::span<const Ball> casters) {
  const Vector3f z = to_light.stableNormalized();
  const Vector3f x = z.unitOrthogonal();
  Eigen::Matrix3f axes;
  axes << x.transpose(), z.cross(x).transpose(), -z.transpose();
  std::array<Interval, 3> range;
  for (const Ball& ball : casters) {
    const Vector3f centre = axes * ball.centre;
    for (int i = 0; i < 3; ++i) range[i].Include(centre[i] - ball.radius, centre[i] + ball.radius);
  }
  Matrix4f matrix = Matrix4f::Identity();
  for (int i = 0; i < 3; ++i) {
    const float margin = 0.02F * (range[i].high - range[i].low) + 1e-15F;
    const float scale = 1 / (range[i].high - range[i].low + 2 * margin);
    matrix.row(i) << axes.row(i) * scale, (margin - range[i].low) * scale;
  }
  return matrix;
}

void ExpandSegments(std::span<const Segment> segments, const View& view, const Image& image,
                    std::vector<LineVertex>& out) {
  out.clear();
  const Eigen::Vector2f half_image(0.5F * static_cast<float>(image.width),
                                   0.5F * static_cast<float>(image.height));
  for (const Segment& segment : segments) {
    Vector3f from = segment.from - view.origin(), to = segment.to - view.origin();
    const float from_depth = view.Depth(from), to_depth = view.Depth(to);
    if (from_depth < view.near() && to_depth < view.near()) continue;
    const float cut = (view.near() - from_depth) / (to_depth - from_depth);
    if (from_depth < view.near())
      from += cut * (to - from);
    else if (to_depth < view.near())
      to = from + cut * (to - from);

    const Vector4f a = view.clip() * from.homogeneous(), b = view.clip() * to.homogeneous();
    const Eigen::Vector2f along =
        (b.head<2>() / b.w() - a.head<2>() / a.w()).cwiseProduct(half_image);
    if (!(along.norm() > 1e-6F)) continue;
    const Eigen::Vector2f side =
        Eigen::Vector2f(-along.y(), along.x()).normalized() * (segment.width / 2);
    const Eigen::Vector2f offset = side.cwiseQuotient(half_image);
    for (const Vector4f* end : {&a, &b}) {
      for (const float sign : {-1.0F, 1.0F}) {
        const Eigen::Vector2f corner = end->head<2>() + sign * end->w() * offset;
        out.push_back({{corner.x(), corner.y(), end->z(), end->w()}, segment.colour, segment.item});
      }
    }
  }
}

}  // namespace vesper::render
