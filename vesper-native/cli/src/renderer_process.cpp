// SPDX-License-Identifier: Apache-2.0
#include "renderer_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "csv.hpp"

extern char** environ;

namespace vesper::cli {
namespace {

constexpr timeval kPatience{120, 0};  // timeout for one picture [s]
constexpr uint32_t kStreamVersion = 3;
constexpr uint32_t kLargestAnswer = 1 << 16;  // [byte]; small, because pictures are written to
                                              // files

enum AnswerStatus : uint32_t { kOk = 0, kOutput = 2 };

/// Runs `program` with `socket` as its standard input and output. The program has its own process
/// group, so Ctrl-C reaches only this process, which then completes its frame and picture.
int Spawn(const std::string& program, int socket, pid_t& pid) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, socket, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, socket, STDOUT_FILENO);
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::string name = program;
  char* const arguments[] = {name.data(), nullptr};
  const int error = posix_spawn(&pid, program.c_str(), &actions, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

}  // namespace

RendererProcess::RendererProcess(const std::string& program) : RendererProcess() {
  program_ = program;
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw RendererError("no connection to " + program + ": " + std::strerror(errno));
  }
  const int error = Spawn(program, ends[1], pid_);
  close(ends[1]);
  if (error != 0) {
    close(ends[0]);
    throw RendererError(program +
                        ", which draws pictures, cannot be started: " + std::strerror(error));
  }
  socket_ = ends[0];
  setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &kPatience, sizeof kPatience);
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience);
  Message hello(Message::kHello);
  hello.PutAll(std::span("VSCN").first<4>()).Put(kStreamVersion);
  Send(hello);
  Await();
}

RendererProcess::~RendererProcess() {
  if (socket_ >= 0) close(socket_);
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);  // no caller needs the picture in progress, if any
  waitpid(pid_, nullptr, 0);
}

void RendererProcess::Send(Message& message) {
  auto rest = message.Bytes();
  while (!rest.empty()) {
    const ssize_t sent = send(socket_, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (sent >= 0) {
      rest = rest.subspan(static_cast<size_t>(sent));
    } else if (errno != EINTR) {
      // The renderer may have sent an answer with the reason before it stopped reading. The
      // function Await reports this answer.
      if (errno == EPIPE || errno == ECONNRESET) Await();
      FailBroken(errno);
    }
  }
}

void RendererProcess::Render(const std::string& path) {
  Message render(Message::kRender);
  render.Put<uint32_t>(1).PutAll(std::span(path));
  Send(render);
  Await();
}

void RendererProcess::Await() {
  std::array<uint32_t, 3> answer;  // status, microseconds, length
  Receive(std::as_writable_bytes(std::span(answer)));
  const auto [status, microseconds, length] = answer;
  if (length > kLargestAnswer) throw RendererError(program_ + " gave an answer without sense");
  std::string reason(length, ' ');
  Receive(std::as_writable_bytes(std::span(reason)));
  if (status == kOutput) throw FileError(reason);
  if (status != kOk) throw RendererError(program_ + ": " + reason);
}

void RendererProcess::Receive(std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = recv(socket_, bytes.data(), bytes.size(), 0);
    if (got > 0)
      bytes = bytes.subspan(static_cast<size_t>(got));
    else if (got == 0)
      FailBroken(0);
    else if (errno != EINTR)
      FailBroken(errno);
  }
}

void RendererProcess::FailBroken(int error) {
  if (error == EAGAIN || error == EWOULDBLOCK) {
    throw RendererError(program_ +
                        " drew no picture in 120 s; ask for a smaller one, or draw less");
  }
  int status = 0;
  kill(pid_, SIGKILL);  // no effect if the process has already ended
  waitpid(pid_, &status, 0);
  pid_ = -1;
  const std::string how = WIFSIGNALED(status)
                              ? "by signal " + std::to_string(WTERMSIG(status))
                              : "with exit code " + std::to_string(WEXITSTATUS(status));
  throw RendererError(program_ + " ended " + how + " before its picture was done");
}

}  // namespace vesper::cli
