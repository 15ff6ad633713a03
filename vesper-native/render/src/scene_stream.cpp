// SPDX-License-Identifier: Apache-2.0
#include "scene_stream.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string_view>
#include <utility>

namespace vesper::render {

static_assert(std::endian::native == std::endian::little, "the stream is copied as it comes");

namespace {

constexpr uint32_t kMaxSide = 8192, kMaxPixels = 1U << 24;
constexpr uint32_t kMaxItems = 1U << 22, kMaxMeshVertices = 1U << 24;
constexpr uint64_t kMaxTexturePixels = 1U << 25;  // total of all textures
constexpr uint32_t kMaxMaterials = 1U << 16;
constexpr uint32_t kNormals = 1, kCoordinates = 2, kColours = 4;  // attributes of a mesh
constexpr size_t kMaxPathBytes = 4095;
constexpr float kMaxMagnitude = 1e15F;

const char* Name(MessageType type) {
  switch (type) {
    case MessageType::kHello:
      return "HELLO";
    case MessageType::kImage:
      return "IMAGE";
    case MessageType::kCamera:
      return "CAMERA";
    case MessageType::kEnvironment:
      return "ENVIRONMENT";
    case MessageType::kMesh:
      return "MESH";
    case MessageType::kInstances:
      return "INSTANCES";
    case MessageType::kSegments:
      return "SEGMENTS";
    case MessageType::kRender:
      return "RENDER";
    case MessageType::kTexture:
      return "TEXTURE";
    case MessageType::kMaterial:
      return "MATERIAL";
    case MessageType::kTriangles:
      return "TRIANGLES";
  }
  return nullptr;
}

template <size_t n>
bool AllWithin(const std::array<float, n>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](float value) { return std::abs(value) <= kMaxMagnitude; });
}

/// Sequential reader of the payload of one message.
class Payload {
 public:
  Payload(const char* name, std::span<const std::byte> bytes) : name_(name), rest_(bytes) {}

  [[noreturn]] void Refuse(const std::string& reason) const {
    throw MalformedStream(std::string(name_) + ": " + reason);
  }

  /// Returns the next `count` values. Throws if the message is too short.
  template <class T>
  std::span<const std::byte> Take(uint64_t count, const char* what) {
    if (count > rest_.size() / sizeof(T)) {
      Refuse(std::string("too short for ") + what + ": " + std::to_string(count * sizeof(T)) +
             " bytes needed, " + std::to_string(rest_.size()) + " left");
    }
    const auto taken = rest_.first(count * sizeof(T));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }

  template <class T>
  T One(const char* what) {
    T value;
    std::memcpy(&value, Take<T>(1, what).data(), sizeof value);
    return value;
  }

  uint32_t IntegerIn(uint32_t low, uint32_t high, const char* what) {
    const auto value = One<uint32_t>(what);
    if (value < low || value > high) RefuseRange(what, value, low, high);
    return value;
  }

  float RealIn(float low, float high, const char* what) {
    const auto value = One<float>(what);
    if (!(value >= low && value <= high)) RefuseRange(what, value, low, high);
    return value;
  }

  Vector3f Vector(const char* what) {
    const auto value = One<std::array<float, 3>>(what);
    if (!AllWithin(value)) Refuse(std::string(what) + " is not finite, or beyond 1e15");
    return {value[0], value[1], value[2]};
  }

  std::span<const std::byte> Rest() { return std::exchange(rest_, {}); }

  void End() const {
    if (!rest_.empty()) Refuse(std::to_string(rest_.size()) + " bytes too many");
  }

 private:
  template <class T>
  [[noreturn]] void RefuseRange(const char* what, T value, T low, T high) const {
    std::ostringstream reason;
    reason << what << " is " << value << ", expected " << low << " to " << high;
    Refuse(reason.str());
  }

  const char* name_;
  std::span<const std::byte> rest_;
};

/// Returns a column of `components` values per row, copied and checked row by row.
template <class T, size_t components>
class Column {
 public:
  using Row = std::array<T, components>;

  Column(Payload& in, uint32_t rows, const char* what)
      : in_(in), what_(what), bytes_(in.Take<T>(uint64_t{rows} * components, what)) {}

