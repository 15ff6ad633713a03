// SPDX-License-Identifier: Apache-2.0
// An off-screen OpenGL 3.3 core context on the CPU, from the OSMesa library found at run time.
#pragma once

#include <memory>
#include <stdexcept>

namespace vesper::render {

/// The graphics library is missing, too old, or refused something; what() says what to do.
class GraphicsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Current on the thread that made it, from construction to destruction; one per process.
class OsMesaContext {
 public:
  /// Throws GraphicsError where no OSMesa library with OpenGL 3.3 core can be loaded.
  OsMesaContext();
  ~OsMesaContext();
  OsMesaContext(const OsMesaContext&) = delete;
  OsMesaContext& operator=(const OsMesaContext&) = delete;

  using Function = void (*)();
  /// The GL function of that name, or null.
  Function Find(const char* name) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vesper::render
