// SPDX-License-Identifier: Apache-2.0
#include "prepared_library.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <xxhash.h>

#include <algorithm>
#include <cinttypes>
#include <cstddef>
#include <cstdio>
#include <string_view>
#include <utility>
#include <vector>

#include "elf_file.hpp"
#include "failure.hpp"
#include "floating_point.hpp"
#include "law_table.hpp"
#include "probe_process.hpp"
#include "unit.hpp"

namespace vesper {
namespace {

constexpr uint64_t kMaxLibrarySize = uint64_t{64} << 20;

Failure LoadFailure(const std::string& source, const char* what) {
  return Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: %s", source.c_str(), what);
}

Failure TooLarge(const std::string& source, uint64_t size) {
  return Failure(VESPER_LIBRARY_LOAD_FAILED,
                 "%s: has %" PRIu64 " bytes, a law library has at most %" PRIu64, source.c_str(),
                 size, kMaxLibrarySize);
}

constexpr std::string_view kTextEnding = ".law";
constexpr std::string_view kPythonEnding = ".py";

/// Refuses a file of laws in Python, because only vesper-host opens such files.
void RefusePython(const std::string& source) {
  if (!source.ends_with(kPythonEnding)) return;
  throw LoadFailure(source, "a law in Python runs only in the engine's process, vesper-host");
}

/// Returns the file for a bare name, from the first folder of the law path that contains it.
std::string Search(const std::string& law_path, const std::string& name) {
  const bool is_text = name.ends_with(kTextEnding);
  const std::string bare = is_text ? name.substr(0, name.size() - kTextEnding.size()) : name;
  if (!IsValidName(bare.c_str())) {
    throw Failure(VESPER_INVALID_ARGUMENT,
                  "law library '%.60s': a name is letters, digits, '_' and '-'; a path holds a '/'",
                  name.c_str());
  }
  const std::string file = is_text ? name : "libvesper_law_" + name + ".so";
  for (size_t begin = 0; begin < law_path.size();) {
    const size_t end = std::min(law_path.find(':', begin), law_path.size());
    const std::string candidate = law_path.substr(begin, end - begin) + "/" + file;
    if (end > begin && access(candidate.c_str(), F_OK) == 0) return candidate;
    const std::string text = law_path.substr(begin, end - begin) + "/" + bare;
    if (end > begin && access((text + ".law").c_str(), F_OK) == 0) return text + ".law";
    begin = end + 1;
  }
  throw Failure(VESPER_NOT_FOUND, "no %s in the law path '%s'", file.c_str(), law_path.c_str());
}

/// Returns the end of a path, so that a message with a long path has space for the error.
std::string ShortPath(const std::string& path) {
  constexpr size_t kLength = 80;
  return path.size() <= kLength ? path : "..." + path.substr(path.size() - kLength);
}

/// Opens a regular file, in non-blocking mode, because opening a FIFO would block the caller.
Descriptor OpenRegularFile(const std::string& path, const std::string& source,
                           struct stat& status) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0 && errno == ENOENT) {
    throw Failure(VESPER_NOT_FOUND, "%s: no such file", source.c_str());
  }
  if (fd < 0) throw LoadFailure(source, std::strerror(errno));
  Descriptor file(fd, "open");
  if (fstat(fd, &status) != 0) throw LoadFailure(source, std::strerror(errno));
  if (!S_ISREG(status.st_mode)) throw LoadFailure(source, "not a regular file");
  if (static_cast<uint64_t>(status.st_size) > kMaxLibrarySize) {
    throw TooLarge(source, static_cast<uint64_t>(status.st_size));
  }
  return file;
}

bool SameVersion(const struct stat& a, const struct stat& b) {
  return a.st_size == b.st_size && a.st_mtim.tv_sec == b.st_mtim.tv_sec &&
         a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

/// Reads the whole file; refuses a file that changes during the read.
std::vector<std::byte> ReadStable(const std::string& path, const std::string& source) {
  struct stat before{};
  const Descriptor file = OpenRegularFile(path, source, before);
  std::vector<std::byte> bytes(static_cast<size_t>(before.st_size));
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t size = read(file.get(), bytes.data() + done, bytes.size() - done);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) throw LoadFailure(source, std::strerror(errno));
    if (size == 0) break;
    done += static_cast<size_t>(size);
  }
  struct stat after{};
  if (done != bytes.size() || fstat(file.get(), &after) != 0 || !SameVersion(before, after)) {
    throw LoadFailure(source, "the file changed while it was read; load it when it is complete");
  }
  return bytes;
}

std::string ContentName(const std::string& source, std::span<const std::byte> bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  char digits[33];
  std::snprintf(digits, sizeof digits, "%016" PRIx64 "%016" PRIx64, hash.high64, hash.low64);
  return source.substr(source.rfind('/') + 1, 128) + "-" + digits;
}

void WriteAll(int fd, std::span<const std::byte> bytes) {
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t size = write(fd, bytes.data() + done, bytes.size() - done);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) {
      throw Failure(VESPER_INTERNAL, "copying a law library: %s", std::strerror(errno));
    }
    done += static_cast<size_t>(size);
  }
}