  Row operator[](size_t row) const {
    Row value;
    std::memcpy(value.data(), bytes_.data() + row * sizeof value, sizeof value);
    if constexpr (std::is_same_v<T, float>) {
      if (!AllWithin(value)) in_.Refuse(Where(row) + " is not finite, or beyond 1e15");
    }
    return value;
  }

  std::string Where(size_t row) const {
    return std::string(what_) + " of row " + std::to_string(row);
  }

 private:
  Payload& in_;
  const char* what_;
  std::span<const std::byte> bytes_;
};

Vector3f ToVector(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

Image ReadImage(Payload& in) {
  Image image;
  image.width = in.IntegerIn(1, kMaxSide, "width");
  image.height = in.IntegerIn(1, kMaxSide, "height");
  image.samples = in.IntegerIn(0, 16, "samples");
  image.shadows = in.IntegerIn(0, 1, "image flags") == 1;
  if (uint64_t{image.width} * image.height > kMaxPixels) {
    in.Refuse(std::to_string(image.width) + " x " + std::to_string(image.height) +
              " pixels, at most " + std::to_string(kMaxPixels) + " are allowed");
  }
  return image;
}

Camera ReadCamera(Payload& in) {
  Camera camera;
  camera.orthographic = in.IntegerIn(0, 1, "projection") == 1;
  camera.eye = in.Vector("eye");
  camera.target = in.Vector("target");
  camera.up = in.Vector("up");
  camera.extent = camera.orthographic ? in.RealIn(1e-15F, kMaxMagnitude, "height of the view")
                                      : in.RealIn(0.001F, 3.1F, "vertical field of view");
  const Vector3f forward = (camera.target - camera.eye).stableNormalized();
  if (!(forward.norm() > 0.5F)) in.Refuse("eye and target are the same point");
  if (!(forward.cross(camera.up.stableNormalized()).norm() > 1e-4F)) {
    in.Refuse("up is zero or parallel to the line from eye to target");
  }
  return camera;
}

Environment ReadEnvironment(Payload& in) {
  Environment environment;
  environment.top = in.One<Colour>("background at the top");
  environment.bottom = in.One<Colour>("background at the bottom");
  environment.to_light = in.Vector("direction to the light");
  environment.light = in.RealIn(0, 8, "light");
  environment.ambient = in.RealIn(0, 8, "ambient");
  if (!(environment.to_light.stableNorm() > 0)) in.Refuse("direction to the light is zero");
  return environment;
}

Mesh ReadMesh(Payload& in) {
  const uint32_t vertices = in.IntegerIn(0, kMaxItems, "number of vertices");
  const uint32_t triangles = in.IntegerIn(0, kMaxItems, "number of triangles");
  const uint32_t attributes = in.IntegerIn(0, kNormals | kCoordinates | kColours, "attributes");
  const auto rows = [&](uint32_t attribute) {
    return (attributes & attribute) != 0 ? vertices : 0;
  };
  const Column<float, 3> positions(in, vertices, "position");
  const Column<float, 3> normals(in, rows(kNormals), "normal");
  const Column<float, 2> coordinates(in, rows(kCoordinates), "texture coordinates");
  const Column<uint8_t, 4> colours(in, rows(kColours), "vertex colour");
  const Column<uint32_t, 3> corners(in, triangles, "triangle");
  in.End();
  Mesh mesh;
  mesh.positions.reserve(vertices);
  mesh.normals.reserve(rows(kNormals));
  mesh.coordinates.reserve(rows(kCoordinates));
  mesh.colours.reserve(rows(kColours));
  mesh.indices.reserve(size_t{triangles} * 3);
  for (size_t i = 0; i < vertices; ++i) {
    mesh.positions.push_back(ToVector(positions[i]));
  }
  for (size_t i = 0; i < rows(kNormals); ++i) mesh.normals.push_back(ToVector(normals[i]));
  for (size_t i = 0; i < rows(kCoordinates); ++i) mesh.coordinates.push_back(coordinates[i]);
  for (size_t i = 0; i < rows(kColours); ++i) mesh.colours.push_back(colours[i]);
  for (size_t i = 0; i < triangles; ++i) {
    for (const uint32_t index : corners[i]) {
      if (index >= vertices) {
        in.Refuse(corners.Where(i) + " refers to vertex " + std::to_string(index) + " of " +
                  std::to_string(vertices));
      }
      mesh.indices.push_back(index);
    }
  }
  return mesh;
}

Eigen::Quaternionf ToOrientation(const Payload& in, const Column<float, 4>& column, size_t row) {
  const auto [x, y, z, w] = column[row];
  const Eigen::Quaternionf orientation(w, x, y, z);
  if (std::abs(orientation.norm() - 1) > 0.01F) {
    in.Refuse(column.Where(row) + " has the length " + std::to_string(orientation.norm()) +
              ", expected a unit quaternion x y z w");
  }
  return orientation;
}

InstanceBatch ReadInstances(Payload& in) {
  InstanceBatch batch;
  batch.shape = static_cast<Shape>(in.IntegerIn(1, 4, "shape"));
  batch.mesh = in.One<uint32_t>("mesh id");
  batch.material = in.One<uint32_t>("material id");
  batch.first_triangle = in.One<uint32_t>("first triangle");
  batch.triangle_count = in.One<uint32_t>("number of triangles");
  const uint32_t count = in.IntegerIn(0, kMaxItems, "number of instances");
  const Column<float, 3> position(in, count, "position");
  const Column<float, 4> orientation(in, count, "orientation");
  const Column<float, 3> size(in, count, "size");
  const Column<uint8_t, 4> colour(in, count, "colour");
  const Column<uint32_t, 1> flags(in, count, "item flags");
  const Column<uint32_t, 1> item(in, count, "item");
  in.End();
  batch.instances.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    const Vector3f extent = ToVector(size[i]);
    if (extent.minCoeff() < 0) in.Refuse(size.Where(i) + " is negative");
    const uint32_t item_flags = flags[i][0];
    if (item_flags > (kUnlit | kGrid | kFade)) {
      in.Refuse(flags.Where(i) + " has unknown bits: " + std::to_string(item_flags));
    }
    batch.instances.push_back({ToVector(position[i]), ToOrientation(in, orientation, i), extent,
                               colour[i], item_flags, item[i][0]});
  }
  return batch;
}

