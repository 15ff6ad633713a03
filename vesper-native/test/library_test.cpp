// SPDX-License-Identifier: Apache-2.0
// Tests the loading of a law library from a file into an engine, and its unloading.
#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

vesper_error Prepare(const std::string& library, const EngineOptions& options = {}) {
  const vesper_engine_config config = TestConfig(options);
  vesper_prepared_library* const sentinel = reinterpret_cast<vesper_prepared_library*>(0x10);
  vesper_prepared_library* prepared = sentinel;
  const vesper_error error = Try([&](vesper_error* e) {
    return vesper_library_prepare(&config, library.c_str(), &prepared, e);
  });
  if (error.status == VESPER_OK) {
    vesper_library_discard(prepared);
  } else {
    EXPECT_EQ(prepared, sentinel) << "out-parameters are untouched on failure";
  }
  return error;
}

/// Returns the number of lines of this process's memory map that contain `text`.
size_t CountMapped(const std::string& text) {
  std::ifstream maps("/proc/self/maps");
  size_t count = 0;
  for (std::string line; std::getline(maps, line);) count += line.find(text) != std::string::npos;
  return count;
}

size_t CountOpenFiles() {
  size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    count += entry.is_symlink() ? 1 : 0;
  }
  return count;
}

TEST(LibraryTest, BareNameIsSearchedInTheLawPath) {
  TemporaryFolder first, second;
  std::filesystem::copy_file(TestLawPath("push"), second / "libvesper_law_pusher.so");
  const std::string path = first / "." + ":" + (second / ".");
  vesper_engine_config config = TestConfig();
  config.law_path = path.c_str();
  vesper_prepared_library* prepared = nullptr;
  ASSERT_EQ(vesper_library_prepare(&config, "pusher", &prepared, nullptr), VESPER_OK);
  EXPECT_STREQ(vesper_library_name(prepared), "push");
  vesper_library_discard(prepared);
}

TEST(LibraryTest, PathIsUsedAsIs) { EXPECT_OK(Prepare(TestLawPath("push"))); }

/// Prepares bytes, and returns the error.
vesper_error PrepareBytes(const vesper_engine_config& config, const std::vector<char>& bytes) {
  vesper_prepared_library* prepared = nullptr;
  const vesper_error error = Try([&](vesper_error* e) {
    return vesper_library_prepare_bytes(&config, bytes.data(), bytes.size(), "some/push.so",
                                        &prepared, e);
  });
  if (error.status == VESPER_OK) {
    EXPECT_STREQ(vesper_library_name(prepared), "push");
  }
  vesper_library_discard(prepared);
  return error;
}

TEST(LibraryTest, IsOpenedFromItsBytesWithOrWithoutAProbe) {
  const std::vector<char> bytes = ReadFile(TestLawPath("push"));
  vesper_engine_config config = TestConfig();
  EXPECT_OK(PrepareBytes(config, bytes));
  config.probe_path = "/no/such/probe";
  EXPECT_REFUSED(INTERNAL, "/no/such/probe", PrepareBytes(config, bytes));
  config.probe_path = "";
  EXPECT_OK(PrepareBytes(config, bytes));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "some/push.so",
                 PrepareBytes(config, {bytes.begin(), bytes.begin() + 1000}));
}

/// The table of a front end lives until the engine has unloaded its laws.
TEST(LibraryTest, TableOfAFrontEndIsLoadedAndReleased) {
  const vesper_engine_config config = TestConfig();
  vesper_prepared_library* origin = nullptr;
  ASSERT_EQ(vesper_library_prepare(&config, TestLawPath("push").c_str(), &origin, nullptr), 0);
  const vesper_law_library* table = nullptr;
  const vesper_prototype* prototype = vesper_prototype_standard("si-f64");
  ASSERT_NE(prototype, nullptr);
  ASSERT_EQ(vesper_library_table(origin, prototype, &table, nullptr), VESPER_OK);
  int released = 0;
  const auto release = [](void* user) { ++*static_cast<int*>(user); };
  vesper_prepared_library* made = nullptr;
  vesper_law_library later = *table;
  later.abi_version = 99u << 16;
  EXPECT_REFUSED(ABI_MISMATCH, "the table of a front end", Try([&](vesper_error* e) {
                   return vesper_library_prepare_table(&later, release, &released, &made, e);
                 }));
  EXPECT_EQ(released, 0) << "a refused table stays its maker's";
  ASSERT_EQ(vesper_library_prepare_table(table, release, &released, &made, nullptr), VESPER_OK);
  Bodies bodies(3);
  {
    TestEngine engine;
    engine.AddBodies(bodies);
    vesper_library_id id = 0;
    ASSERT_EQ(vesper_engine_load_prepared(engine.get(), made, nullptr, 0, &id, nullptr), VESPER_OK);
    EXPECT_OK(engine.Advance(1, 1));
    EXPECT_EQ(released, 0);
    EXPECT_OK(engine.Unload(id));
    EXPECT_EQ(released, 1);
  }
  ASSERT_EQ(vesper_library_prepare_table(table, nullptr, nullptr, &made, nullptr), VESPER_OK);
  vesper_library_discard(made);
  vesper_library_discard(origin);
}

