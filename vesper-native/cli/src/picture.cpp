// SPDX-License-Identifier: Apache-2.0
#include "picture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vesper::cli {
namespace {

constexpr uint32_t kSphere = 1, kPlane = 3, kMesh = 4;  // codes of shapes in SCENE.md
constexpr uint32_t kUnlit = 1, kGrid = 2, kFade = 4;    // flags of items in SCENE.md
constexpr uint32_t kDefaultMaterial = 0, kNoItem = 0;
constexpr std::array<uint32_t, 2> kAllTriangles{0, 0};
constexpr uint32_t kSamples = 4, kShadows = 1, kPerspective = 0;
constexpr double kFitFov = 34;      // vertical field of view of a fitted camera [degrees]
constexpr double kFitFill = 0.82;   // maximum fraction of the picture that a fitted box fills
constexpr double kGroundSide = 60;  // side of the ground, in sides of the box; its edge is not
                                    // visible, because the ground fades
constexpr double kBallsPerSide = 60;
constexpr double kLineWidth = 1.0 / 200;  // fraction of the picture's height
constexpr Colour kBallColour{52, 152, 219, 255}, kLineColour{110, 118, 130, 255},
    kTriangleColour{230, 180, 80, 255};

using Point = std::array<float, 3>;

Point ToPoint(const Vec3<double>& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

Vec3<double> Normalized(const Vec3<double>& v) { return v * (1 / Length(v)); }

const AnyColumn* Positions(const Scene& scene) {
  const AnyColumn* column = scene.Find("position");
  return column != nullptr && column->is_vector() ? column : nullptr;
}

/// Returns the column of a kind whose values are references to two or three rows with positions;
/// null if the kind has no such column.
const AnyColumn* References(const Scene& scene, const std::string& kind) {
  const AnyColumn* positions = Positions(scene);
  if (positions == nullptr) return nullptr;
  const std::string target = positions->descriptor().kind;
  for (const auto& [name, column] : scene.columns) {
    const auto& property = column.descriptor();
    if (property.kind == kind && property.refers_to != nullptr && property.refers_to == target &&
        (property.components == 2 || property.components == 3)) {
      return &column;
    }
  }
  return nullptr;
}

template <class T>
void PutRepeated(Message& message, const T& value, size_t count) {
  for (size_t i = 0; i < count; ++i) message.Put(value);
}

/// Returns the beginning of an INSTANCES message. Its instances are not rotated and have the same
/// size along all axes.
Message Instances(uint32_t shape, uint32_t mesh, const std::vector<Point>& positions,
                  const std::vector<float>& sizes, const std::vector<Colour>& colours,
                  uint32_t flags) {
  const size_t count = positions.size();
  Message message(Message::kInstances);
  message.Put(shape).Put(mesh).Put(kDefaultMaterial).Put(kAllTriangles);
  message.Put(static_cast<uint32_t>(count)).PutAll(std::span(positions));
  PutRepeated(message, std::array<float, 4>{0, 0, 0, 1}, count);
  for (const float size : sizes) message.Put(Point{size, size, size});
  message.PutAll(std::span(colours));
  PutRepeated(message, flags, count);
  PutRepeated(message, kNoItem, count);
  return message;
}

Colour Mix(const std::vector<Colour>& colours, double t) {
  const double at = std::clamp(t, 0.0, 1.0) * static_cast<double>(colours.size() - 1);
  const size_t first = std::min(static_cast<size_t>(at), colours.size() - 2);
  Colour mixed;
  for (size_t i = 0; i < mixed.size(); ++i) {
    const double a = colours[first][i], b = colours[first + 1][i];
    mixed[i] = static_cast<uint8_t>(std::lround(a + (b - a) * (at - static_cast<double>(first))));
  }
  return mixed;
}

/// Returns the value of a row. The value of a vector is its length.
double Magnitude(const AnyColumn& column, uint64_t row) {
  const uint32_t components = column.descriptor().components;
  if (components == 1) return column.Get(row);
  double squares = 0;
  for (uint32_t c = 0; c < components; ++c) {
    const double value = column.Get(row * components + c);
    squares += value * value;
  }
  return std::sqrt(squares);
}

}  // namespace

Form FormOf(const Scene& scene, const std::string& kind) {
  const AnyColumn* positions = Positions(scene);
  if (positions != nullptr && positions->descriptor().kind == kind) return Form::kBalls;
  const AnyColumn* references = References(scene, kind);
  if (references == nullptr) return Form::kNone;
  return references->descriptor().components == 2 ? Form::kLines : Form::kTriangles;
}

PicturePattern::PicturePattern(const std::string& text) {
  bool found = false;
  for (size_t at = 0; at < text.size(); ++at) {
    std::string& part = found ? after_ : before_;
    if (text[at] != '%') {
      part += text[at];
    } else if (text.substr(at + 1, 1) == "%") {
      part += text[++at];
    } else {
      const size_t end = text.find_first_not_of("0123456789", at + 1);
      const std::string digits = text.substr(at + 1, end - at - 1);
      if (found || end == std::string::npos || text[end] != 'd' || digits.size() > 2 ||
          (!digits.empty() && digits[0] != '0')) {
        throw std::invalid_argument("'" + text +
                                    "': expected one %d or %04d for the frame's number"
                                    " (and %% for a percent sign)");
      }
      digits_ = digits.empty() ? 0 : std::stoul(digits);
      found = true;
      at = end;
    }
  }
  if (!found) {
    throw std::invalid_argument("'" + text +
                                "' has no place for the frame's number, such as "
                                "frame-%04d.png");
  }
}

std::string PicturePattern::For(uint64_t frame) const {
  const std::string number = std::to_string(frame);
  return before_ + std::string(digits_ - std::min(digits_, number.size()), '0') + number + after_;
}

double PictureWriter::Box::Side() const {
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

PictureWriter::PictureWriter(const Scene& scene, PicturePattern pattern, const std::string& program)
    : scene_(scene), pattern_(std::move(pattern)), layers_(MakeLayers()), renderer_(program) {
  SetUp();
}

std::vector<PictureWriter::Layer> PictureWriter::MakeLayers() const {
  std::vector<DrawLine> lines = scene_.drawing.lines;
  if (lines.empty()) {
    for (const auto& [kind, rows] : scene_.rows) {
      if (FormOf(scene_, kind) == Form::kNone) continue;
      lines.emplace_back().kind = kind;
    }
  }
  if (lines.empty()) {
    throw std::runtime_error(scene_.file + ": there is nothing to draw; expected 'position'");
  }
  std::map<std::string, std::vector<size_t>> line_of_row;  // for each kind, the draw line of each
                                                           // row, counted from 1; 0: none
  for (size_t i = 0; i < lines.size(); ++i) {
    auto& line_of = line_of_row[lines[i].kind];
    line_of.resize(scene_.rows.at(lines[i].kind));
    if (lines[i].rows.empty()) std::ranges::fill(line_of, i + 1);
    for (const uint64_t row : lines[i].rows) line_of[row] = i + 1;
  }
  std::vector<Layer> layers;
  for (DrawLine& line : lines) {
    const Form form = FormOf(scene_, line.kind);
    layers.push_back({std::move(line), form, {}});
  }
  for (const auto& [kind, line_of] : line_of_row) {
    for (uint64_t row = 0; row < line_of.size(); ++row) {
      if (line_of[row] != 0) layers[line_of[row] - 1].rows.push_back(row);
    }
  }
  return layers;
}

/// Sends the messages that are the same for all pictures.
void PictureWriter::SetUp() {
  const Drawing& drawing = scene_.drawing;
  Message image(Message::kImage);
  renderer_.Send(image.Put(drawing.width).Put(drawing.height).Put(kSamples).Put(kShadows));
  Message environment(Message::kEnvironment);
  environment.Put(drawing.top).Put(drawing.bottom).Put(Point{-0.5F, 1, 0.4F});
  renderer_.Send(environment.Put(0.65F).Put(0.48F));
  const Box box = BoundsOf();
  radius_ = (box.Side() > 0 ? box.Side() : 1) / kBallsPerSide;
  const Camera from = drawing.camera ? *drawing.camera : Fit(box);
  Message camera(Message::kCamera);
  camera.Put(kPerspective).Put(ToPoint(from.eye)).Put(ToPoint(from.target)).Put(Point{0, 1, 0});
  renderer_.Send(camera.Put(static_cast<float>(from.fov * std::numbers::pi / 180)));
}

PictureWriter::Box PictureWriter::BoundsOf() const {
  const AnyColumn* positions = Positions(scene_);
  if (positions == nullptr || positions->rows() == 0) return {{0, 0, 0}, {0, 0, 0}};
  Box box{positions->GetVector(0), positions->GetVector(0)};
  for (uint64_t row = 1; row < positions->rows(); ++row) {
    const Vec3<double> at = positions->GetVector(row);
    box.low = {std::min(box.low.x, at.x), std::min(box.low.y, at.y), std::min(box.low.z, at.z)};
    box.high = {std::max(box.high.x, at.x), std::max(box.high.y, at.y), std::max(box.high.z, at.z)};
  }
  return box;
}

/// Returns a camera that shows the whole box from above, with its front and one side. A box without
/// extent counts as 1 m wide.
Camera PictureWriter::Fit(const Box& box) const {
  const Vec3<double> back = Normalized({0.48, 0.42, 1});
  const Vec3<double> right = Normalized(Cross(Vec3<double>{0, 1, 0}, back));
  const Vec3<double> up = Cross(back, right), centre = (box.low + box.high) * 0.5;
  const double aspect = static_cast<double>(scene_.drawing.width) / scene_.drawing.height;
  const double slope = std::tan(kFitFov / 2 * std::numbers::pi / 180) * kFitFill;
  double distance = box.Side() > 0 ? 0 : 0.5 / slope;
  for (int i = 0; i < 8; ++i) {
    const Vec3<double> corner =
        Vec3<double>{(i & 1) != 0 ? box.high.x : box.low.x, (i & 2) != 0 ? box.high.y : box.low.y,
                     (i & 4) != 0 ? box.high.z : box.low.z} -
        centre;
    const double nearer = Dot(corner, back);
    distance = std::max({distance, nearer + std::abs(Dot(corner, right)) / (slope * aspect),
                         nearer + std::abs(Dot(corner, up)) / slope});
  }
  return {centre + back * distance, centre, kFitFov};
}

void PictureWriter::WriteFrame(uint64_t frame) {
  mesh_ = 0;
  for (const Layer& layer : layers_) {
    if (layer.rows.empty()) continue;
    if (layer.form == Form::kBalls) SendBalls(layer);
    if (layer.form == Form::kLines) SendLines(layer);
    if (layer.form == Form::kTriangles) SendTriangles(layer);
  }
  if (scene_.drawing.ground) SendGround(*scene_.drawing.ground, BoundsOf());
  renderer_.Render(pattern_.For(frame));
}

void PictureWriter::SendGround(const Ground& ground, const Box& box) {
  const Vec3<double> centre = (box.low + box.high) * 0.5;
  const double side = kGroundSide * std::max(box.Side(), 1e-3);
  Message message = Instances(kPlane, 0, {ToPoint({centre.x, ground.height, centre.z})},
                              {static_cast<float>(side)}, {ground.colour}, kGrid | kFade);
  renderer_.Send(message);
}

void PictureWriter::SendBalls(const Layer& layer) {
  const AnyColumn& positions = *Positions(scene_);
  const AnyColumn* radii = layer.line.radius ? nullptr : scene_.Find("radius");
  std::vector<Point> centres;
  std::vector<float> sizes;
  for (const uint64_t row : layer.rows) {
    const double radius = radii != nullptr ? radii->Get(row) : layer.line.radius.value_or(radius_);
    centres.push_back(ToPoint(positions.GetVector(row)));
    sizes.push_back(static_cast<float>(2 * std::max(radius, 0.0)));
  }
  Message message =
      Instances(kSphere, 0, centres, sizes, ColoursOf(layer), layer.line.unlit ? kUnlit : 0);
  renderer_.Send(message);
}

void PictureWriter::SendLines(const Layer& layer) {
  const AnyColumn& ends = *References(scene_, layer.line.kind);
  const double width =
      layer.line.width.value_or(std::clamp(scene_.drawing.height * kLineWidth, 1.5, 16.0));
  Message message(Message::kSegments);
  message.Put(static_cast<uint32_t>(layer.rows.size())).Put(static_cast<float>(width));
  for (const uint64_t row : layer.rows) message.Put(PositionOf(ends, row, 0));
  for (const uint64_t row : layer.rows) message.Put(PositionOf(ends, row, 1));
  const std::vector<Colour> colours = ColoursOf(layer);
  message.PutAll(std::span(colours));
  PutRepeated(message, kNoItem, layer.rows.size());
  renderer_.Send(message);
}

/// Sends the triangles of the layer as one mesh for each colour.
void PictureWriter::SendTriangles(const Layer& layer) {
  const AnyColumn& corners = *References(scene_, layer.line.kind);
  const std::vector<Colour> colours = ColoursOf(layer);
  std::map<Colour, std::vector<Point>> points;
  for (size_t i = 0; i < layer.rows.size(); ++i) {
    for (uint32_t corner = 0; corner < 3; ++corner) {
      points[colours[i]].push_back(PositionOf(corners, layer.rows[i], corner));
    }
  }
  for (const auto& [colour, positions] : points) {
    const auto count = static_cast<uint32_t>(positions.size());
    const uint32_t id = ++mesh_;
    Message mesh(Message::kMesh);
    mesh.Put(id).Put(count).Put(count / 3).Put<uint32_t>(0).PutAll(std::span(positions));
    for (uint32_t i = 0; i < count; ++i) mesh.Put(i);
    renderer_.Send(mesh);
    Message message =
        Instances(kMesh, id, {Point{0, 0, 0}}, {1}, {colour}, layer.line.unlit ? kUnlit : 0);
    renderer_.Send(message);
  }
}

std::vector<Colour> PictureWriter::ColoursOf(const Layer& layer) const {
  const Paint& paint = layer.line.paint;
  const Colour plain = !paint.colours.empty()       ? paint.colours[0]
                       : layer.form == Form::kBalls ? kBallColour
                       : layer.form == Form::kLines ? kLineColour
                                                    : kTriangleColour;
  std::vector<Colour> colours(layer.rows.size(), plain);
  if (paint.property.empty()) return colours;
  const AnyColumn& column = *scene_.Find(paint.property);
  for (size_t i = 0; i < colours.size(); ++i) {
    const double value = Magnitude(column, layer.rows[i]);
    colours[i] = Mix(paint.colours, (value - paint.low) / (paint.high - paint.low));
  }
  return colours;
}

std::array<float, 3> PictureWriter::PositionOf(const AnyColumn& references, uint64_t row,
                                               uint32_t which) const {
  const AnyColumn& positions = *Positions(scene_);
  const auto& property = references.descriptor();
  const auto at = static_cast<uint64_t>(references.Get(row * property.components + which));
  if (at < positions.rows()) return ToPoint(positions.GetVector(at));
  throw SceneError(scene_.places.at(property.name),
                   "row " + std::to_string(row) + " of '" + property.name + "' refers to row " +
                       std::to_string(at) + " of " + positions.descriptor().kind +
                       ", which does not exist");
}

}  // namespace vesper::cli