Texture ReadTexture(Payload& in) {
  Texture texture;
  texture.width = in.IntegerIn(0, kMaxSide, "width");
  texture.height = in.IntegerIn(0, kMaxSide, "height");
  const uint64_t pixels = uint64_t{texture.width} * texture.height;
  if (pixels > kMaxPixels) {
    in.Refuse(std::to_string(pixels) + " pixels, at most " + std::to_string(kMaxPixels) +
              " are allowed");
  }
  const auto bytes = in.Take<uint32_t>(pixels, "pixels");
  const auto* first = reinterpret_cast<const uint8_t*>(bytes.data());
  texture.pixels.assign(first, first + bytes.size());
  return texture;
}

Material ReadMaterial(Payload& in) {
  Material material;
  material.colour = in.One<Colour>("colour");
  material.roughness = in.RealIn(0, 1, "roughness");
  material.metallic = in.RealIn(0, 1, "metallic");
  material.texture = in.One<uint32_t>("texture id");
  return material;
}

void ReadTriangles(Payload& in, std::vector<Triangle>& triangles) {
  const uint32_t count = in.IntegerIn(0, kMaxItems, "number of triangles");
  const Column<float, 9> corners(in, count, "corners");
  const Column<uint8_t, 12> colours(in, count, "colours");
  const Column<uint32_t, 1> item(in, count, "item");
  if (triangles.size() + count > kMaxItems) {
    in.Refuse("more than " + std::to_string(kMaxItems) + " triangles in one picture");
  }
  triangles.reserve(triangles.size() + count);
  for (size_t i = 0; i < count; ++i) {
    const auto at = corners[i];
    const auto bytes = colours[i];
    Triangle triangle;
    for (size_t corner = 0; corner < 3; ++corner) {
      triangle.corners[corner] = {at[3 * corner], at[3 * corner + 1], at[3 * corner + 2]};
      std::copy_n(bytes.begin() + 4 * corner, 4, triangle.colours[corner].begin());
    }
    triangle.item = item[i][0];
    triangles.push_back(triangle);
  }
}

