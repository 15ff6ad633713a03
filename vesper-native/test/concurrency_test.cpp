// SPDX-License-Identifier: Apache-2.0
// Tests laws that run concurrently, and laws that must not.
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

class Pipe {
 public:
  Pipe() { EXPECT_EQ(pipe(ends_.data()), 0); }
  ~Pipe() {
    for (const int end : ends_) close(end);
  }
  double out() const { return ends_[0]; }
  double in() const { return ends_[1]; }

 private:
  std::array<int, 2> ends_{};
};

constexpr double kLong = 60;    // [s], maximum wait of laws that must run concurrently
constexpr double kShort = 0.1;  // [s], maximum wait of laws that must not

class ConcurrencyTest : public BothModes {
 protected:
  TestEngine MakeEngine(uint32_t threads) { return TestEngine({GetParam(), threads}); }

  /// Returns the error of a step in which the first laws of two libraries wait for each other.
  vesper_error Meet(const char* library, const char* other, double patience) {
    Bodies bodies(3);
    TestEngine engine = MakeEngine(2);
    engine.AddBodies(bodies);
    const Pipe first_pipe, second_pipe;
    engine.Load(library, {{"first.tell", second_pipe.in()},
                          {"first.hear", first_pipe.out()},
                          {"first.patience", patience}});
    engine.Load(other, {{"first.tell", first_pipe.in()},
                        {"first.hear", second_pipe.out()},
                        {"first.patience", patience}});
    return engine.Advance(0.1, 1);
  }
};
IN_BOTH_MODES(ConcurrencyTest);

TEST_P(ConcurrencyTest, LawsThatReadTheSameRunAtTheSameTime) {
  EXPECT_OK(Meet("meeting_reader", "meeting_other_reader", kLong));
}

TEST_P(ConcurrencyTest, LawsThatAccumulateRunAtTheSameTime) {
  EXPECT_OK(Meet("meeting_adder", "meeting_other_adder", kLong));
}

TEST_P(ConcurrencyTest, ReaderAndWriterNeverMeet) {
  EXPECT_REFUSED(LAW_FAILED, "nobody came", Meet("meeting_reader", "meeting_writer", kShort));
  EXPECT_REFUSED(LAW_FAILED, "nobody came", Meet("meeting_writer", "meeting_reader", kShort));
}

TEST_P(ConcurrencyTest, LawsOfOneLibraryNeverMeet) {
  Bodies bodies(3);
  TestEngine engine = MakeEngine(2);
  engine.AddBodies(bodies);
  const Pipe first_pipe, second_pipe;
  engine.Load("meeting_reader", {{"first.tell", second_pipe.in()},
                                 {"first.hear", first_pipe.out()},
                                 {"first.patience", kShort},
                                 {"second.tell", first_pipe.in()},
                                 {"second.hear", second_pipe.out()},
                                 {"second.patience", kShort}});
  const vesper_error error = engine.Advance(0.1, 1);
  EXPECT_REFUSED(LAW_FAILED, "law first: nobody came", error);
}

TEST_P(ConcurrencyTest, LawSeesWhatEarlierLawsWroteAndNotWhatLaterOnesWrite) {
  for (const uint32_t threads : {1u, 2u, 8u}) {
    Bodies bodies(1);
    bodies.position = {10, 20, 30};
    bodies.velocity = {1, 2, 3};
    std::vector<double> spin(3);
    TestEngine engine = MakeEngine(threads);
    engine.AddBodies(bodies);
    EXPECT_OK(engine.Add("angularVelocity", spin, 3));
    engine.Load("relay_spin");
    engine.Load("relay_acceleration");
    engine.Load("relay_velocity");
    EXPECT_OK(engine.Advance(0.1, 1));
    EXPECT_EQ(spin, (std::vector<double>{2, 3, 4})) << threads;
    EXPECT_EQ(bodies.velocity, (std::vector<double>{11, 21, 31})) << threads;
    EXPECT_EQ(bodies.acceleration, (std::vector<double>{11, 21, 31})) << threads;
    EXPECT_OK(engine.Advance(0.1, 1));
    EXPECT_EQ(spin, (std::vector<double>{12, 22, 32})) << threads;
  }
}

/// Loads velocity -> spin after position -> velocity. The second law runs in a later wave than the
/// last law, which conflicts with no law.
struct Relays {
  Relays(TestEngine& engine, bool spin_fails, bool acceleration_fails) {
    engine.AddBodies(bodies);
    EXPECT_OK(engine.Add("angularVelocity", spin, 3));
    engine.Load("relay_velocity");
    engine.Load("relay_spin", {{"fail", spin_fails ? 1 : 0}});
    engine.Load("relay_acceleration", {{"fail", acceleration_fails ? 1 : 0}});
  }

