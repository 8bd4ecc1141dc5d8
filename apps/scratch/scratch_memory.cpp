// libmarquetry_scratch.so: large blocks of memory in a file, so that what does not fit into memory lies on the disk.
//
// It stands before the C library's allocator (LD_PRELOAD). Small blocks are the C library's. Blocks of a megabyte and more
// are pieces of one file without a name, mapped into a range of addresses that is reserved at the start. The system reads and
// writes its pages as they are touched; a thread sees to it that no more of them stay in memory than MARQUETRY_SCRATCH says:
//
//     MARQUETRY_SCRATCH="BYTES FOLDER"
//
// Disk is reserved with each block, so that a full disk is an allocation that fails and not a signal. What is freed is
// punched out of the file. Nothing is left when the process ends, however it ends.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <iterator>
#include <map>
#include <mutex>
#include <new>

// The C library's own allocator, by the names under which it keeps it for those who stand before it.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* block);
}

namespace {

constexpr std::size_t page = 4096;
constexpr std::size_t large = 1 << 20;         ///< blocks of as much lie in the file
constexpr std::size_t addresses = 1ULL << 42;  ///< how many bytes the file can have, at most
constexpr std::size_t chunk = 4 << 20;         ///< what is put out of memory at a time
constexpr int chunks_at_once = 16;             ///< whose writing is waited for together
constexpr double keep = 0.95;                  ///< of what may stay, where more was there
constexpr std::size_t least_of_file = 96 << 20;  ///< what stays of the file and of libraries, however little is left for it

std::size_t whole_pages(std::size_t size) { return (size + page - 1) / page * page; }

void rest(long microseconds) {
  const timespec time{0, microseconds * 1000};
  nanosleep(&time, nullptr);
}

/// The file, and which parts of it are taken.
class Scratch {
 public:
  /// False, with errno, where the folder cannot have such a file.
  bool open(const char* folder, std::size_t limit);

  bool holds(const void* block) const {
    const auto* at = static_cast<const char*>(block);
    return at >= base_ && at < base_ + addresses;
  }

  /// Zeros; none where the disk is full.
  void* take(std::size_t size, std::size_t alignment);
  void give_back(void* block);
  std::size_t size_of(const void* block);

  std::size_t limit() const { return limit_; }
  std::int64_t disk_left() const;

 private:
  std::size_t place_for(std::size_t size, std::size_t alignment);
  std::int64_t too_much(double part) const;
  void wait_for_room() const;
  void put_out(std::uint64_t& random);
  static void* watch(void* self);

  char* base_ = nullptr;
  int file_ = -1, status_ = -1;
  std::size_t limit_ = 0;
  std::mutex mutex_;
  std::map<std::size_t, std::size_t> taken_, free_;  ///< sizes by offset, guarded by the mutex
  std::atomic<std::size_t> end_{0};                  ///< of all that was ever taken
};

bool Scratch::open(const char* folder, std::size_t limit) {
  limit_ = limit;
  file_ = ::open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file_ < 0) {
    char name[page];
    if (std::snprintf(name, sizeof name, "%s/marquetry-XXXXXX", folder) >= int(sizeof name)) return false;
    file_ = ::mkostemp(name, O_CLOEXEC);
    if (file_ < 0) return false;
    ::unlink(name);
  }
  status_ = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  // Where disk cannot be reserved or given back, a full one would be a signal.
  if (status_ < 0 || ::fallocate(file_, 0, 0, page) != 0 ||
      ::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, page) != 0)
    return false;
  void* mapped = ::mmap(nullptr, addresses, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_NORESERVE, file_, 0);
  if (mapped == MAP_FAILED) return false;
  base_ = static_cast<char*>(mapped);
  ::madvise(base_, addresses, MADV_DONTFORK);
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  pthread_t thread;
  const int failed = pthread_create(&thread, nullptr, watch, this);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (failed != 0) return false;
  pthread_detach(thread);
  return true;
}

/// The first gap that is large enough, else behind everything. The mutex is held.
std::size_t Scratch::place_for(std::size_t size, std::size_t alignment) {
  const auto aligned = [&](std::size_t offset) { return (offset + alignment - 1) / alignment * alignment; };
  for (auto gap = free_.begin(); gap != free_.end(); ++gap) {
    const std::size_t begin = gap->first, end = begin + gap->second, at = aligned(begin);
    if (at + size > end) continue;
    free_.erase(gap);
    if (at > begin) free_[begin] = at - begin;
    if (at + size < end) free_[at + size] = end - at - size;
    return at;
  }
  const std::size_t begin = end_, at = aligned(begin);
  if (at + size > addresses) return addresses;
  if (at > begin) free_[begin] = at - begin;
  end_ = at + size;
  return at;
}