void ReadSegments(Payload& in, std::vector<Segment>& segments) {
  const uint32_t count = in.IntegerIn(0, kMaxItems, "number of segments");
  const float width = in.RealIn(0.25F, 64, "width");
  const Column<float, 3> from(in, count, "from");
  const Column<float, 3> to(in, count, "to");
  const Column<uint8_t, 4> colour(in, count, "colour");
  const Column<uint32_t, 1> item(in, count, "item");
  if (segments.size() + count > kMaxItems) {
    in.Refuse("more than " + std::to_string(kMaxItems) + " segments in one picture");
  }
  segments.reserve(segments.size() + count);
  for (size_t i = 0; i < count; ++i) {
    segments.push_back({ToVector(from[i]), ToVector(to[i]), colour[i], width, item[i][0]});
  }
}

Request ReadRender(Payload& in, bool orthographic) {
  const uint32_t destination = in.IntegerIn(0, 2, "destination");
  if (destination == 2) {
    const uint32_t layers = in.IntegerIn(1, kColourLayer | kDepthLayer | kItemLayer, "layers");
    if (orthographic && (layers & kDepthLayer) != 0) {
      in.Refuse("there is no depth with an orthographic camera");
    }
    return {Request::Kind::kPixels, "", layers};
  }
  const bool to_file = destination == 1;
  const auto bytes = in.Rest();
  const std::string path(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (to_file == path.empty()) {
    in.Refuse(to_file ? "a picture to a file needs a path"
                      : "a picture to the answer has no path, found " +
                            std::to_string(path.size()) + " bytes");
  }
  if (path.size() > kMaxPathBytes || path.find('\0') != std::string::npos) {
    in.Refuse("the path is longer than " + std::to_string(kMaxPathBytes) +
              " bytes or has a zero byte in it");
  }
  return {to_file ? Request::Kind::kFile : Request::Kind::kPng, path, 0};
}

void CheckHello(Payload& in) {
  const auto magic = in.One<std::array<char, 4>>("magic");
  if (std::string_view(magic.data(), magic.size()) != "VSCN") {
    in.Refuse("this is not a scene stream: it does not begin with \"VSCN\"");
  }
  const auto version = in.One<uint32_t>("version");
  if (version != kStreamVersion) {
    in.Refuse("the stream has version " + std::to_string(version) + ", this program speaks " +
              std::to_string(kStreamVersion));
  }
}

}  // namespace

void SceneDecoder::CheckHeader(const MessageHeader& header) const {
  const char* name = Name(static_cast<MessageType>(header.type));
  if (name == nullptr) {
    throw MalformedStream("unknown message type " + std::to_string(header.type));
  }
  if (greeted_ == (header.type == static_cast<uint32_t>(MessageType::kHello))) {
    throw MalformedStream(greeted_ ? std::string("a second HELLO")
                                   : std::string("HELLO must come first, found ") + name);
  }
  if (header.length > kMaxMessageBytes) {
    throw MalformedStream(std::string(name) + ": " + std::to_string(header.length) +
                          " bytes long, at most " + std::to_string(kMaxMessageBytes) +
                          " are allowed");
  }
}

Request SceneDecoder::Decode(MessageType type, std::span<const std::byte> payload) {
  Payload in(Name(type), payload);
  Request request;
  switch (type) {
    case MessageType::kHello:
      CheckHello(in);
      greeted_ = true;
      request.kind = Request::Kind::kHello;
      break;
    case MessageType::kImage:
      scene_.image = ReadImage(in);
      break;
    case MessageType::kCamera:
      scene_.camera = ReadCamera(in);
      has_camera_ = true;
      break;
    case MessageType::kEnvironment:
      scene_.environment = ReadEnvironment(in);
      break;
    case MessageType::kMesh: {
      const auto id = in.One<uint32_t>("mesh id");
      KeepMesh(id, ReadMesh(in));
      break;
    }
    case MessageType::kInstances:
      AddBatch(ReadInstances(in));
      break;
    case MessageType::kSegments:
      ReadSegments(in, scene_.segments);
      break;
    case MessageType::kTexture: {
      const auto id = in.One<uint32_t>("texture id");
      KeepTexture(id, ReadTexture(in));
      break;
    }
    case MessageType::kMaterial: {
      const auto id = in.One<uint32_t>("material id");
      AddMaterial(id, ReadMaterial(in));
      break;
    }
    case MessageType::kTriangles:
      ReadTriangles(in, scene_.triangles);
      break;
    case MessageType::kRender:
      if (!has_camera_) in.Refuse("no CAMERA came before it");
      request = ReadRender(in, scene_.camera.orthographic);
      break;
  }
  in.End();
  return request;
}

