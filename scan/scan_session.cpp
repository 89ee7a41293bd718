#include "scan/scan_session.h"

#include <algorithm>

namespace scanknit {

void ScanSession::warn(WarningCode code, std::string text) {
  const bool is_known = std::any_of(warnings_.begin(), warnings_.end(), [&](const Noted& noted) {
    return noted.mesh == kAnyMesh && noted.warning.code == code && noted.warning.text == text;
  });
  if (is_known) return;
  warnings_.push_back({{code, std::move(text)}, kAnyMesh});
  observer_.on_warning(warnings_.back().warning);
}

void ScanSession::warn_of_mesh(WarningCode code, std::string_view step, std::string text) {
  const bool is_news = reported_of_meshes_.emplace(code, step).second;
  warnings_.push_back({{code, std::move(text)}, mesh_});
  if (is_news) observer_.on_warning(warnings_.back().warning);
}

std::vector<ScanWarning> ScanSession::warnings() const {
  std::vector<ScanWarning> valid;
  for (const Noted& noted : warnings_) {
    if (noted.mesh == kAnyMesh || noted.mesh == mesh_) valid.push_back(noted.warning);
  }
  return valid;
}

ScanResult ScanSession::conclude(Result<void> outcome, const ScanJob& job, ScanResult result) const {
  result.outcome = std::move(outcome);
  if (result.input.empty()) result.input = job.input.string();
  result.config = job.config;
  const std::vector<ScanWarning> warned = warnings();
  result.warnings.insert(result.warnings.begin(), warned.begin(), warned.end());
  add_times(times_, result.stages);
  for (const auto& [kind, path] : result.mesh.files) result.files[kind] = path;
  return result;
}

}  // namespace scanknit
