// SPDX-License-Identifier: Apache-2.0
#include "python_laws.hpp"

#include <dlfcn.h>

#include <cstdio>

namespace vesper::python {
namespace {

using Prepare = vesper_status (*)(const vesper_prototype* prototype, const char* source,
                                  const char* text, uint64_t size, char* versions,
                                  uint64_t versions_size, vesper_prepared_library** out,
                                  vesper_error* error);

/// Opens the library with RTLD_GLOBAL, because Python's extension modules search the functions of
/// Python among the global symbols.
void* Open() {
  static void* library = dlopen("libvesper_python.so", RTLD_NOW | RTLD_GLOBAL);
  return library;
}

}  // namespace

vesper_status PreparePython(const vesper_prototype& prototype, const std::string& source,
                            const void* text, uint64_t size, vesper_prepared_library** out,
                            vesper_error* error, std::string* versions) {
  void* library = Open();
  if (library == nullptr) {
    const char* reason = dlerror();
    *error = {};
    error->status = VESPER_LIBRARY_LOAD_FAILED;
    error->law_index = VESPER_NO_LAW;
    error->row = VESPER_NO_ROW;
    std::snprintf(error->message, sizeof error->message,
                  "%s: a law in Python needs the Debian packages python3 and python3-numpy: %s",
                  source.c_str(), reason == nullptr ? "the library cannot be loaded" : reason);
    return error->status;
  }
  const auto prepare = reinterpret_cast<Prepare>(dlsym(library, "vesper_python_prepare"));
  char used[4096] = "";
  const vesper_status status = prepare(&prototype, source.c_str(), static_cast<const char*>(text),
                                       size, used, sizeof used, out, error);
  if (versions != nullptr) *versions = used;
  return status;
}

}  // namespace vesper::python
