// SPDX-License-Identifier: Apache-2.0
// The scene stream of SCENE.md: layout of messages and answers, and the decoder, which needs no
// graphics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

#include "scene.hpp"

namespace vesper::render {

inline constexpr uint32_t kStreamVersion = 3;
inline constexpr uint32_t kMaxMessageBytes = 256U << 20;

enum class MessageType : uint32_t {
  kHello = 1,
  kImage = 2,
  kCamera = 3,
  kEnvironment = 4,
  kMesh = 5,
  kInstances = 6,
  kSegments = 7,
  kRender = 8,
  kTexture = 9,
  kMaterial = 10,
  kTriangles = 11,
};

enum class Status : uint32_t { kOk = 0, kMalformed = 1, kOutput = 2, kGraphics = 3 };

struct MessageHeader {
  uint32_t type, length;
};

struct AnswerHeader {
  uint32_t status, microseconds, length;
};

/// The stream breaks a rule of SCENE.md; what() names the message, what was found and expected.
class MalformedStream : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a picture of raw pixels consists of.
enum Layers : uint32_t { kColourLayer = 1, kDepthLayer = 2, kItemLayer = 4 };

/// What the sender waits for after a message.
struct Request {
  enum class Kind { kNothing, kHello, kPng, kFile, kPixels } kind = Kind::kNothing;
  std::string path;     ///< for kFile
  uint32_t layers = 0;  ///< for kPixels: Layers
};

/// Decodes messages into a scene that grows until the renderer took it.
class SceneDecoder {
 public:
  /// Checks a header before a byte of its payload is read. Throws MalformedStream.
  void CheckHeader(const MessageHeader& header) const;

  /// Takes in one message, whose payload the caller keeps only during the call.
  /// Throws MalformedStream; the scene is then of no further use.
  Request Decode(MessageType type, std::span<const std::byte> payload);

  /// Meaningful when Decode asked for a picture.
  const Scene& scene() const { return scene_; }

  /// Forgets what was for one picture only: all but meshes and textures.
  void NextPicture();

 private:
  void KeepMesh(uint32_t id, Mesh mesh);
  void KeepTexture(uint32_t id, Texture texture);
  void AddMaterial(uint32_t id, Material material);
  void AddBatch(InstanceBatch batch);

  bool greeted_ = false, has_camera_ = false;
  size_t instance_count_ = 0;
  uint64_t revision_ = 0;  // the last one of meshes and textures
  Scene scene_;
};

}  // namespace vesper::render
