// ScanConsole: what a scan tells, on the console.
#pragma once

#include <cstddef>
#include <string_view>

#include "app/terminal/console.h"
#include "scan/scan_observer.h"

namespace scanknit {

class ScanConsole final : public ScanObserver {
 public:
  explicit ScanConsole(Verbosity verbosity) : console_(verbosity) {}

  void on_message(LogLevel level, std::string_view text) override { console_.say(level, text); }
  void on_warning(const ScanWarning& warning) override { console_.warn(warning.text); }
  void on_progress(std::string_view what, std::size_t done, std::size_t total) override {
    console_.progress(what, done, total);
  }
  [[nodiscard]] bool needs_volume_after_mesh() const override { return false; }

 private:
  Console console_;
};

}  // namespace scanknit
