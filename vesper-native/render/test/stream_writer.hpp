// SPDX-License-Identifier: Apache-2.0
// A writer of the scene stream of SCENE.md, independent of the decoder under test.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace vesper::render::test {

/// Writer of one message, value by value.
class Message {
 public:
  explicit Message(uint32_t type) : type_(type) {}

  template <class T>
  Message& Put(T value) {
    payload_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Message& U32(uint32_t value) { return Put(value); }
  Message& F32(float value) { return Put(value); }
  Message& Text(std::string_view text) { return payload_.append(text), *this; }

  const std::string& payload() const { return payload_; }
  std::string Bytes() const {
    const std::array<uint32_t, 2> header{type_, static_cast<uint32_t>(payload_.size())};
    std::string bytes(reinterpret_cast<const char*>(header.data()), sizeof header);
    return bytes + payload_;
  }

 private:
  uint32_t type_;
  std::string payload_;
};

using Vec3 = std::array<float, 3>;
using Rgba = std::array<uint8_t, 4>;

struct Item {
  Vec3 position{}, size{1, 1, 1};
  Rgba colour{200, 200, 200, 255};
  uint32_t flags = 0;
  std::array<float, 4> orientation{0, 0, 0, 1};
  uint32_t item = 0;
};

inline Message Hello() { return Message(1).Text("VSCN").U32(3); }

inline Message Image(uint32_t width, uint32_t height, uint32_t samples, uint32_t flags) {
  return Message(2).U32(width).U32(height).U32(samples).U32(flags);
}

inline Message Perspective(Vec3 eye, Vec3 target, float vertical_fov, Vec3 up = {0, 1, 0}) {
  return Message(3).U32(0).Put(eye).Put(target).Put(up).F32(vertical_fov);
}

inline Message Orthographic(Vec3 eye, Vec3 target, float height, Vec3 up = {0, 1, 0}) {
  return Message(3).U32(1).Put(eye).Put(target).Put(up).F32(height);
}

inline Message Environment(Rgba top, Rgba bottom, Vec3 to_light, float light, float ambient) {
  return Message(4).Put(top).Put(bottom).Put(to_light).F32(light).F32(ambient);
}

inline Message Mesh(uint32_t id, const std::vector<Vec3>& positions,
                    const std::vector<std::array<uint32_t, 3>>& triangles) {
  Message message(5);
  message.U32(id).U32(static_cast<uint32_t>(positions.size()));
  message.U32(static_cast<uint32_t>(triangles.size())).U32(0);
  for (const auto& position : positions) message.Put(position);
  for (const auto& triangle : triangles) message.Put(triangle);
  return message;
}

/// A range of triangles of a mesh, with its material.
struct Part {
  uint32_t material = 0, first_triangle = 0, triangles = 0;
};

inline Message Instances(uint32_t shape, const std::vector<Item>& items, uint32_t mesh = 0,
                         Part part = {}) {
  Message message(6);
  message.U32(shape).U32(mesh).Put(part).U32(static_cast<uint32_t>(items.size()));
  for (const Item& item : items) message.Put(item.position);
  for (const Item& item : items) message.Put(item.orientation);
  for (const Item& item : items) message.Put(item.size);
  for (const Item& item : items) message.Put(item.colour);
  for (const Item& item : items) message.Put(item.flags);
  for (const Item& item : items) message.Put(item.item);
  return message;
}

struct Line {
  Vec3 from, to;
  Rgba colour{0, 0, 0, 255};
  uint32_t item = 0;
};

inline Message Segments(const std::vector<Line>& lines, float width) {
  Message message(7);
  message.U32(static_cast<uint32_t>(lines.size())).F32(width);
  for (const Line& line : lines) message.Put(line.from);
  for (const Line& line : lines) message.Put(line.to);
  for (const Line& line : lines) message.Put(line.colour);
  for (const Line& line : lines) message.Put(line.item);
  return message;
}

/// Returns a TEXTURE message with pixels from the upper left.
inline Message Texture(uint32_t id, uint32_t width, uint32_t height,
                       const std::vector<Rgba>& pixels) {
  Message message(9);
  message.U32(id).U32(width).U32(height);
  for (const Rgba& pixel : pixels) message.Put(pixel);
  return message;
}

inline Message Material(uint32_t id, Rgba colour, float roughness, float metallic,
                        uint32_t texture = 0) {
  return Message(10).U32(id).Put(colour).F32(roughness).F32(metallic).U32(texture);
}

struct Corners {
  std::array<Vec3, 3> positions;
  std::array<Rgba, 3> colours;
  uint32_t item = 0;
};

inline Message Triangles(const std::vector<Corners>& triangles) {
  Message message(11);
  message.U32(static_cast<uint32_t>(triangles.size()));
  for (const Corners& triangle : triangles) message.Put(triangle.positions);
  for (const Corners& triangle : triangles) message.Put(triangle.colours);
  for (const Corners& triangle : triangles) message.Put(triangle.item);
  return message;
}

inline Message RenderToAnswer() { return Message(8).U32(0); }
inline Message RenderToPixels(uint32_t layers) { return Message(8).U32(2).U32(layers); }
inline Message RenderToFile(std::string_view path) { return Message(8).U32(1).Text(path); }

}  // namespace vesper::render::test