/// Only vesper-host opens files in Python, because this process must not run them.
TEST(LibraryTest, FileInPythonIsRefused) {
  TemporaryFolder folder;
  WriteFile(folder / "spin.py", {'#'});
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "spin.py: a law in Python runs only in the engine's process",
                 Prepare(folder / "spin.py"));
}

TEST(LibraryTest, MissingLibraryIsNamed) {
  EXPECT_REFUSED(NOT_FOUND, "libvesper_law_nothing.so", Prepare("nothing"));
  EXPECT_REFUSED(NOT_FOUND, "/no/such/law.so: no such file", Prepare("/no/such/law.so"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "a path holds a '/'", Prepare("a.so"));
  EXPECT_REFUSED(INVALID_ARGUMENT, "law library ''", Prepare(""));
}

TEST(LibraryTest, OtherFilesAreRefused) {
  TemporaryFolder folder;
  const std::string text = folder / "law.so";
  WriteFile(text, {'h', 'e', 'l', 'l', 'o'});
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "not an ELF file", Prepare(text));
  WriteFile(text, {});
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "the file is empty", Prepare(text));
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0600), 0);
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "not a regular file", Prepare(folder / "fifo"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "not a regular file", Prepare(folder / "."));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "not a regular file", Prepare("/dev/zero"));
  std::filesystem::resize_file(text, (64u << 20) + 1);
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "at most 67108864", Prepare(text));
}

TEST(LibraryTest, ReasonSurvivesALongPath) {
  TemporaryFolder folder;
  const std::string deep = folder / std::string(200, 'd');
  std::filesystem::create_directory(deep);
  WriteFile(deep + "/law.so", {'h', 'e', 'l', 'l', 'o'});
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "/law.so: not an ELF file", Prepare(deep + "/law.so"));
}

TEST(LibraryTest, SymbolicLinksAreFollowed) {
  TemporaryFolder folder;
  std::filesystem::create_symlink(TestLawPath("push"), folder / "link.so");
  EXPECT_OK(Prepare(folder / "link.so"));
}

TEST(LibraryTest, ForeignElfFilesAreRefused) {
  TemporaryFolder folder;
  const std::vector<char> good = ReadFile(TestLawPath("push"));
  struct Case {
    size_t offset;
    char value;
    const char* message;
  };
  for (const Case& spoilt :
       {Case{4, 1, "not a 64-bit"}, Case{5, 2, "another byte order"},
        Case{16, 1, "not a shared object"}, Case{18, 3, "another processor"},
        Case{54, 1, "without program headers"}, Case{39, -1, "truncated: needs"}}) {
    std::vector<char> bytes = good;
    bytes[spoilt.offset] = spoilt.value;
    WriteFile(folder / "law.so", bytes);
    EXPECT_REFUSED(LIBRARY_LOAD_FAILED, spoilt.message, Prepare(folder / "law.so"));
  }
}

TEST(LibraryTest, EveryTruncationIsRefusedBeforeTheLoaderSeesIt) {
  TemporaryFolder folder;
  const std::vector<char> whole = ReadFile(TestLawPath("push"));
  for (size_t cut = 0; cut < 401; ++cut) {
    const size_t size = whole.size() * cut / 401;
    WriteFile(folder / "law.so", {whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size)});
    const vesper_error error = Prepare(folder / "law.so");
    EXPECT_REFUSED(LIBRARY_LOAD_FAILED, size == 0 ? "empty" : "truncated: needs", error);
  }
  WriteFile(folder / "law.so", {whole.begin(), whole.end() - 1});
  EXPECT_REFUSED(
      LIBRARY_LOAD_FAILED,
      "needs " + std::to_string(whole.size()) + " bytes, has " + std::to_string(whole.size() - 1),
      Prepare(folder / "law.so"));
}

