// Stands before the C library (LD_PRELOAD) and lets calls fail, as a full disk, a broken one or a lack of memory would.
//
//     SCANKNIT_FAULT=KIND:K       the K-th call of that kind fails, counted from 1
//     SCANKNIT_FAULT=KIND:K:on    and all that follow
//     SCANKNIT_FAULT_COUNTS=FILE  at its end the process writes there how many calls of each kind it made: "KIND COUNT"
//
// A process that is forked goes on counting from its parent's count. Calls that the C library makes itself are not
// seen: those of streams (FILE) and of the loader. What the constructors of
// a library do while the program opens it is not ours either (log4cplus, which OpenVDB needs, ends the program if it
// gets no thread there).
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

namespace {

enum Kind { kOpen, kRead, kWrite, kSync, kRename, kClose, kMmap, kTruncate, kAlloc, kThread, kKinds };

struct Fault {
  std::string_view name;
  int error;  ///< errno of the call that fails
};
constexpr std::array<Fault, kKinds> kFaults = {{{"open", EMFILE},
                                                {"read", EIO},
                                                {"write", ENOSPC},
                                                {"sync", EIO},
                                                {"rename", EIO},
                                                {"close", EIO},
                                                {"mmap", ENODEV},
                                                {"truncate", ENOSPC},
                                                {"alloc", ENOMEM},
                                                {"thread", EAGAIN}}};

constexpr std::size_t kLarge = std::size_t{1} << 16;  // bytes: smaller allocations never fail

std::array<std::atomic<unsigned long>, kKinds> counts;
std::atomic<int> opening;  ///< libraries that are being opened

/// What is to fail, from the environment; `kind` is kKinds if nothing is. Allocates nothing.
struct Plan {
  int kind = kKinds;
  unsigned long number = 0;
  bool goes_on = false;

  Plan() {
    const char* text = std::getenv("SCANKNIT_FAULT");
    const char* colon = text == nullptr ? nullptr : std::strchr(text, ':');
    if (colon == nullptr) return;
    if (std::string_view(program_invocation_short_name) != "scanknit") return;  // others that it starts are not ours
    const std::string_view name(text, static_cast<std::size_t>(colon - text));
    for (kind = 0; kind < kKinds && kFaults[static_cast<std::size_t>(kind)].name != name;) ++kind;
    char* end = nullptr;
    number = std::strtoul(colon + 1, &end, 10);
    goes_on = std::string_view(end) == ":on";
  }
};

/// Counts a call. True: it must fail, and errno says why.
bool fails(Kind kind) {
  static const Plan plan;
  if (opening > 0) return false;
  const unsigned long number = ++counts[kind];
  if (kind != plan.kind || number < plan.number || (number > plan.number && !plan.goes_on)) return false;
  errno = kFaults[kind].error;
  return true;
}

/// Pipes and terminals do not fail as disks do.
bool is_file(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode));
}

bool fails_on(int descriptor, Kind kind) {
  return is_file(descriptor) && fails(kind);
}

bool fails_to_get(std::size_t bytes) {
  return bytes >= kLarge && fails(kAlloc);
}

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int open_at(int folder, const char* path, int flags, mode_t mode) {
  return fails(kOpen) ? -1 : static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode));
}

mode_t mode_of(int flags, va_list& more) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
}

void* map(void* at, std::size_t bytes, int protection, int flags, int file, off_t offset) {
  const bool is_memory = (flags & MAP_ANONYMOUS) != 0;  // of an allocator: TBB's, for one
  if (is_memory ? fails_to_get(bytes) : fails(kMmap)) return MAP_FAILED;
  return reinterpret_cast<void*>(::syscall(SYS_mmap, at, bytes, protection, flags, file, offset));
}

void write_counts() {
  const char* path = std::getenv("SCANKNIT_FAULT_COUNTS");
  if (path == nullptr) return;
  const int file = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC, 0600));
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    std::array<char, 64> line{};
    const int size =
        std::snprintf(line.data(), line.size(), "%s %lu\n", kFaults[kind].name.data(), counts[kind].load());
    ::syscall(SYS_write, file, line.data(), size);
  }
  ::syscall(SYS_close, file);
}

struct AtEnd {
  ~AtEnd() { write_counts(); }
} at_end;

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  return open_at(AT_FDCWD, path, flags, mode);
}
int open64(const char* path, int flags, ...) __attribute__((alias("open")));

int openat(int folder, const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  return open_at(folder, path, flags, mode);
}
int openat64(int folder, const char* path, int flags, ...) __attribute__((alias("openat")));

int __open_2(const char* path, int flags) {
  return open_at(AT_FDCWD, path, flags, 0);
}
int __open64_2(const char* path, int flags) __attribute__((alias("__open_2")));

