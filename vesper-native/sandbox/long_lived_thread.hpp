// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <signal.h>

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <queue>
#include <thread>
#include <utility>

namespace vesper::apart {

/// A thread that lives until the process ends. It starts all sandboxes. The kernel ends a sandbox
/// (PR_SET_PDEATHSIG) when the thread that started it ends, and other threads may end while the
/// sandbox is still needed.
class LongLivedThread {
 public:
  static LongLivedThread& Get() {
    static auto* const thread = new LongLivedThread;
    return *thread;
  }

  /// Runs the function on the thread and returns its result.
  int Run(std::function<int()> function) {
    std::packaged_task<int()> task(std::move(function));
    std::future<int> result = task.get_future();
    {
      const std::lock_guard lock(mutex_);
      tasks_.push(std::move(task));
    }
    added_.notify_one();
    return result.get();
  }

 private:
  LongLivedThread() {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    std::thread([this] { Work(); }).detach();
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }

  void Work() {
    for (;;) {
      std::unique_lock lock(mutex_);
      added_.wait(lock, [this] { return !tasks_.empty(); });
      std::packaged_task<int()> task = std::move(tasks_.front());
      tasks_.pop();
      lock.unlock();
      task();
    }
  }

  std::mutex mutex_;
  std::condition_variable added_;
  std::queue<std::packaged_task<int()>> tasks_;
};

}  // namespace vesper::apart
