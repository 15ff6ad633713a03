// SPDX-License-Identifier: Apache-2.0
// Check of a law on arrays next to inaccessible memory.
#include <sys/mman.h>
#include <unistd.h>

#include <csetjmp>
#include <csignal>
#include <cstring>
#include <memory>

#include "subject.hpp"

namespace vesper {
namespace {

enum class Side { kBegin, kEnd };

/// A copy of a column between two inaccessible pages, adjacent to one of them.
class GuardedArray {
 public:
  GuardedArray(const AnyColumn& column, vesper_access access, Side side)
      : name_(column.descriptor().name), side_(side), size_(column.bytes().size()) {
    const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    const size_t body = (size_ + page - 1) / page * page;
    mapped_ = body + 2 * page;
    base_ = static_cast<std::byte*>(
        mmap(nullptr, mapped_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (base_ == MAP_FAILED) throw std::bad_alloc();
    data_ = base_ + page + (side == Side::kEnd ? body - size_ : 0);
    if (body == 0) return;
    mprotect(base_ + page, body, PROT_READ | PROT_WRITE);
    std::memcpy(data_, column.bytes().data(), size_);
    if (access == VESPER_READ) mprotect(base_ + page, body, PROT_READ);
  }
  ~GuardedArray() { munmap(base_, mapped_); }
  GuardedArray(const GuardedArray&) = delete;
  GuardedArray& operator=(const GuardedArray&) = delete;

  void* data() const { return data_; }
  bool Holds(const void* address) const { return address >= base_ && address < base_ + mapped_; }
  std::string Describe(const void* address) const {
    const std::string name = "'" + name_ + "'";
    if (address < data_) return "reads or writes before the first row of " + name;
    if (address >= data_ + size_) return "reads or writes behind the last row of " + name;
    return "writes to " + name + ", which it declares as READ";
  }

 private:
  std::string name_;
  Side side_;
  size_t size_, mapped_ = 0;
  std::byte *base_ = nullptr, *data_ = nullptr;
};

sigjmp_buf before_fault;
void* volatile fault_address;

void OnFault(int, siginfo_t* info, void*) {
  fault_address = info->si_addr;
  siglongjmp(before_fault, 1);
}

void CatchFaults() {
  struct sigaction action{};
  action.sa_sigaction = OnFault;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSEGV, &action, nullptr);
  sigaction(SIGBUS, &action, nullptr);
}

/// Runs one law for one step. The handler of a memory fault jumps back to this function. The
/// process ends soon afterwards, so leaked resources do not matter.
void RunGuarded(const vesper_law_library& library, const vesper_law_desc& desc, World& world,
                Side side) {
  std::vector<vesper_property> properties = world.PropertiesFor(desc);
  std::vector<std::unique_ptr<GuardedArray>> arrays;
  for (vesper_property& property : properties) {
    if (property.scalar_type == VESPER_FIELD) continue;
    arrays.push_back(
        std::make_unique<GuardedArray>(world.ColumnOf(property), property.access, side));
    property.data = arrays.back()->data();
  }
  if (sigsetjmp(before_fault, 1) != 0) {
    for (const auto& array : arrays) {
      if (array->Holds(fault_address)) throw CheckFailed(array->Describe(fault_address));
    }
    throw CheckFailed("crashes at an address that belongs to none of its arrays");
  }
  const BareLaw law(desc, properties, &library);
  law.Step({kDt, 0}, [](uint32_t) {});
}

}  // namespace

std::string CheckGuardPages(const Subject& of) {
  const LawsUnderTest subject(of);
  CatchFaults();
  for (const vesper_law_desc* desc : subject.laws()) {
    for (const uint64_t rows : {0, 1, 7, 1021}) {
      for (const Side side : {Side::kBegin, Side::kEnd}) {
        World world = subject.MakeWorld(rows);
        try {
          RunGuarded(subject.library().table(subject.real_type()), *desc, world, side);
        } catch (const std::exception& error) {
          throw CheckFailed("on " + std::to_string(rows) + " rows, " + desc->name + ": " +
                            error.what());
        }
      }
    }
  }
  return "";
}

}  // namespace vesper
