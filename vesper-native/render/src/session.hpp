// SPDX-License-Identifier: Apache-2.0
// One session of the scene stream (SCENE.md) over two file descriptors.
#pragma once

#include <cstddef>
#include <vector>

#include "renderer.hpp"
#include "scene_stream.hpp"

namespace vesper::render {

/// Exit codes of vesper-render.
enum ExitCode {
  kExitOk = 0,
  kExitFailure = 1,
  kExitUsage = 2,
  kExitMalformed = 3,
  kExitGraphics = 4
};

class Session {
 public:
  /// Stores the arguments; all three must outlive Run.
  Session(Renderer& renderer, int input, int output)
      : renderer_(renderer), input_(input), output_(output) {}

  /// Serves requests until the input ends or is malformed; returns the exit code.
  int Run();

 private:
  /// Reads a message. Returns false at the end of the input. Throws MalformedStream if the input
  /// ends inside a message.
  bool ReadMessage(MessageHeader& header);
  /// Returns the number of bytes read, which is less than `bytes` only at the end of the input.
  size_t ReadFully(void* to, size_t bytes);
  void Serve(const Request& request);
  void CollectPixels(uint32_t layers);
  void Answer(Status status, uint32_t microseconds, const void* payload, size_t bytes);

  Renderer& renderer_;
  int input_, output_;
  SceneDecoder decoder_;
  std::vector<std::byte> payload_, answer_;
};

}  // namespace vesper::render