TEST(LibraryTest, FileThatIsStillBeingCopiedLoadsOnceItIsComplete) {
  TemporaryFolder folder;
  const std::vector<char> whole = ReadFile(TestLawPath("push"));
  std::atomic<bool> complete = false;
  std::thread copier([&] {
    std::ofstream file(folder / "law.so", std::ios::binary);
    for (const char byte : whole) file.put(byte).flush();
    complete = true;
  });
  vesper_error error{};
  do {
    const bool was_complete = complete;
    error = Prepare(folder / "law.so");
    if (was_complete) break;
    if (error.status == VESPER_NOT_FOUND || error.status == VESPER_OK) continue;
    EXPECT_EQ(error.status, VESPER_LIBRARY_LOAD_FAILED) << error.message;
    EXPECT_EQ(std::string(error.message).find("probe"), std::string::npos) << error.message;
  } while (true);
  copier.join();
  EXPECT_OK(error);
}

TEST(LibraryTest, BombsGoOffInTheProbe) {
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "crashed the probe: SIGSEGV while loading",
                 Prepare("bomb_1"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "ended the probe with exit code 7 while loading",
                 Prepare("bomb_2"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED,
                 "crashed the probe: SIGBUS while calling vesper_law_library_entry",
                 Prepare("bomb_4"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "crashed the probe: SIGSEGV while reading its table",
                 Prepare("bomb_5"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "vesper_law_library_entry returned null", Prepare("bomb_6"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "crashed the probe: SIGSEGV while reading its table",
                 Prepare("bomb_8"));
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "crashed the probe: SIGABRT while unloading",
                 Prepare("bomb_9"));
}

TEST(LibraryTest, ReportThatTheLibraryForgesInTheProbeIsNotTrustedToEnd) {
  const vesper_error error = Prepare("bomb_10");
  EXPECT_EQ(error.status, VESPER_LIBRARY_LOAD_FAILED);
  EXPECT_EQ(error.message[sizeof error.message - 1], '\0');
  EXPECT_EQ(error.property[sizeof error.property - 1], '\0');
}

TEST(LibraryTest, LibraryThatHangsIsKilledAtTheDeadline) {
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "took more than 300 ms in the probe while loading",
                 Prepare("bomb_3", {.probe_timeout_ms = 300}));
}

TEST(LibraryTest, OtherContractVersionIsRefusedBeforeAnythingElseIsRead) {
  EXPECT_REFUSED(ABI_MISMATCH, "built for 2.0, engine speaks 1.2", Prepare("bomb_7"));
}

TEST(LibraryTest, LibraryWithoutEntryIsRefused) {
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "does not export vesper_law_library_entry",
                 Prepare("no_entry"));
}

TEST(LibraryTest, UnresolvedSymbolIsNamed) {
  const vesper_error error = Prepare("missing_symbol");
  EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "a_function_that_nobody_has", error);
  EXPECT_EQ(std::string(error.message).find("/proc/self"), std::string::npos) << error.message;
}

TEST(LibraryTest, LibrariesOfOlderAndNewerMinorVersionsRun) {
  for (const char* name : {"of_1_0", "of_1_9"}) {
    Bodies bodies(2);
    TestEngine engine({.validate = true});
    engine.AddBodies(bodies);
    const vesper_library_id id = engine.Load(name, {{"early.gain", 2}, {"late.gain", 5}});
    EXPECT_OK(engine.Advance(1, 1));
    EXPECT_EQ(bodies.velocity[3], 1 + 2 + 5) << name;
    const vesper_law_info late = engine.LawInfo(id, 1);
    EXPECT_STREQ(late.uses[1].name, "velocity") << name;
  }
}

TEST(LibraryTest, NewerMinorVersionIsRefusedIfItAsksForWhatThereIsNot) {
  EXPECT_REFUSED(ABI_MISMATCH,
                 "laws uses a field that contract 1.2 does not have; it needs a newer engine",
                 Prepare("of_1_9_asking"));
}

TEST(LibraryTest, WhatALibrarySaidWhenItWasMappedHolds) {
  Bodies bodies(2);
  TestEngine engine({.validate = true});
  engine.AddBodies(bodies);
  const vesper_library_id id = engine.Load("fickle");  // its tables change from now on
  EXPECT_OK(engine.Advance(1, 1));
  const vesper_law_info info = engine.LawInfo(id);
  EXPECT_EQ(info.phase, VESPER_PHASE_OBSERVE);
  ASSERT_EQ(info.use_count, 1u);
  EXPECT_STREQ(info.uses[0].name, "mass");
  EXPECT_EQ(info.uses[0].access, VESPER_READ);
}

