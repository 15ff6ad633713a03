// SPDX-License-Identifier: Apache-2.0
#include "osmesa.hpp"

#include <GL/osmesa.h>
#include <dlfcn.h>

#include <array>
#include <string>

namespace vesper::render {

namespace {

using Library = std::unique_ptr<void, decltype([](void* library) { dlclose(library); })>;

Library LoadLibrary() {
  std::string reasons;
  for (const char* name : {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}) {
    if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL)) return Library(library);
    reasons += std::string("\n  ") + dlerror();
  }
  throw GraphicsError(
      "the off-screen graphics library OSMesa could not be loaded; install it "
      "(Debian: apt-get install libosmesa6). Tried:" +
      reasons);
}

template <class Function>
Function Resolve(void* library, const char* name) {
  if (void* symbol = dlsym(library, name)) return reinterpret_cast<Function>(symbol);
  throw GraphicsError(std::string("the OSMesa library has no function ") + name +
                      "; version 11.2 or newer is needed");
}

}  // namespace

struct OsMesaContext::State {
  Library library = LoadLibrary();
  decltype(&OSMesaGetProcAddress) find =
      Resolve<decltype(find)>(library.get(), "OSMesaGetProcAddress");
  decltype(&OSMesaDestroyContext) destroy =
      Resolve<decltype(destroy)>(library.get(), "OSMesaDestroyContext");
  OSMesaContext context = nullptr;
  // OSMesa requires a window buffer, but pictures are drawn into framebuffer objects.
  std::array<unsigned char, 16 * 16 * 4> window{};
};

OsMesaContext::OsMesaContext() : state_(std::make_unique<State>()) {
  void* library = state_->library.get();
  const auto create =
      Resolve<decltype(&OSMesaCreateContextAttribs)>(library, "OSMesaCreateContextAttribs");
  const auto make_current = Resolve<decltype(&OSMesaMakeCurrent)>(library, "OSMesaMakeCurrent");
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            3,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            3,
                            0};
  state_->context = create(attributes, nullptr);
  if (state_->context == nullptr) {
    throw GraphicsError(
        "the OSMesa library offers no OpenGL 3.3 core context; a Mesa built with "
        "the llvmpipe or softpipe driver is needed");
  }
  if (!make_current(state_->context, state_->window.data(), GL_UNSIGNED_BYTE, 16, 16)) {
    state_->destroy(state_->context);
    throw GraphicsError("the OSMesa library could not make its context current");
  }
}

OsMesaContext::~OsMesaContext() { state_->destroy(state_->context); }

OsMesaContext::Function OsMesaContext::Find(const char* name) const { return state_->find(name); }

}  // namespace vesper::render