void* Scratch::take(std::size_t size, std::size_t alignment) {
  if (size > addresses || alignment > addresses) return nullptr;
  wait_for_room();
  const std::size_t bytes = whole_pages(size);
  std::size_t at = 0;
  {
    const std::lock_guard lock(mutex_);
    at = place_for(bytes, alignment > page ? alignment : page);
    if (at == addresses) return nullptr;
    taken_[at] = bytes;
  }
  if (::fallocate(file_, 0, off_t(at), off_t(bytes)) == 0) return base_ + at;
  give_back(base_ + at);
  return nullptr;
}

void Scratch::give_back(void* block) {
  std::size_t at = std::size_t(static_cast<char*>(block) - base_), bytes = 0;
  {
    const std::lock_guard lock(mutex_);
    bytes = taken_.at(at);
  }
  // Before others can take it.
  ::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, off_t(at), off_t(bytes));
  const std::lock_guard lock(mutex_);
  taken_.erase(at);
  const auto after = free_.lower_bound(at);
  if (after != free_.begin()) {
    const auto before = std::prev(after);
    if (before->first + before->second == at) {
      at = before->first;
      bytes += before->second;
      free_.erase(before);
    }
  }
  if (after != free_.end() && at + bytes == after->first) {
    bytes += after->second;
    free_.erase(after);
  }
  free_[at] = bytes;
}

std::size_t Scratch::size_of(const void* block) {
  const std::lock_guard lock(mutex_);
  return taken_.at(std::size_t(static_cast<const char*>(block) - base_));
}

std::int64_t Scratch::disk_left() const {
  struct statvfs disk{};
  return ::fstatvfs(file_, &disk) == 0 ? std::int64_t(disk.f_bavail) * std::int64_t(disk.f_frsize) : 0;
}

/// By how many bytes more of the process are in memory than part of what may be. What is not of the file cannot be put out.
std::int64_t Scratch::too_much(double part) const {
  char text[128];
  const ssize_t length = ::pread(status_, text, sizeof text - 1, 0);
  if (length <= 0) return 0;
  text[length] = 0;
  unsigned long long all = 0, of_files = 0;
  if (std::sscanf(text, "%*u %llu %llu", &all, &of_files) != 2) return 0;
  const std::size_t other = page * (all - of_files), most = std::max(limit_, other + least_of_file);
  return std::int64_t(page * all) - std::int64_t(part * double(most));
}

/// A new block is not begun before what was there is put out, for a second at most.
void Scratch::wait_for_room() const {
  for (int k = 0; k < 500 && too_much(1) > 0; ++k) rest(2000);
}

/// Some chunks, chosen by chance: work goes through large blocks from the beginning to the end, again and again, and what
/// was used longest ago is then what is wanted next.
void Scratch::put_out(std::uint64_t& random) {
  const std::size_t count = (end_ + chunk - 1) / chunk;
  if (count == 0) return;
  off_t at[chunks_at_once];
  for (off_t& offset : at) {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    offset = off_t(random % count * chunk);
    ::madvise(base_ + offset, chunk, MADV_DONTNEED);  // the file keeps what is there
    ::sync_file_range(file_, offset, chunk, SYNC_FILE_RANGE_WRITE);
  }
  for (const off_t offset : at) {
    ::sync_file_range(file_, offset, chunk,
                      SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER);
    ::posix_fadvise(file_, offset, chunk, POSIX_FADV_DONTNEED);
  }
}

void* Scratch::watch(void* self) {
  auto& scratch = *static_cast<Scratch*>(self);
  std::uint64_t random = 88172645463325252ULL;
  for (;;) {
    if (scratch.too_much(1) > 0)
      for (int k = 0; k < 1000 && scratch.too_much(keep) > 0; ++k) scratch.put_out(random);
    rest(2000);
  }
}

/// None before the file is open, in a process that was forked, and where nothing was asked for.
constinit std::atomic<Scratch*> current{nullptr};
/// Whose blocks are known again when they are freed; stays.
constinit std::atomic<Scratch*> opened{nullptr};
alignas(Scratch) constinit std::byte storage[sizeof(Scratch)]{};