int mkostemp(char* pattern, int flags) {
  return fails(kOpen) ? -1 : next<int(char*, int)>("mkostemp")(pattern, flags);
}
int mkostemp64(char* pattern, int flags) __attribute__((alias("mkostemp")));

FILE* fopen(const char* path, const char* mode) {
  return fails(kOpen) ? nullptr : next<FILE*(const char*, const char*)>("fopen")(path, mode);
}
FILE* fopen64(const char* path, const char* mode) __attribute__((alias("fopen")));

DIR* opendir(const char* path) {
  return fails(kOpen) ? nullptr : next<DIR*(const char*)>("opendir")(path);
}

ssize_t read(int file, void* to, std::size_t bytes) {
  return fails_on(file, kRead) ? -1 : ::syscall(SYS_read, file, to, bytes);
}
ssize_t pread(int file, void* to, std::size_t bytes, off_t offset) {
  return fails_on(file, kRead) ? -1 : ::syscall(SYS_pread64, file, to, bytes, offset);
}
ssize_t pread64(int file, void* to, std::size_t bytes, off_t offset) __attribute__((alias("pread")));

ssize_t write(int file, const void* from, std::size_t bytes) {
  return fails_on(file, kWrite) ? -1 : ::syscall(SYS_write, file, from, bytes);
}
ssize_t pwrite(int file, const void* from, std::size_t bytes, off_t offset) {
  return fails_on(file, kWrite) ? -1 : ::syscall(SYS_pwrite64, file, from, bytes, offset);
}
ssize_t pwrite64(int file, const void* from, std::size_t bytes, off_t offset) __attribute__((alias("pwrite")));
ssize_t writev(int file, const iovec* parts, int count) {
  return fails_on(file, kWrite) ? -1 : ::syscall(SYS_writev, file, parts, count);
}

int fsync(int file) {
  return fails(kSync) ? -1 : static_cast<int>(::syscall(SYS_fsync, file));
}
int fdatasync(int file) {
  return fails(kSync) ? -1 : static_cast<int>(::syscall(SYS_fdatasync, file));
}

int rename(const char* from, const char* to) noexcept {
  return fails(kRename) ? -1 : static_cast<int>(::syscall(SYS_rename, from, to));
}
int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
  return fails(kRename) ? -1 : static_cast<int>(::syscall(SYS_renameat, from_folder, from, to_folder, to));
}

/// The descriptor is gone all the same, as on Linux.
int close(int file) {
  const bool is_faulty = fails_on(file, kClose);
  const int closed = static_cast<int>(::syscall(SYS_close, file));
  if (!is_faulty) return closed;
  errno = kFaults[kClose].error;
  return -1;
}

void* dlopen(const char* path, int mode) noexcept {
  ++opening;
  void* library = next<void*(const char*, int)>("dlopen")(path, mode);
  --opening;
  return library;
}

int ftruncate(int file, off_t size) noexcept {
  return fails(kTruncate) ? -1 : static_cast<int>(::syscall(SYS_ftruncate, file, size));
}
int ftruncate64(int file, off_t size) noexcept __attribute__((alias("ftruncate")));
int fallocate(int file, int mode, off_t offset, off_t size) {
  return fails(kTruncate) ? -1 : static_cast<int>(::syscall(SYS_fallocate, file, mode, offset, size));
}
int fallocate64(int file, int mode, off_t offset, off_t size) __attribute__((alias("fallocate")));

void* mmap(void* at, std::size_t bytes, int protection, int flags, int file, off_t offset) noexcept {
  return map(at, bytes, protection, flags, file, offset);
}
void* mmap64(void* at, std::size_t bytes, int protection, int flags, int file, off_t offset) noexcept
    __attribute__((alias("mmap")));

void* malloc(std::size_t bytes) noexcept {
  return fails_to_get(bytes) ? nullptr : __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) noexcept {
  const bool is_large = bytes != 0 && count >= kLarge / bytes + (kLarge % bytes != 0);
  return is_large && fails(kAlloc) ? nullptr : __libc_calloc(count, bytes);
}
void* realloc(void* old, std::size_t bytes) noexcept {
  return fails_to_get(bytes) ? nullptr : __libc_realloc(old, bytes);
}
void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  return fails_to_get(bytes) ? nullptr : __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept __attribute__((alias("memalign")));
int posix_memalign(void** to, std::size_t alignment, std::size_t bytes) noexcept {
  void* memory = memalign(alignment, bytes);
  if (memory == nullptr) return ENOMEM;
  *to = memory;
  return 0;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*), void* argument) noexcept {
  using Create = int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  return fails(kThread) ? kFaults[kThread].error : next<Create>("pthread_create")(thread, attributes, work, argument);
}
}
