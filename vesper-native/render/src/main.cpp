// SPDX-License-Identifier: Apache-2.0
// vesper-render: off-screen pictures of scenes. SCENE.md describes its input and output.

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <optional>
#include <string>
#include <string_view>

#include "session.hpp"

namespace {

using namespace vesper::render;

constexpr const char* kHelp =
    R"(usage: vesper-render [--samples N]   scene stream on standard input, answers on the output
       vesper-render --info            what the graphics library offers, as JSON
       vesper-render --version
       vesper-render --help

Draws scenes on the CPU with the OSMesa library. The stream is described in SCENE.md.

  --samples N   at most N samples per pixel, 0 to 16 (default 16: what the library offers);
                0 turns anti-aliasing off

Lowers its own priority (nice 5), because a server whose processors are busy makes frames of
worlds before pictures.

environment: LP_NUM_THREADS   threads that draw (default 2)
exit codes:  0 the input ended   1 failure   2 usage   3 malformed scene stream
             4 no graphics library
)";

/// Returns a text as a JSON string literal.
std::string Quote(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return quoted + '"';
}

int PrintInfo() {
  const GraphicsInfo info = Renderer(16).Info();
  std::printf(
      "{\"version\": \"%s\", \"stream\": %u, \"vendor\": %s, \"renderer\": %s, "
      "\"gl\": %s, \"maxSamples\": %d, \"maxSide\": %d}\n",
      VESPER_RENDER_VERSION, kStreamVersion, Quote(info.vendor).c_str(),
      Quote(info.renderer).c_str(), Quote(info.version).c_str(), info.max_samples, info.max_side);
  return kExitOk;
}

std::optional<uint32_t> ParseSamples(const char* text) {
  char* end;
  const unsigned long value = std::strtoul(text, &end, 10);
  if (*text < '0' || *text > '9' || *end != '\0' || value > 16) return std::nullopt;
  return static_cast<uint32_t>(value);
}

int Main(int argc, char** argv) {
  const std::string_view option = argc > 1 ? argv[1] : "";
  uint32_t max_samples = 16;
  if (argc == 2 && option == "--help") return std::fputs(kHelp, stdout), kExitOk;
  if (argc == 2 && option == "--version") {
    return std::printf("vesper-render %s\n", VESPER_RENDER_VERSION), kExitOk;
  }
  if (argc == 2 && option == "--info") return PrintInfo();
  if (argc == 3 && option == "--samples" && ParseSamples(argv[2])) {
    max_samples = *ParseSamples(argv[2]);
  } else if (argc != 1) {
    std::fprintf(stderr, "vesper-render: bad arguments\n%s", kHelp);
    return kExitUsage;
  }
  if (isatty(STDIN_FILENO)) {
    std::fprintf(stderr, "vesper-render: standard input is a terminal, not a scene stream\n%s",
                 kHelp);
    return kExitUsage;
  }
  // Pictures use only the processor time that the worlds of a busy server leave. The threads that
  // draw inherit this priority.
  [[maybe_unused]] const int priority = nice(5);
  Renderer renderer(max_samples);
  return Session(renderer, STDIN_FILENO, STDOUT_FILENO).Run();
}

}  // namespace

int main(int argc, char** argv) {
  setenv("LP_NUM_THREADS", "2", 0);
  std::signal(SIGPIPE, SIG_IGN);  // write() reports a closed pipe as an error
  try {
    return Main(argc, argv);
  } catch (const GraphicsError& problem) {
    std::fprintf(stderr, "vesper-render: %s\n", problem.what());
    return kExitGraphics;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "vesper-render: %s\n", problem.what());
    return kExitFailure;
  }
}