TEST(LibraryTest, BadTablesAreRefusedByRule) {
  EXPECT_OK(Prepare("bad_table_0"));
  const char* const messages[] = {
      "a law has no valid name",
      "law first: is there twice",
      "law first: unknown phase",
      "law first: stages must be 1 to 16",
      "law first: stages is for laws of phase INTEGRATE",
      "property position: ACCUMULATE is for laws of phase FORCE",
      "property mass: is used twice",
      "parameter p: default_value",
      "open and close go together",
      "create, bind, advance and destroy",
      "version is not of the form",
      "laws.struct_size is 8",
      "law_count must be",
      "unknown claims",
      "field wind: evaluate is null",
      "property position: is DEFERRED, but synchronize is null",
      "law first: the sum of force_weights is not 1",
      "law first: first_stage is for laws of phase INTEGRATE",
      "law first: first_stage must be 0 or 1",
  };
  for (size_t i = 0; i < std::size(messages); ++i) {
    EXPECT_REFUSED(LIBRARY_LOAD_FAILED, messages[i], Prepare("bad_table_" + std::to_string(i + 1)));
  }
}

TEST(LibraryTest, MissingProbeIsNamed) {
  vesper_engine_config config = TestConfig();
  config.probe_path = "/no/such/probe";
  vesper_prepared_library* prepared = nullptr;
  EXPECT_REFUSED(INTERNAL, "/no/such/probe", Try([&](vesper_error* error) {
                   return vesper_library_prepare(&config, "push", &prepared, error);
                 }));
}

TEST(LibraryTest, UnloadLeavesNothingMappedOrOpen) {
  Bodies bodies(10);
  TestEngine engine;
  engine.AddBodies(bodies);
  const size_t files = CountOpenFiles();
  for (int i = 0; i < 20; ++i) {
    const vesper_library_id push = engine.Load("push");
    EXPECT_GT(CountMapped("libvesper_law_push.so-"), 0u);
    EXPECT_OK(engine.Advance(1, 1));
    EXPECT_OK(engine.Unload(push));
    EXPECT_EQ(CountMapped("libvesper_law_push"), 0u);
    EXPECT_EQ(CountOpenFiles(), files);
  }
}

TEST(LibraryTest, RefusedLibraryLeavesNothingMappedOrOpen) {
  const size_t files = CountOpenFiles();
  TestEngine engine;
  EXPECT_NE(engine.TryLoad("bomb_1").status, VESPER_OK);
  EXPECT_NE(engine.TryLoad("asking_misspelt").status, VESPER_OK);
  EXPECT_EQ(CountMapped("libvesper_law_"), 0u);
  EXPECT_EQ(CountOpenFiles(), files);
}

TEST(LibraryTest, DroppedFileMayBeOverwrittenWhileItIsLoaded) {
  TemporaryFolder folder;
  std::filesystem::copy_file(TestLawPath("push"), folder / "law.so");
  Bodies bodies(2);
  TestEngine engine;
  engine.AddBodies(bodies);
  engine.Load(folder / "law.so");
  WriteFile(folder / "law.so", {});
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force[0], 1);
}

TEST(LibraryTest, SameNameNewCodeTakesTheNewCode) {
  TemporaryFolder folder;
  const std::string file = folder / "libvesper_law_push.so";
  Bodies bodies(2);
  TestEngine engine;
  engine.AddBodies(bodies);
  for (int i = 0; i < 6; ++i) {
    const bool changed = i % 2 == 1;
    std::filesystem::copy_file(TestLawPath(changed ? "push_changed" : "push"), file,
                               std::filesystem::copy_options::overwrite_existing);
    const vesper_library_id push = engine.Load(file);
    EXPECT_OK(engine.Advance(1, 1));
    EXPECT_EQ(bodies.force[0], changed ? 2 : 1);
    EXPECT_OK(engine.Unload(push));
  }
}

/// Returns the force of `law` after a library that cannot be unmapped was loaded and unloaded.
double ForceAfterOneThatStays(const char* law) {
  Bodies bodies(1);
  TestEngine engine;
  engine.AddBodies(bodies);
  engine.Unload(engine.Load("push_for_ever"));
  engine.Load(law);
  engine.Advance(1, 1);
  return bodies.force[0];
}

TEST(LibraryTest, LibraryThatStaysMappedIsNotTakenForTheNextOne) {
  // The check runs in a separate process, because the remaining mapping would disturb other tests.
  EXPECT_EXIT(std::exit(ForceAfterOneThatStays("push") == 1 ? 0 : 1), testing::ExitedWithCode(0),
              "");
}

