// SPDX-License-Identifier: Apache-2.0
#include "law_apart.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "hostile.h"
#include "test_kit.hpp"

namespace vesper::test {
namespace {

using std::chrono::milliseconds;

/// How long something may take that is done in milliseconds; the machine may be busy.
constexpr milliseconds kPatience{60000};

apart::Options TestOptions() {
  return {VESPER_TEST_SANDBOX, uint64_t{256} << 20, false, kPatience};
}

/// An engine whose libraries run in sandboxes.
class ApartEngine : public TestEngine {
 public:
  ApartEngine() : TestEngine({.touches = true}) {
    umask(077);  // as in vesper-host
    apart::Sandbox::BeginFrame(milliseconds(2000));
  }

  vesper_error TryLoadApart(const std::string& library, Parameters parameters = {},
                            const apart::Options& options = TestOptions()) {
    const std::vector<char> bytes = ReadFile(TestLawPath(library));
    vesper_prepared_library* prepared = nullptr;
    const vesper_error refused = Try([&](vesper_error* error) {
      return apart::PrepareApart(*vesper_prototype_standard("si-f64"), options,
                                 std::as_bytes(std::span(bytes)), library + ".so", &prepared,
                                 error);
    });
    if (refused.status != VESPER_OK) return refused;
    std::vector<vesper_parameter> values;
    for (const auto& [name, value] : parameters) {
      values.push_back({sizeof(vesper_parameter), 0, name, value});
    }
    const vesper_error error = Try([&](vesper_error* failure) {
      return vesper_engine_load_prepared(get(), prepared, values.data(),
                                         static_cast<uint32_t>(values.size()), &loaded, failure);
    });
    if (error.status != VESPER_OK) vesper_library_discard(prepared);
    return error;
  }

  vesper_error AdvanceWithin(milliseconds limit, double dt = 0.25, uint32_t steps = 1) {
    apart::Sandbox::BeginFrame(limit);
    return Advance(dt, steps);
  }

  vesper_library_id loaded = 0;
};

class HostileLaw : public testing::Test {
 protected:
  void Load(HostileAct act, double number = 0) {
    engine_.AddBodies(bodies_);
    EXPECT_OK(
        engine_.TryLoadApart("hostile", {{"act", static_cast<double>(act)}, {"number", number}}));
  }
  vesper_error Advance(milliseconds limit = kPatience) { return engine_.AdvanceWithin(limit); }

