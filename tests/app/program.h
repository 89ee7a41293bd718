// Running the built scanknit as a user would: arguments in; exit code, stdout and stderr out.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace scanknit {

struct Outcome {
  int exit_code = -1;  ///< 128 + signal when a signal ended it
  std::string out, err;
};

/// A folder of its own under the test's temporary folder, removed at the end.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// A scanknit that runs in the background, with nothing on its stdin until something is typed. Ended and waited for at
/// the latest when destroyed.
class Program {
 public:
  /// `max_file_bytes` stands in for a full disk: writing beyond it fails.
  explicit Program(const std::vector<std::string>& arguments, std::optional<std::uintmax_t> max_file_bytes = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  [[nodiscard]] std::string err_so_far() const;
  [[nodiscard]] bool is_running();
  [[nodiscard]] pid_t process() const { return process_; }
  void send(int signal) const;
  void type(const std::string& text) const;
  /// After stdin has ended.
  [[nodiscard]] Outcome wait();

 private:
  TempFolder folder_;
  pid_t process_ = -1;
  int keyboard_ = -1;  ///< writes to its stdin
  std::optional<int> status_;
};

[[nodiscard]] Outcome scanknit_command(const std::vector<std::string>& arguments,
                                       std::optional<std::uintmax_t> max_file_bytes = {});

[[nodiscard]] std::string read_text(const std::filesystem::path& path);

}  // namespace scanknit
