#include "scan/scan_session.h"

#include <algorithm>

namespace scanknit {

void ScanSession::warn(WarningCode code, std::string text) {
  const bool is_known = std::any_of(warnings_.begin(), warnings_.end(), [&](const ScanWarning& warning) {
    return warning.code == code && warning.text == text;
  });
  if (is_known) return;
  warnings_.push_back({code, std::move(text)});
  observer_.on_warning(warnings_.back());
}

ScanWarning ScanSession::warn_of_mesh(WarningCode code, std::string_view step, std::string text) {
  ScanWarning warning{code, std::move(text)};
  if (reported_mesh_warnings_.emplace(code, step).second) observer_.on_warning(warning);
  return warning;
}

ScanResult ScanSession::conclude(Result<void> outcome, const ScanJob& job, ScanResult result) const {
  result.outcome = std::move(outcome);
  if (result.input.empty()) result.input = job.input.string();
  result.config = job.config;
  result.warnings.insert(result.warnings.begin(), warnings_.begin(), warnings_.end());
  result.warnings.insert(result.warnings.end(), result.mesh.warnings.begin(), result.mesh.warnings.end());
  add_times(times_, result.stages);
  for (const auto& [kind, path] : result.mesh.files) result.files[kind] = path;
  return result;
}

}  // namespace scanknit
