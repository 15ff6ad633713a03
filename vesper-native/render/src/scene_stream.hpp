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

/// A violation of SCENE.md in the stream. what() contains the message type, what was found and what
/// was expected.
class MalformedStream : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Parts of a picture of raw pixels.
enum Layers : uint32_t { kColourLayer = 1, kDepthLayer = 2, kItemLayer = 4 };

/// The reply that the sender expects after a message.
struct Request {
  enum class Kind { kNothing, kHello, kPng, kFile, kPixels } kind = Kind::kNothing;
  std::string path;     ///< path of the file for kFile
  uint32_t layers = 0;  ///< bits of Layers for kPixels
};

/// Decodes messages into a scene, which collects the items of a picture until it is drawn.
class SceneDecoder {
 public:
  /// Checks a header before its payload is read. Throws MalformedStream.
  void CheckHeader(const MessageHeader& header) const;

  /// Decodes one message. The payload is used during the call only. Throws MalformedStream; the
  /// scene is unusable then.
  Request Decode(MessageType type, std::span<const std::byte> payload);

  /// Returns the scene; valid after Decode has returned a request for a picture.
  const Scene& scene() const { return scene_; }

  /// Removes the data of one picture: all except meshes and textures.
  void NextPicture();

 private:
  void KeepMesh(uint32_t id, Mesh mesh);
  void KeepTexture(uint32_t id, Texture texture);
  void AddMaterial(uint32_t id, Material material);
  void AddBatch(InstanceBatch batch);

  bool greeted_ = false, has_camera_ = false;
  size_t instance_count_ = 0;
  uint64_t revision_ = 0;  // latest revision of meshes and textures
  Scene scene_;
};

}  // namespace vesper::render