__attribute__((constructor)) void begin() {
  const char* asked = std::getenv("MARQUETRY_SCRATCH");
  if (asked == nullptr) return;
  char* folder = nullptr;
  const std::size_t limit = std::strtoull(asked, &folder, 10);
  if (limit == 0 || *folder != ' ') return;
  auto* scratch = new (storage) Scratch;
  if (!scratch->open(folder + 1, limit)) return;
  // What this program starts is not meant.
  ::unsetenv("MARQUETRY_SCRATCH");
  ::unsetenv("LD_PRELOAD");
  ::pthread_atfork(nullptr, nullptr, [] { current = nullptr; });
  opened = scratch;
  current = scratch;
}

bool in_file(const void* block) {
  const Scratch* scratch = opened.load(std::memory_order_acquire);
  return scratch != nullptr && scratch->holds(block);
}

/// A block of the file, or none where it is not for it.
void* taken(std::size_t size, std::size_t alignment) {
  Scratch* scratch = size < large ? nullptr : current.load(std::memory_order_acquire);
  return scratch == nullptr ? nullptr : scratch->take(size, alignment);
}

bool is_for_file(std::size_t size) { return size >= large && current.load(std::memory_order_acquire) != nullptr; }

void* failed() {
  errno = ENOMEM;
  return nullptr;
}

void* aligned(std::size_t alignment, std::size_t size) {
  if (!is_for_file(size)) return __libc_memalign(alignment, size);
  void* block = taken(size, alignment);
  return block != nullptr ? block : failed();
}

}  // namespace

#define MARQUETRY_EXPORT __attribute__((visibility("default")))

extern "C" {

MARQUETRY_EXPORT void* malloc(std::size_t size) {
  if (!is_for_file(size)) return __libc_malloc(size);
  void* block = taken(size, page);
  return block != nullptr ? block : failed();
}

MARQUETRY_EXPORT void* calloc(std::size_t count, std::size_t size) {
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, size, &bytes)) return failed();
  if (!is_for_file(bytes)) return __libc_calloc(count, size);
  void* block = taken(bytes, page);  // what was reserved or punched out is zero
  return block != nullptr ? block : failed();
}

MARQUETRY_EXPORT void free(void* block) {
  if (!in_file(block)) return __libc_free(block);
  // A process that was forked has nothing of the file.
  if (Scratch* scratch = current.load(std::memory_order_acquire)) scratch->give_back(block);
}

MARQUETRY_EXPORT std::size_t malloc_usable_size(void* block) {
  if (in_file(block)) return opened.load()->size_of(block);
  static const auto of_the_library = reinterpret_cast<std::size_t (*)(void*)>(::dlsym(RTLD_NEXT, "malloc_usable_size"));
  return of_the_library(block);
}

MARQUETRY_EXPORT void* realloc(void* block, std::size_t size) {
  const bool was_in_file = in_file(block);
  if (!was_in_file && !is_for_file(size)) return __libc_realloc(block, size);
  if (block == nullptr) return malloc(size);
  if (size == 0) {
    free(block);
    return nullptr;
  }
  const std::size_t before = malloc_usable_size(block);
  if (was_in_file && whole_pages(size) == before) return block;
  void* moved = malloc(size);
  if (moved == nullptr) return nullptr;
  std::memcpy(moved, block, before < size ? before : size);
  free(block);
  return moved;
}

MARQUETRY_EXPORT void* memalign(std::size_t alignment, std::size_t size) { return aligned(alignment, size); }
MARQUETRY_EXPORT void* aligned_alloc(std::size_t alignment, std::size_t size) { return aligned(alignment, size); }
MARQUETRY_EXPORT void* valloc(std::size_t size) { return aligned(page, size); }
MARQUETRY_EXPORT void* pvalloc(std::size_t size) { return aligned(page, whole_pages(size)); }

MARQUETRY_EXPORT int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  if (alignment < sizeof(void*) || (alignment & (alignment - 1)) != 0) return EINVAL;
  void* found = aligned(alignment, size);
  if (found == nullptr) return ENOMEM;
  *block = found;
  return 0;
}

/// How many bytes stay in memory; asked by a program that wants to know whether it runs so.
MARQUETRY_EXPORT std::uint64_t marquetry_scratch_limit() {
  const Scratch* scratch = current.load();
  return scratch == nullptr ? 0 : scratch->limit();
}

/// How many bytes more the disk can take.
MARQUETRY_EXPORT std::int64_t marquetry_scratch_left() {
  const Scratch* scratch = current.load();
  return scratch == nullptr ? 0 : scratch->disk_left();
}
}