  Bodies bodies{3};
  std::vector<double> spin = std::vector<double>(9);
};

TEST_P(ConcurrencyTest, OfSeveralLawsThatFailTheFirstLoadedIsReported) {
  for (const uint32_t threads : {1u, 2u, 8u}) {
    TestEngine engine = MakeEngine(threads);
    const Relays relays(engine, true, true);
    const vesper_error error = engine.Advance(0.1, 1);
    EXPECT_REFUSED(LAW_FAILED, "law relay_spin: asked to fail", error);
    EXPECT_EQ(error.library_id, 2u) << threads;
    EXPECT_EQ(engine.log(), (std::vector<std::string>{"relay_velocity: ran", "relay_spin: ran"}))
        << threads;
    // A failure that was not reported immediately is never reported.
    EXPECT_OK(engine.Unload(2));
    EXPECT_OK(engine.Unload(3));
    EXPECT_OK(engine.Advance(0.1, 1));
  }
}

TEST_P(ConcurrencyTest, LawThatFailsOnItsOwnIsReported) {
  for (const uint32_t threads : {1u, 2u, 8u}) {
    TestEngine engine = MakeEngine(threads);
    const Relays relays(engine, false, true);
    const vesper_error error = engine.Advance(0.1, 1);
    EXPECT_REFUSED(LAW_FAILED, "law relay_acceleration: asked to fail", error);
    EXPECT_EQ(error.library_id, 3u) << threads;
    EXPECT_EQ(error.stage, 1u) << threads;
  }
}

TEST_P(ConcurrencyTest, LinesOfTheLogComeInOrderOfLoading) {
  for (const uint32_t threads : {1u, 2u, 8u}) {
    TestEngine engine = MakeEngine(threads);
    const Relays relays(engine, false, false);
    EXPECT_OK(engine.Advance(0.1, 2));
    EXPECT_EQ(engine.log(),
              (std::vector<std::string>{"relay_velocity: ran", "relay_spin: ran",
                                        "relay_acceleration: ran", "relay_velocity: ran",
                                        "relay_spin: ran", "relay_acceleration: ran"}))
        << threads;
  }
}

TEST_P(ConcurrencyTest, NumberOfThreadsChangesNoBitOfManyLaws) {
  const auto hash_on = [&](uint32_t threads) {
    Bodies bodies(5000);
    std::vector<double> spin(15000);
    TestEngine engine = MakeEngine(threads);
    engine.AddBodies(bodies);
    EXPECT_OK(engine.Add("angularVelocity", spin, 3));
    for (const char* law : {"field", "push", "field_by_100", "push_again", "euler", "relay_spin",
                            "relay_acceleration", "trace_observe"}) {
      engine.Load(law);
    }
    EXPECT_OK(engine.Advance(1.0 / 240, 10));
    return engine.StateHash();
  };
  const uint64_t expected = hash_on(1);
  for (const uint32_t threads : {2u, 3u, 8u}) EXPECT_EQ(hash_on(threads), expected) << threads;
}

/// Returns the number of threads of this process that do not sleep, without the calling thread.
size_t BusyThreads() {
  size_t busy = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (task.path().filename() == std::to_string(gettid())) continue;
    std::ifstream file(task.path() / "stat");
    const std::string stat(std::istreambuf_iterator<char>(file), {});
    const size_t name_end = stat.rfind(')');  // followed by a space and the state; empty if the
                                              // thread has ended
    busy += name_end != std::string::npos && stat[name_end + 2] != 'S';
  }
  return busy;
}

TEST(IdleTest, ThreadsSleepOnceTheStepsAreDone) {
  for (const uint32_t threads : {2u, 4u}) {  // helpers that wait for the next loop, or none
    Bodies bodies(20000);
    TestEngine engine({.threads = threads});
    engine.AddBodies(bodies);
    engine.Load("field");
    engine.Load("euler");
    EXPECT_OK(engine.Advance(0.1, 10));
    using namespace std::chrono;
    const auto deadline = steady_clock::now() + duration<double>(kLong);
    while (BusyThreads() > 0 && steady_clock::now() < deadline) std::this_thread::yield();
    EXPECT_EQ(BusyThreads(), 0u) << threads << " threads";
  }
}

}  // namespace
}  // namespace vesper::test