TEST(LibraryTest, NewCodeCanBePreparedWhileTheOldIsLoaded) {
  Bodies bodies(2);
  TestEngine engine;
  engine.AddBodies(bodies);
  const vesper_library_id old = engine.Load("push");
  const vesper_engine_config config = TestConfig();
  vesper_prepared_library* prepared = nullptr;
  ASSERT_EQ(vesper_library_prepare(&config, "push_changed", &prepared, nullptr), VESPER_OK);
  const auto activate = [&](vesper_library_id* id) {
    return Try([&](vesper_error* error) {
      return vesper_engine_load_prepared(engine.get(), prepared, nullptr, 0, id, error);
    });
  };
  vesper_library_id id = 99;
  EXPECT_REFUSED(ALREADY_EXISTS, "library push is loaded already", activate(&id));
  EXPECT_EQ(id, 99u);
  EXPECT_OK(engine.Unload(old));
  EXPECT_OK(activate(&id));
  EXPECT_GT(id, old);
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force[0], 2);
}

TEST(LibraryTest, EnginesDoNotShareALibrary) {
  Bodies first_bodies(1), second_bodies(1);
  TestEngine first, second;
  first.AddBodies(first_bodies);
  second.AddBodies(second_bodies);
  const vesper_library_id suite = first.Load("suite");
  second.Load("suite");
  EXPECT_OK(first.Advance(1, 3));
  EXPECT_OK(second.Advance(1, 1));
  EXPECT_OK(first.Unload(suite));
  EXPECT_OK(second.Advance(1, 1));
  EXPECT_EQ(first.log().back(), "suite: close after 6 calls");
}

TEST(LibraryTest, SuiteIsOpenedOnceAndClosedAfterItsLaws) {
  Bodies bodies(1);
  TestEngine engine;
  engine.AddBodies(bodies);
  const vesper_library_id suite = engine.Load("suite");
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_OK(engine.Unload(suite));
  const std::vector<std::string> expected = {"suite: open",    "suite: create",
                                             "suite: create",  "suite: destroy",
                                             "suite: destroy", "suite: close after 2 calls"};
  EXPECT_EQ(engine.log(), expected);
}

TEST(LibraryTest, LawThatCannotBeMadeTakesTheWholeSuiteBack) {
  Bodies bodies(1);
  TestEngine engine;
  engine.AddBodies(bodies);
  const vesper_error error = engine.TryLoad("suite", {{"second.fail", 1}});
  EXPECT_REFUSED(LAW_FAILED, "law second: asked to fail", error);
  EXPECT_EQ(error.law_index, 1u);
  const std::vector<std::string> expected = {"suite: open", "suite: create", "suite: destroy",
                                             "suite: close after 0 calls"};
  EXPECT_EQ(engine.log(), expected);
  EXPECT_EQ(CountMapped("libvesper_law_"), 0u);
  engine.Load("suite");
}

TEST(LibraryTest, DestroyUnloadsEverything) {
  {
    Bodies bodies(1);
    TestEngine engine;
    engine.AddBodies(bodies);
    engine.Load("suite");
    engine.Load("push");
    EXPECT_GT(CountMapped("libvesper_law_"), 0u);
  }
  EXPECT_EQ(CountMapped("libvesper_law_"), 0u);
}

TEST(LibraryTest, LawInfoDescribesTheLaw) {
  Bodies bodies(1);
  TestEngine engine;
  engine.AddBodies(bodies);
  const vesper_library_id push = engine.Load("push");
  const vesper_law_info info = engine.LawInfo(push);
  EXPECT_EQ(info.library_id, push);
  EXPECT_STREQ(info.library, "push");
  EXPECT_STREQ(info.name, "push");
  EXPECT_STREQ(info.version, "1.0.0");
  EXPECT_EQ(info.phase, VESPER_PHASE_FORCE);
  ASSERT_EQ(info.use_count, 1u);
  EXPECT_STREQ(info.uses[0].name, "externalForce");
  ASSERT_EQ(info.parameter_count, 1u);
  EXPECT_STREQ(info.parameters[0].name, "force");
  EXPECT_EQ(info.calls, 0u);
  vesper_law_info none{};
  none.struct_size = sizeof none;
  EXPECT_REFUSED(NOT_FOUND, "there is no law 1", Try([&](vesper_error* error) {
                   return vesper_engine_law_info(engine.get(), push, 1, &none, error);
                 }));
  EXPECT_REFUSED(NOT_FOUND, "no library with id 77", engine.Unload(77));
}

}  // namespace
}  // namespace vesper::test
