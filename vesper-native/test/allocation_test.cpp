// SPDX-License-Identifier: Apache-2.0
// Tests that the frame path allocates nothing. This program's operator new counts allocations; the
// engine's library uses it too.
#include <atomic>
#include <cstdlib>
#include <new>

#include "test_kit.hpp"

namespace {

std::atomic<uint64_t> allocations = 0;

}  // namespace

[[gnu::noinline]] void* operator new(size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace vesper::test {
namespace {

class AllocationTest : public BothModes {};
IN_BOTH_MODES(AllocationTest);

/// Expects that a step allocates no memory with this number of threads, after all arrays are bound.
void ExpectNoAllocations(const EngineOptions& options) {
  Bodies bodies(3000);
  TestEngine engine(options);
  const uint64_t start = allocations;
  engine.AddBodies(bodies);
  EXPECT_OK(engine.Add("appliedForce", bodies.applied, 3));
  engine.Load("field");
  engine.Load("push");
  engine.Load("euler");
  for (const uint32_t ledger : {0u, 1u}) {
    ASSERT_EQ(vesper_engine_set_ledger(engine.get(), ledger, nullptr), VESPER_OK);
    EXPECT_OK(engine.Advance(0.01, 1));
    ASSERT_GT(allocations, start) << "the engine's allocations are not counted";
    const uint64_t bound = allocations;
    const vesper_status status = vesper_engine_advance(engine.get(), 0.01, 50, nullptr);
    EXPECT_EQ(allocations, bound) << "ledger " << ledger;
    EXPECT_EQ(status, VESPER_OK);
  }
}

TEST_P(AllocationTest, DeferredWritesAllocateNothingOnceBound) {
  for (const bool deferred : {false, true}) {
    Bodies bodies(300);
    TestEngine engine({.validate = GetParam(), .deferred = deferred});
    engine.AddBodies(bodies);
    engine.Load("vault");
    engine.Load("push");
    EXPECT_OK(engine.Advance(0.01, 1));
    const uint64_t bound = allocations;
    vesper_status status = vesper_engine_advance(engine.get(), 0.01, 20, nullptr);
    if (status == VESPER_OK) status = vesper_engine_advance(engine.get(), 0.01, 20, nullptr);
    EXPECT_EQ(allocations, bound);
    EXPECT_EQ(status, VESPER_OK);
  }
}

TEST_P(AllocationTest, AdvanceAllocatesNothingOnceBound) { ExpectNoAllocations(Options()); }

TEST_P(AllocationTest, AdvanceWithLawsAtTheSameTimeAllocatesNothingOnceBound) {
  ExpectNoAllocations({.validate = GetParam(), .threads = 2});
}

}  // namespace
}  // namespace vesper::test
