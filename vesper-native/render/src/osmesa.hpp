// SPDX-License-Identifier: Apache-2.0
// An off-screen OpenGL 3.3 core context on the CPU, from the OSMesa library, which is loaded at run
// time.
#pragma once

#include <memory>
#include <stdexcept>

namespace vesper::render {

/// An error of the graphics library: missing, too old, or a failed call. what() contains the
/// remedy.
class GraphicsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An OpenGL context, current on the thread that created it until destruction; one per process.
class OsMesaContext {
 public:
  /// Creates the context. Throws GraphicsError if no OSMesa library with OpenGL 3.3 core can be
  /// loaded.
  OsMesaContext();
  ~OsMesaContext();
  OsMesaContext(const OsMesaContext&) = delete;
  OsMesaContext& operator=(const OsMesaContext&) = delete;

  using Function = void (*)();
  /// Returns the named GL function, or null.
  Function Find(const char* name) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vesper::render
