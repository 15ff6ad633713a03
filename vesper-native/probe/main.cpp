// SPDX-License-Identifier: Apache-2.0
// vesper-probe: opens one law library and reports its progress over a pipe.
//
// The engine starts it (see probe_process.cpp) with the library and the pipe as descriptors 3 and
// 4. Its arguments are the library's name for messages, and the time limit [ms].
#include <dlfcn.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "failure.hpp"
#include "law_table.hpp"
#include "probe_report.hpp"

#if defined(__SANITIZE_ADDRESS__)
// A crash must end the probe by a signal, and not by the sanitizer's own exit code.
extern "C" [[gnu::visibility("default")]] const char* __asan_default_options() {
  return "handle_segv=0:handle_sigbus=0:handle_abort=0";
}
#elif defined(__SANITIZE_THREAD__)
extern "C" [[gnu::visibility("default")]] const char* __tsan_default_options() {
  return "handle_segv=0:handle_sigbus=0:handle_abort=0";
}
#endif

namespace {

using vesper::Failure;
using vesper::ProbeStage;

void Report(ProbeStage stage, const vesper_error& error) {
  const vesper::ProbeReport report{stage, error};
  if (write(vesper::kProbeReportFd, &report, sizeof report) != sizeof report) _exit(2);
}

void Enter(ProbeStage stage) { Report(stage, vesper::BlankError()); }

/// Limits the probe's run time, in case the engine that waits for it has died, and disables core
/// files.
void LimitItself(unsigned timeout_ms) {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  alarm(timeout_ms / 1000 + 2);
}

void OpenAndCheck(const std::string& source) {
  const std::string path = "/proc/self/fd/" + std::to_string(vesper::kProbeLibraryFd);
  Enter(ProbeStage::kLoading);
  void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    std::string message = dlerror();
    if (message.starts_with(path + ": ")) message.erase(0, path.size() + 2);
    throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: %s", source.c_str(), message.c_str());
  }
  const auto entry = reinterpret_cast<decltype(&vesper_law_library_entry)>(
      dlsym(handle, VESPER_LAW_LIBRARY_ENTRY));
  if (entry == nullptr) {
    throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: does not export %s", source.c_str(),
                  VESPER_LAW_LIBRARY_ENTRY);
  }
  Enter(ProbeStage::kCallingEntry);
  const vesper_law_library* library = entry();
  Enter(ProbeStage::kReadingTable);
  vesper::LawTable(library, source.c_str());
  Enter(ProbeStage::kUnloading);
  dlclose(handle);
  Enter(ProbeStage::kDone);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "vesper-probe is started by the Vesper engine, not by hand\n");
    return 2;
  }
  LimitItself(static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10)));
  try {
    OpenAndCheck(argv[1]);
  } catch (const Failure& failure) {
    Report(ProbeStage::kDone, failure.error());
  } catch (...) {
    _exit(1);
  }
  _exit(0);
}
