// SPDX-License-Identifier: Apache-2.0
// The program `vesper-render`, which draws pictures in a separate process.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace vesper::cli {

/// A failure to start the renderer, to communicate with it, or to draw.
class RendererError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One message of the scene stream; vesper-native/render/SCENE.md lists them.
class Message {
 public:
  enum Type : uint32_t {
    kHello = 1,
    kImage,
    kCamera,
    kEnvironment,
    kMesh,
    kInstances,
    kSegments,
    kRender
  };

  explicit Message(Type type) { Put<uint32_t>(type).Put<uint32_t>(0); }

  template <class T>
  Message& Put(const T& value) {
    return PutAll(std::span(&value, 1));
  }
  template <class T, size_t extent>
  Message& PutAll(std::span<T, extent> values) {
    const auto bytes = std::as_bytes(values);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  /// Returns the message's header and payload.
  std::span<const std::byte> Bytes() {
    const auto length = static_cast<uint32_t>(bytes_.size() - 2 * sizeof(uint32_t));
    std::memcpy(bytes_.data() + sizeof(uint32_t), &length, sizeof length);
    return bytes_;
  }

 private:
  std::vector<std::byte> bytes_;
};

class RendererProcess {
 public:
  /// Starts the program. Throws RendererError.
  explicit RendererProcess(const std::string& program);
  ~RendererProcess();
  RendererProcess(const RendererProcess&) = delete;
  RendererProcess& operator=(const RendererProcess&) = delete;

  void Send(Message& message);
  /// Draws the scene that was sent before, into a PNG file. Throws FileError if the file cannot be
  /// written.
  void Render(const std::string& path);

 private:
  RendererProcess() = default;
  /// Waits for the answer to HELLO or RENDER.
  void Await();
  void Receive(std::span<std::byte> bytes);
  [[noreturn]] void FailBroken(int error);

  std::string program_;
  pid_t pid_ = -1;
  int socket_ = -1;
};

}  // namespace vesper::cli
