#include "scan/job/brick_claim.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using FileTime = std::chrono::nanoseconds;

FileTime modified(const struct stat& status) {
  return std::chrono::seconds(status.st_mtim.tv_sec) + std::chrono::nanoseconds(status.st_mtim.tv_nsec);
}

Error not_writable(const fs::path& path) {
  return {ErrorCode::kOutput, std::string("the job's folder cannot be written: ") + std::strerror(errno),
          path.parent_path().string()};
}

/// The time of the folder's file system: of a file that is written there now.
Result<FileTime> time_in(const fs::path& folder) {
  std::string path = (folder / ".time.XXXXXX").string();
  const int descriptor = ::mkstemp(path.data());
  struct stat status {};
  const bool is_known = descriptor >= 0 && ::write(descriptor, "t", 1) == 1 && ::fsync(descriptor) == 0 &&
                        ::fstat(descriptor, &status) == 0;
  const int fault = errno;
  if (descriptor >= 0) {
    ::close(descriptor);
    ::unlink(path.c_str());
  }
  errno = fault;
  if (!is_known) return not_writable(folder / "time");
  return modified(status);
}

bool is_alive(const struct stat& status, FileTime now) {
  return std::chrono::abs(now - modified(status)) <= BrickClaim::kLease;
}

/// -1: there is one, or errno says why not.
int create_claim(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
  if (descriptor < 0) return -1;
  char host[256] = "";
  (void)::gethostname(host, sizeof(host) - 1);
  const std::string text = std::string(host) + " " + std::to_string(::getpid()) + "\n";  // for people
  if (::write(descriptor, text.data(), text.size()) >= 0) return descriptor;
  const int fault = errno;
  ::close(descriptor);
  ::unlink(path.c_str());
  errno = fault;
  return -1;
}

/// Moves a dead worker's claim away. If it turns out that another worker has just replaced it, puts that one back.
Result<void> remove_dead(const fs::path& path, FileTime now) {
  std::string aside = path.string() + ".old.XXXXXX";
  const int descriptor = ::mkstemp(aside.data());
  if (descriptor < 0) return not_writable(path);
  ::close(descriptor);
  struct stat moved {};
  const bool is_moved = ::rename(path.c_str(), aside.c_str()) == 0 && ::stat(aside.c_str(), &moved) == 0;
  if (is_moved && is_alive(moved, now)) (void)::link(aside.c_str(), path.c_str());
  ::unlink(aside.c_str());
  return {};
}

}  // namespace

Result<std::unique_ptr<BrickClaim>> BrickClaim::take(const fs::path& path) {
  int descriptor = create_claim(path);
  if (descriptor < 0 && errno == EEXIST) {
    const auto now = time_in(path.parent_path());
    if (!now) return now.error();
    struct stat status {};
    if (::stat(path.c_str(), &status) == 0) {
      if (is_alive(status, *now)) return std::unique_ptr<BrickClaim>();
      if (auto removed = remove_dead(path, *now); !removed) return removed.error();
    }
    descriptor = create_claim(path);
  }
  if (descriptor < 0 && errno == EEXIST) return std::unique_ptr<BrickClaim>();
  if (descriptor < 0) return not_writable(path);
  try {
    return std::unique_ptr<BrickClaim>(new BrickClaim(path, descriptor));
  } catch (const std::system_error& fault) {  // no thread is left to renew it
    ::unlink(path.c_str());
    ::close(descriptor);
    return Error{ErrorCode::kBudget, std::string("no thread is left: ") + fault.what(), path.string()};
  }
}

Result<bool> BrickClaim::is_taken(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return false;
  const auto now = time_in(path.parent_path());
  return now ? Result<bool>(is_alive(status, *now)) : now.error();
}

BrickClaim::BrickClaim(fs::path path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor), renewer_([this](const std::stop_token& stop) { renew(stop); }) {}

void BrickClaim::renew(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!ended_.wait_for(lock, stop, kRenewal, [&] { return stop.stop_requested(); })) {
    (void)::futimens(descriptor_, nullptr);  // should that fail, another worker may do the same work
  }
}

BrickClaim::~BrickClaim() {
  renewer_.request_stop();
  renewer_.join();
  struct stat own {
  }, there{};
  const bool is_own = ::fstat(descriptor_, &own) == 0 && ::stat(path_.c_str(), &there) == 0 &&
                      own.st_ino == there.st_ino && own.st_dev == there.st_dev;
  if (is_own) ::unlink(path_.c_str());
  ::close(descriptor_);
}

}  // namespace scanknit
