// Running the built scanknit with modules of a test's own, or with none.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/app/program.h"
#include "tests/support/places.h"

namespace scanknit {

/// The program finds libscanknit_core.so in this folder, and so looks here for modules. The only ones are
/// its commands.
class ModuleFolder {
 public:
  ModuleFolder() {
    const auto libraries = std::filesystem::path(test::kProgram).parent_path().parent_path() / "lib";
    for (const auto& entry : std::filesystem::directory_iterator(libraries)) {
      const std::string name = entry.path().filename().string();
      const bool is_core = name.starts_with("libscanknit_core.so.");
      const bool has_commands = name.starts_with("libscanknit_") && name.ends_with("commands.so");
      if (is_core || has_commands) std::filesystem::create_symlink(entry.path(), folder_ / name);
      is_used_ = is_used_ || is_core;
    }
  }

  /// False in a static build, whose program looks beside itself only.
  [[nodiscard]] bool is_used() const { return is_used_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

  [[nodiscard]] Outcome run(const std::vector<std::string>& arguments) const {
    const char* before = std::getenv("LD_LIBRARY_PATH");
    const std::string kept = before == nullptr ? "" : before;
    ::setenv("LD_LIBRARY_PATH", (folder_.path().string() + (kept.empty() ? "" : ":" + kept)).c_str(), 1);
    Outcome outcome = scanknit_command(arguments);
    if (before == nullptr) {
      ::unsetenv("LD_LIBRARY_PATH");
    } else {
      ::setenv("LD_LIBRARY_PATH", kept.c_str(), 1);
    }
    return outcome;
  }

 private:
  TempFolder folder_;
  bool is_used_ = false;
};

}  // namespace scanknit
