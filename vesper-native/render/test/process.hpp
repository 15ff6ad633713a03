// SPDX-License-Identifier: Apache-2.0
// A vesper-render process for tests.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "scene_stream.hpp"

namespace vesper::render::test {

struct Outcome {
  int exit_code;  ///< or 128 + signal
  std::string output, errors;
};

inline std::string ReadAll(int file) {
  std::string all;
  char part[65536];
  for (ssize_t got; (got = read(file, part, sizeof part)) > 0;) all.append(part, got);
  close(file);
  return all;
}

/// Runs vesper-render with arguments and an input, which it may leave unread.
inline Outcome RunProgram(const std::vector<std::string>& arguments, const std::string& input) {
  FILE* errors = tmpfile();
  FILE* in = tmpfile();
  fwrite(input.data(), 1, input.size(), in);
  rewind(in);
  int out[2];
  if (pipe(out) != 0) return {-1, "", "pipe"};
  const pid_t child = fork();
  if (child == 0) {
    dup2(fileno(in), STDIN_FILENO);
    dup2(out[1], STDOUT_FILENO);
    dup2(fileno(errors), STDERR_FILENO);
    close(out[0]);
    std::vector<char*> argv{const_cast<char*>(VESPER_RENDER)};
    for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    execv(VESPER_RENDER, argv.data());
    _exit(127);
  }
  close(out[1]);
  Outcome outcome{0, ReadAll(out[0]), ""};
  int status = 0;
  waitpid(child, &status, 0);
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  rewind(errors);
  outcome.errors = ReadAll(dup(fileno(errors)));
  fclose(errors);
  fclose(in);
  return outcome;
}

struct Reply {
  Status status;
  uint32_t microseconds;
  std::string payload;
};

/// Splits an output into replies; an incomplete reply fails the test.
inline std::vector<Reply> Replies(const std::string& output) {
  std::vector<Reply> replies;
  for (size_t at = 0; at < output.size();) {
    AnswerHeader header;
    if (output.size() - at < sizeof header) {
      ADD_FAILURE() << "half an answer";
      break;
    }
    std::memcpy(&header, output.data() + at, sizeof header);
    at += sizeof header;
    if (output.size() - at < header.length) {
      ADD_FAILURE() << "half an answer";
      break;
    }
    replies.push_back({static_cast<Status>(header.status), header.microseconds,
                       output.substr(at, header.length)});
    at += header.length;
  }
  return replies;
}

}  // namespace vesper::render::test