void SceneDecoder::KeepMesh(uint32_t id, Mesh mesh) {
  for (const InstanceBatch& batch : scene_.batches) {
    if (batch.shape == Shape::kMesh && batch.mesh == id) {
      throw MalformedStream("MESH: id " + std::to_string(id) +
                            " is in use by INSTANCES of the same picture");
    }
  }
  scene_.meshes.erase(id);
  if (mesh.positions.empty()) return;
  size_t vertices = mesh.positions.size();
  for (const auto& [other, kept] : scene_.meshes) vertices += kept.positions.size();
  if (vertices > kMaxMeshVertices) {
    throw MalformedStream("MESH: more than " + std::to_string(kMaxMeshVertices) +
                          " vertices in all meshes together");
  }
  mesh.revision = ++revision_;
  scene_.meshes.emplace(id, std::move(mesh));
}

void SceneDecoder::KeepTexture(uint32_t id, Texture texture) {
  if (id == 0) throw MalformedStream("TEXTURE: 0 is no id");
  for (const auto& [other, material] : scene_.materials) {
    if (material.texture == id) {
      throw MalformedStream("TEXTURE: id " + std::to_string(id) +
                            " is in use by a MATERIAL of the same picture");
    }
  }
  scene_.textures.erase(id);
  if (texture.pixels.empty()) return;
  uint64_t bytes = texture.pixels.size();
  for (const auto& [other, kept] : scene_.textures) bytes += kept.pixels.size();
  if (bytes > kMaxTexturePixels * 4) {
    throw MalformedStream("TEXTURE: more than " + std::to_string(kMaxTexturePixels) +
                          " pixels in all textures together");
  }
  texture.revision = ++revision_;
  scene_.textures.emplace(id, std::move(texture));
}

void SceneDecoder::AddMaterial(uint32_t id, Material material) {
  if (material.texture != 0 && !scene_.textures.contains(material.texture)) {
    throw MalformedStream("MATERIAL: texture " + std::to_string(material.texture) +
                          " is not known");
  }
  if (id == 0 || scene_.materials.contains(id)) {
    throw MalformedStream("MATERIAL: id " + std::to_string(id) +
                          (id == 0 ? " is the default" : " is taken in this picture"));
  }
  if (scene_.materials.size() == kMaxMaterials) {
    throw MalformedStream("MATERIAL: more than " + std::to_string(kMaxMaterials) +
                          " in one picture");
  }
  scene_.materials.emplace(id, material);
}

void SceneDecoder::AddBatch(InstanceBatch batch) {
  if (batch.shape == Shape::kMesh && !scene_.meshes.contains(batch.mesh)) {
    throw MalformedStream("INSTANCES: mesh " + std::to_string(batch.mesh) + " is not known");
  }
  if (batch.material != 0 && !scene_.materials.contains(batch.material)) {
    throw MalformedStream("INSTANCES: material " + std::to_string(batch.material) +
                          " is not known");
  }
  const uint64_t triangles =
      batch.shape == Shape::kMesh ? scene_.meshes.at(batch.mesh).indices.size() / 3 : 0;
  if (uint64_t{batch.first_triangle} + batch.triangle_count > triangles) {
    throw MalformedStream("INSTANCES: triangles " + std::to_string(batch.first_triangle) + " to " +
                          std::to_string(uint64_t{batch.first_triangle} + batch.triangle_count) +
                          " of a shape that has " + std::to_string(triangles));
  }
  instance_count_ += batch.instances.size();
  if (instance_count_ > kMaxItems) {
    throw MalformedStream("INSTANCES: more than " + std::to_string(kMaxItems) + " in one picture");
  }
  scene_.batches.push_back(std::move(batch));
}

void SceneDecoder::NextPicture() {
  instance_count_ = 0;
  scene_.batches.clear();
  scene_.segments.clear();
  scene_.triangles.clear();
  scene_.materials.clear();
}

}  // namespace vesper::render
