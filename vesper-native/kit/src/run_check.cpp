// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <stdexcept>

#include "expect.hpp"
#include "vesper/kit/check.hpp"

namespace vesper {
namespace {

CheckOutcome RunHere(const Check& check, const Subject& subject) {
  try {
    return {Verdict::kPass, check.run(subject)};
  } catch (const CheckSkipped& skipped) {
    return {Verdict::kSkip, skipped.what()};
  } catch (const std::exception& error) {
    return {Verdict::kFail, error.what()};
  } catch (...) {
    return {Verdict::kFail, "something was thrown that is no std::exception"};
  }
}

void WriteAll(int file, const std::string& text) {
  for (size_t done = 0; done < text.size();) {
    const ssize_t n = write(file, text.data() + done, text.size() - done);
    if (n <= 0) _exit(2);
    done += static_cast<size_t>(n);
  }
}

std::string ReadAll(int file) {
  std::string all;
  char part[4096];
  for (ssize_t n; (n = read(file, part, sizeof part)) > 0;) {
    all.append(part, static_cast<size_t>(n));
  }
  close(file);
  return all;
}

/// The least limit on elapsed time. It is longer than that on processor time, because a process
/// gets little processor time on a busy machine.
constexpr std::chrono::seconds kLeastElapsed = std::chrono::minutes(10);

std::chrono::seconds ElapsedLimit(std::chrono::seconds limit) {
  return std::max(limit, kLeastElapsed);
}

/// Ends the process without a core file after the time limit, even if the law never returns. The
/// limit applies to the processor time of this thread, so a law may use several processors.
void LimitItself(std::chrono::seconds limit) {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  std::signal(SIGXCPU, SIG_DFL);
  std::signal(SIGALRM, SIG_DFL);
  sigevent end{};
  end.sigev_notify = SIGEV_SIGNAL;
  end.sigev_signo = SIGXCPU;
  timer_t timer;
  itimerspec once{};
  once.it_value.tv_sec = limit.count();
  if (timer_create(CLOCK_THREAD_CPUTIME_ID, &end, &timer) == 0) {
    timer_settime(timer, 0, &once, nullptr);
  }
  alarm(static_cast<unsigned>(ElapsedLimit(limit).count()));
}

CheckOutcome FromEnd(int status, std::chrono::seconds limit) {
  if (!WIFSIGNALED(status)) {
    return {Verdict::kFail,
            "the law ended the process with exit code " + std::to_string(WEXITSTATUS(status))};
  }
  if (WTERMSIG(status) == SIGXCPU) {
    return {Verdict::kFail,
            "not done after " + std::to_string(limit.count()) + " s of processor time"};
  }
  if (WTERMSIG(status) == SIGALRM) {
    return {Verdict::kFail, "not done after " + std::to_string(ElapsedLimit(limit).count()) + " s"};
  }
  return {Verdict::kFail, std::string("the law crashed: ") + strsignal(WTERMSIG(status))};
}

}  // namespace

CheckOutcome RunCheck(const Check& check, const Subject& subject, std::chrono::seconds limit) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
  std::fflush(nullptr);  // so that the check does not write buffered lines of this process
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error(std::string("fork: ") + std::strerror(errno));
  if (child == 0) {
    close(ends[0]);
    LimitItself(limit);
    dup2(STDERR_FILENO, STDOUT_FILENO);  // standard output is for the report alone
    const CheckOutcome outcome = RunHere(check, subject);
    WriteAll(ends[1], static_cast<char>('0' + static_cast<int>(outcome.verdict)) + outcome.note);
    _exit(0);
  }
  close(ends[1]);
  const std::string answer = ReadAll(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (answer.empty() || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return FromEnd(status, limit);
  }
  return {static_cast<Verdict>(answer[0] - '0'), answer.substr(1)};
}

}  // namespace vesper