std::string TextOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Returns whether the bytes begin with the magic number of ELF files.
bool IsElf(std::span<const std::byte> bytes) {
  return TextOf(bytes).starts_with(
      "\x7f"
      "ELF");
}

/// Returns the loader's message without the private path of the copy at its beginning.
std::string LoaderMessage(const std::string& private_path) {
  const char* message = dlerror();
  std::string text = message != nullptr ? message : "unknown loader error";
  if (text.starts_with(private_path + ": ")) text.erase(0, private_path.size() + 2);
  return text;
}

}  // namespace

SealedCopy::SealedCopy(std::span<const std::byte> bytes, const std::string& source)
    : source_(ShortPath(source)) {
  if (bytes.size() > kMaxLibrarySize) throw TooLarge(source_, bytes.size());
  CheckSharedObject(bytes, source_);
  memory_ =
      Descriptor(memfd_create(ContentName(source, bytes).c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING),
                 "memory for the copy of a law library");
  WriteAll(memory_.get(), bytes);
  const int seals = F_SEAL_SEAL | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE;
  if (fcntl(memory_.get(), F_ADD_SEALS, seals) != 0) {
    throw Failure(VESPER_INTERNAL, "sealing the copy of a law library: %s", std::strerror(errno));
  }
  path_ = "/proc/self/fd/" + std::to_string(memory_.get());
}

MappedLibrary::MappedLibrary(const Config& config, SealedCopy copy) : copy_(std::move(copy)) {
  if (!config.probe_path.empty()) ProbeLibrary(config, copy_);
  const FloatingPointGuard guard;
  handle_ = dlopen(copy_.path().c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle_ == nullptr) {
    throw LoadFailure(copy_.source(), LoaderMessage(copy_.path()).c_str());
  }
}

MappedLibrary::~MappedLibrary() {
  const FloatingPointGuard guard;
  dlclose(handle_);
  // Some libraries stay mapped after they are closed. The private name of such a library must never
  // be used again, because the loader would return the old library for a new file of this name.
  if (void* kept = dlopen(copy_.path().c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD)) {
    dlclose(kept);
    copy_.Abandon();
  }
}

LawTable MappedLibrary::Table() const {
  const auto entry = reinterpret_cast<decltype(&vesper_law_library_entry)>(
      dlsym(handle_, VESPER_LAW_LIBRARY_ENTRY));
  if (entry == nullptr) {
    throw LoadFailure(copy_.source(), "does not export " VESPER_LAW_LIBRARY_ENTRY);
  }
  const FloatingPointGuard guard;
  return LawTable(entry(), copy_.source().c_str());
}

}  // namespace vesper

vesper_prepared_library::vesper_prepared_library(const vesper::Config& config,
                                                 const std::string& library) {
  using namespace vesper;
  const bool is_path = library.find('/') != std::string::npos;
  const std::string file = is_path ? library : Search(config.law_path, library);
  RefusePython(file);
  const std::vector<std::byte> bytes = ReadStable(file, ShortPath(file));
  if (file.ends_with(kTextEnding)) {
    text_ = std::make_unique<text::TextLibrary>(file.substr(file.rfind('/') + 1), TextOf(bytes));
  } else {
    Map(config, bytes, file);
  }
}

vesper_prepared_library::vesper_prepared_library(const vesper::Config& config,
                                                 std::span<const std::byte> bytes,
                                                 const std::string& source) {
  vesper::RefusePython(source);
  if (vesper::IsElf(bytes) || source.ends_with(".so")) {
    Map(config, bytes, source);
  } else {
    text_ = std::make_unique<vesper::text::TextLibrary>(source, vesper::TextOf(bytes));
  }
}

vesper_prepared_library::vesper_prepared_library(std::string source, std::string text)
    : text_(std::make_unique<vesper::text::TextLibrary>(std::move(source), std::move(text))) {}

vesper_prepared_library::vesper_prepared_library(const vesper_law_library& table) {
  tables_.push_back(std::make_unique<vesper::LawTable>(&table, "the table of a front end"));
}

vesper_prepared_library::~vesper_prepared_library() {
  if (release_ != nullptr) release_(released_);
}

void vesper_prepared_library::ReleaseAtEnd(void (*release)(void* user), void* user) {
  release_ = release;
  released_ = user;
}

void vesper_prepared_library::Map(const vesper::Config& config, std::span<const std::byte> bytes,
                                  const std::string& source) {
  mapped_ = std::make_unique<vesper::MappedLibrary>(config, vesper::SealedCopy(bytes, source));
  tables_.push_back(std::make_unique<vesper::LawTable>(mapped_->Table()));
}

const char* vesper_prepared_library::name() const {
  return text_ != nullptr ? text_->name().c_str() : tables_.front()->library().name;
}

const vesper_law_library& vesper_prepared_library::TableFor(const vesper::Prototype& prototype) {
  if (text_ == nullptr) return tables_.front()->library();
  tables_.push_back(
      std::make_unique<vesper::LawTable>(&text_->TableFor(prototype), text_->name().c_str()));
  return tables_.back()->library();
}