  Bodies bodies_{8};
  ApartEngine engine_;
};

TEST_F(HostileLaw, WritesItsDeclaredOutputs) {
  Load(BEHAVE);
  EXPECT_OK(Advance());
  EXPECT_EQ(bodies_.acceleration, std::vector<double>(24, 1.0));
}

struct Case {
  const char* name;
  HostileAct act;
  vesper_status status;
  const char* text;
};

class Contained : public HostileLaw, public testing::WithParamInterface<Case> {};

TEST_P(Contained, AndTheNextCallRunsInANewProcess) {
  const auto [name, act, status, text] = GetParam();
  const Bodies before(8);
  Load(act, getpid());
  for (int i = 0; i < 2; ++i) {
    bodies_.position = before.position;
    bodies_.acceleration = before.acceleration;
    const auto start = std::chrono::steady_clock::now();
    const vesper_error error =
        Advance(status == VESPER_LAW_TIMED_OUT ? milliseconds(100) : kPatience);
    EXPECT_LT(std::chrono::steady_clock::now() - start, kPatience);
    EXPECT_STREQ(vesper_status_name(error.status), vesper_status_name(status)) << error.message;
    EXPECT_NE(std::string(error.message).find(text), std::string::npos) << error.message;
    EXPECT_EQ(bodies_.mass, before.mass);
    EXPECT_EQ(bodies_.velocity, before.velocity);
    if (status == VESPER_OK) continue;
    EXPECT_EQ(error.library_id, engine_.loaded);
    EXPECT_NE(std::string(error.message).find("law hostile"), std::string::npos) << error.message;
    EXPECT_EQ(bodies_.acceleration, before.acceleration);
    EXPECT_OK(Try([&](vesper_error* e) { return vesper_engine_clear_fault(engine_.get(), e); }));
  }
}

constexpr Case kCases[] = {
    {"OpenFile", OPEN_FILE, VESPER_OK, ""},
    {"OpenParentMemory", OPEN_PARENT_MEMORY, VESPER_OK, ""},
    {"CreateSocket", CREATE_SOCKET, VESPER_LAW_CRASHED, "system call socket,"},
    {"Fork", FORK, VESPER_LAW_CRASHED, "system call clone,"},
    {"StartThread", START_THREAD, VESPER_LAW_CRASHED, "system call "},
    {"Execute", EXECUTE, VESPER_LAW_CRASHED, "system call execve,"},
    {"TraceParent", TRACE_PARENT, VESPER_LAW_CRASHED, "system call ptrace,"},
    {"KillParent", KILL_PARENT, VESPER_LAW_CRASHED, "system call kill,"},
    {"KillAll", KILL_ALL, VESPER_LAW_CRASHED, "system call kill,"},
    {"StopItself", STOP_ITSELF, VESPER_LAW_CRASHED, "system call tgkill,"},
    {"SetHandler", SET_HANDLER, VESPER_LAW_CRASHED, "system call rt_sigaction,"},
    {"SetLimit", SET_LIMIT, VESPER_LAW_CRASHED, "system call prlimit64,"},
    {"MapCode", MAP_CODE, VESPER_LAW_CRASHED, "system call mmap,"},
    {"WriteNull", WRITE_NULL, VESPER_LAW_CRASHED, "SIGSEGV"},
    {"WriteReadColumn", WRITE_READ_COLUMN_APART, VESPER_LAW_CRASHED, "SIGSEGV"},
    {"Abort", ABORT_APART, VESPER_LAW_CRASHED, "SIGABRT"},
    {"Exit", EXIT_APART, VESPER_LAW_CRASHED, "exit code 7"},
    {"OverflowStack", OVERFLOW_STACK, VESPER_LAW_CRASHED, "SIGSEGV"},
    {"LoopForEver", LOOP_FOR_EVER, VESPER_LAW_TIMED_OUT, "no answer within 100 ms"},
    {"SleepForEver", SLEEP_FOR_EVER, VESPER_LAW_TIMED_OUT, "no answer within 100 ms"},
    {"ShareMemory", SHARE_MEMORY, VESPER_OK, ""},
    {"GrowColumns", GROW_COLUMNS, VESPER_LAW_CRASHED, "SIGBUS"},
    {"FlushDenormals", FLUSH_DENORMALS, VESPER_OK, ""},
    {"ExitAsIfKilled", EXIT_AS_IF_KILLED, VESPER_LAW_CRASHED, "SIGKILL"},
};
INSTANTIATE_TEST_SUITE_P(Acts, Contained, testing::ValuesIn(kCases),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_F(HostileLaw, MustRestBetweenItsCalls) {
  Load(ANSWER_BY_ITSELF);
  vesper_error error{};
  // Many frames are needed, because the law gets little processor time in each pause on a busy
  // machine.
  for (int frame = 0; frame < 300 && error.status == VESPER_OK; ++frame) {
    error = Advance();
    usleep(100000);
  }
  EXPECT_STREQ(vesper_status_name(error.status), "LAW_TIMED_OUT");
  EXPECT_NE(std::string(error.message).find("of processor time between its calls"),
            std::string::npos)
      << error.message;
}

TEST_F(HostileLaw, MayRestForAnyTime) {
  Load(BEHAVE);
  for (int frame = 0; frame < 50; ++frame) {
    EXPECT_OK(engine_.AdvanceWithin(kPatience, 0.001, 20));
    usleep(5000);
  }
}

TEST_F(HostileLaw, GetsNoMoreMemoryThanItsLimit) {
  Load(FILL_MEMORY);
  EXPECT_OK(Advance());
}

TEST_F(HostileLaw, CannotCommitNaN) {
  Load(WRITE_NAN_APART);
  EXPECT_REFUSED(LAW_MISBEHAVED, "position, row 1", Advance());
}

TEST_F(HostileLaw, CannotLoopOverMoreThanAnyMemoryHolds) {
  Load(LOOP_OVER_TOO_MANY);
  EXPECT_REFUSED(LAW_FAILED,
                 "law hostile: parallel_for over 1152921504606846976 elements, expected "
                 "1099511627776 or fewer",
                 Advance());
}

TEST_F(HostileLaw, LogsABoundedNumberOfLines) {
  Load(LOG_LINES);
  EXPECT_OK(Advance());
  ASSERT_GT(engine_.log().size(), 2u);
  EXPECT_NE(engine_.log().front().find("hostile: first"), std::string::npos);
  EXPECT_NE(engine_.log().back().find("more log lines were dropped"), std::string::npos);
}

/// The environment variable VESPER_WILD_WRITES sets the number of writes.
TEST_F(HostileLaw, ChangesOnlyItsOutputsByWildWrites) {
  const char* wanted = std::getenv("VESPER_WILD_WRITES");
  const long writes = wanted != nullptr ? std::atol(wanted) : 2000;
  constexpr size_t kOwn = size_t{1} << 20;
  const std::vector<char> own(kOwn, 'x');
  std::vector<char> memory(own);  // of this process, like that of an engine
  const Bodies before(8);
  Load(WRITE_WILDLY, 1);
  long crashes = 0;
  for (long done = 0; done < writes;) {
    bodies_.position = before.position;
    const vesper_error error = engine_.AdvanceWithin(milliseconds(2000), 0.25, 1);
    done += error.status == VESPER_OK ? 1000 : 1;
    crashes += error.status == VESPER_LAW_CRASHED;
    if (error.status != VESPER_OK) {
      EXPECT_OK(Try([&](vesper_error* e) { return vesper_engine_clear_fault(engine_.get(), e); }));
      // A failed step is not counted, so the law would repeat the same writes.
      EXPECT_OK(Try([&](vesper_error* e) {
        return vesper_engine_set_step_count(engine_.get(),
                                            vesper_engine_step_count(engine_.get()) + 1, 0.25, e);
      }));
    }
    ASSERT_EQ(bodies_.mass, before.mass);
    ASSERT_EQ(bodies_.velocity, before.velocity);
    ASSERT_EQ(bodies_.force, before.force);
    ASSERT_EQ(bodies_.orientation, before.orientation);
    ASSERT_EQ(memory, own);
    if (wanted == nullptr && crashes >= 40) break;
  }
  EXPECT_GT(crashes, 0);
}

TEST(LawApartTest, ConstructorsAreContained) {
  ApartEngine engine;
  Bodies bodies(2);
  engine.AddBodies(bodies);
  EXPECT_OK(engine.TryLoadApart("constructor_opening"));
  EXPECT_OK(engine.AdvanceWithin(kPatience));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "constructor_connecting.so: made the system call socket,",
                 engine.TryLoadApart("constructor_connecting"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "constructor_exiting.so: ended its process: exit code 0",
                 engine.TryLoadApart("constructor_exiting"));
}

/// Runs the laws for 1,000 steps, in this process or in a sandbox, and returns the hash of the
/// state.
uint64_t HashAfterRun(const std::vector<std::string>& laws, bool is_apart, size_t count) {
  ApartEngine engine;
  Bodies bodies(count);
  engine.AddBodies(bodies);
  for (const std::string& law : laws) {
    EXPECT_OK(is_apart ? engine.TryLoadApart(law) : engine.TryLoad(law));
  }
  for (int frame = 0; frame < 100; ++frame) {
    EXPECT_OK(engine.AdvanceWithin(kPatience, 0.001, 10));
  }
  return engine.StateHash();
}

TEST(LawApartTest, HasTheBitsOfTheSameLawInTheEngine) {
  const std::vector<std::string> laws = {"field", "euler_four_stages", "hostile"};
  // A parallel_for divides 3,000 rows into several ranges.
  const uint64_t expected = HashAfterRun(laws, false, 3000);
  EXPECT_EQ(HashAfterRun(laws, true, 3000), expected);
  EXPECT_NE(HashAfterRun({"euler"}, true, 3000), expected);
}

TEST(LawApartTest, KeepsScratchInTheEngine) {
  std::vector<double> results[2];
  for (const bool is_apart : {false, true}) {
    ApartEngine engine;
    Bodies bodies(3);
    engine.AddBodies(bodies);
    EXPECT_OK(is_apart ? engine.TryLoadApart("remembering") : engine.TryLoad("remembering"));
    for (int i = 0; i < 5; ++i) EXPECT_OK(engine.AdvanceWithin(kPatience));
    results[is_apart] = bodies.acceleration;
    results[is_apart].insert(results[is_apart].end(), bodies.position.begin(),
                             bodies.position.end());
  }
  EXPECT_EQ(results[0], results[1]);
}

TEST(LawApartTest, ReceivesRowsThatWereAddedAndEdited) {
  ApartEngine engine;
  Bodies bodies(2);
  engine.AddBodies(bodies);
  EXPECT_OK(engine.TryLoadApart("hostile"));
  EXPECT_OK(engine.AdvanceWithin(kPatience));
  Bodies more(5000);
  EXPECT_OK(engine.Rebind("mass", more.mass, 1));
  EXPECT_OK(engine.Rebind("position", more.position, 3));
  EXPECT_OK(engine.Rebind("velocity", more.velocity, 3));
  EXPECT_OK(engine.Rebind("acceleration", more.acceleration, 3));
  EXPECT_OK(engine.Rebind("externalForce", more.force, 3));
  EXPECT_OK(engine.Rebind("orientation", more.orientation, 4));
  EXPECT_OK(engine.AdvanceWithin(kPatience));
  EXPECT_EQ(more.acceleration, std::vector<double>(15000, 1.0));
}

TEST(LawApartTest, RefusesLawsThatShareFunctionsOrDevices) {
  ApartEngine engine;
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "cannot run apart: it reads a field",
                 engine.TryLoadApart("windy"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "cannot run apart: it provides a field",
                 engine.TryLoadApart("weather"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "cannot run apart: it keeps properties on a device",
                 engine.TryLoadApart("vault"));
}

TEST(LawApartTest, RefusesFilesThatAreNoLibraries) {
  const std::string text = "no library";
  vesper_prepared_library* prepared = nullptr;
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "text.so: ", Try([&](vesper_error* error) {
                   return apart::PrepareApart(*vesper_prototype_standard("si-f64"), TestOptions(),
                                              std::as_bytes(std::span(text)), "text.so", &prepared,
                                              error);
                 }));
}

bool IsAlive(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  return std::getline(file, text) && text.find(") Z ") == std::string::npos;
}

/// Returns a process that a thread of this process has started, or 0.
pid_t Child() {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream file(task.path() / "children");
    if (pid_t pid; file >> pid) return pid;
  }
  return 0;
}

TEST(LawApartTest, IsReplacedIfItIsKilledFromOutside) {
  ApartEngine engine;
  Bodies bodies(2);
  engine.AddBodies(bodies);
  EXPECT_OK(engine.TryLoadApart("hostile"));
  for (int frame = 0; frame < 3; ++frame) {
    const pid_t sandbox = Child();
    ASSERT_GT(sandbox, 0);
    kill(sandbox, SIGKILL);
    bodies.acceleration.assign(6, 0);
    EXPECT_OK(engine.AdvanceWithin(kPatience));
    EXPECT_EQ(bodies.acceleration, std::vector<double>(6, 1.0));
    EXPECT_NE(Child(), sandbox);
  }
}

TEST(LawApartTest, IsContinuedIfItIsStoppedFromOutside) {
  ApartEngine engine;
  Bodies bodies(2);
  engine.AddBodies(bodies);
  EXPECT_OK(engine.TryLoadApart("hostile"));
  const pid_t sandbox = Child();
  ASSERT_GT(sandbox, 0);
  for (int frame = 0; frame < 3; ++frame) {
    kill(sandbox, SIGSTOP);
    bodies.acceleration.assign(6, 0);
    EXPECT_OK(engine.AdvanceWithin(kPatience));
    EXPECT_EQ(bodies.acceleration, std::vector<double>(6, 1.0));
    EXPECT_EQ(Child(), sandbox);
  }
}

/// Runs one disabled test in a process of a user namespace that permits no network namespaces.
/// Returns the exit code of the test.
int RunWithoutNetworkNamespaces(const char* test) {
  const pid_t child = fork();
  if (child == 0) {
    const std::string user = "0 " + std::to_string(geteuid()) + " 1";
    if (unshare(CLONE_NEWUSER) != 0) _exit(70);
    std::ofstream("/proc/self/uid_map") << user;
    std::ofstream limit("/proc/sys/user/max_net_namespaces");
    limit << "0" << std::flush;
    if (!limit) _exit(71);
    setenv("VESPER_TEST_LAYERS", "1", 1);
    execl("/proc/self/exe", "law_apart_test", "--gtest_also_run_disabled_tests",
          (std::string("--gtest_filter=LawApartTest.DISABLED_") + test).c_str(),
          static_cast<char*>(nullptr));
    _exit(72);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(LawApartTest, NamesTheLayersThatTheMachineLacks) {
  EXPECT_EQ(RunWithoutNetworkNamespaces("RefusesAnIncompleteSandbox"), 0);
}

/// This test is a part of the test above, which runs it in another process.
TEST(LawApartTest, DISABLED_RefusesAnIncompleteSandbox) {
  if (std::getenv("VESPER_TEST_LAYERS") == nullptr) return;
  ApartEngine engine;
  Bodies bodies(2);
  engine.AddBodies(bodies);
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED,
                 "hostile.so: this machine lacks network namespace (No space left on device)",
                 engine.TryLoadApart("hostile"));
  apart::Options weak = TestOptions();
  weak.incomplete = true;
  EXPECT_OK(engine.TryLoadApart("hostile", {}, weak));
  EXPECT_OK(engine.AdvanceWithin(kPatience));
  ASSERT_EQ(engine.log().size(), 1u);
  EXPECT_NE(engine.log().front().find("runs apart without network namespace"), std::string::npos);
}

TEST(LawApartTest, EndsWithTheProcessOfTheEngine) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {  // becomes an engine's process, which ends without closing its sandbox
    setenv("VESPER_TEST_PIPE", std::to_string(ends[1]).c_str(), 1);
    execl("/proc/self/exe", "law_apart_test", "--gtest_also_run_disabled_tests",
          "--gtest_filter=LawApartTest.DISABLED_EngineThatIsKilled", static_cast<char*>(nullptr));
    _exit(1);
  }
  close(ends[1]);
  pid_t sandbox = 0;
  ASSERT_EQ(read(ends[0], &sandbox, sizeof sandbox), static_cast<ssize_t>(sizeof sandbox));
  close(ends[0]);
  ASSERT_GT(sandbox, 0);
  EXPECT_TRUE(IsAlive(sandbox));
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  for (int i = 0; i < 1000 && IsAlive(sandbox); ++i) usleep(1000);
  EXPECT_FALSE(IsAlive(sandbox));
}

/// This test is a part of the test above, which runs it in another process.
TEST(LawApartTest, DISABLED_EngineThatIsKilled) {
  const char* pipe_end = std::getenv("VESPER_TEST_PIPE");
  if (pipe_end == nullptr) return;
  ApartEngine engine;
  EXPECT_OK(engine.TryLoadApart("hostile"));
  const pid_t sandbox = Child();
  ASSERT_EQ(write(std::atoi(pipe_end), &sandbox, sizeof sandbox),
            static_cast<ssize_t>(sizeof sandbox));
  for (;;) pause();
}

}  // namespace
}  // namespace vesper::test
